//! Scenes of named bodies.

use std::sync::MutexGuard;

use musculo_collide::ccd::CcdParams;
use musculo_collide::{
    BodyId, BodyKind, BodyStiffness, CheckParams, Conditions, FixedVertices, JointContactParams,
    PairId, PathMove, ResolveParams, Resolver, Tie,
};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{Faces, Points, corners, point_array, points, row_array, surface};
use crate::call::{Call, count, short};
use crate::error::refused;
use crate::exclusive::Exclusive;
use crate::joint::{self, Cartilage};
use crate::motion::{Motion, Placement};
use crate::{record, resolution};

/// Settings of overlap removal, as Python has them.
#[derive(Debug, FromPyObject)]
struct ResolveSettings {
    smoothing: f64,
    tolerance: Option<f64>,
    gap: f64,
    max_rounds: i64,
    max_volume_change: f64,
    max_strain: f64,
    max_displacement: f64,
    keep_going: bool,
}

/// Conditions of overlap removal by the names of bodies, as Python has them.
#[derive(Debug, FromPyObject)]
struct ResolveConditions {
    /// Vertices that stay.
    fixed: Vec<(String, Vec<u32>)>,
    /// Pairs that are attached, with their distances.
    ties: Vec<(String, String, f64)>,
    stiffnesses: Vec<(String, f64)>,
    uncrossed: Vec<String>,
}

/// Bodies of a scene, with the native calls on them.
#[pyclass(frozen, subclass, module = "musculo_collide._native")]
#[derive(Debug, Default)]
pub(crate) struct Scene(Exclusive<Bodies>);

/// Library's scene, found by names.
#[derive(Debug, Default)]
pub(crate) struct Bodies {
    pub(crate) scene: musculo_collide::Scene,
}

#[pymethods]
impl Scene {
    /// Makes a scene without bodies. Arguments are those of a subclass.
    #[new]
    #[pyo3(signature = (*_arguments, **_named))]
    fn new(_arguments: &Bound<'_, PyTuple>, _named: Option<&Bound<'_, PyDict>>) -> Self {
        Self::default()
    }

    /// Adds a body of kind "rigid", "deformable" or "open".
    fn _add(
        &self,
        py: Python<'_>,
        name: &str,
        kind: &str,
        vertices: Points<'_>,
        faces: Faces<'_>,
    ) -> PyResult<()> {
        let mut held = self.hold()?;
        let kind = match kind {
            "rigid" => BodyKind::Rigid,
            "open" => BodyKind::Open,
            _ => BodyKind::Deformable,
        };
        let (x, corners) = (points(&vertices)?, corners(&faces)?);
        let scene = &mut held.scene;
        short(py, || {
            let surface = surface(&format!("body {name:?}"), x.len(), corners)?;
            let added = scene.add(name, kind, surface, x.to_vec());
            added.map(|_| ()).map_err(|error| error.to_string())
        })
    }

    /// Returns the names of all bodies, in the order they were added.
    fn _names(&self) -> PyResult<Vec<String>> {
        let held = self.hold()?;
        Ok(held.scene.bodies().iter().map(|body| body.name().to_owned()).collect())
    }

    fn _kind(&self, name: &str) -> PyResult<&'static str> {
        let held = self.hold()?;
        Ok(match held.scene.body(held.find(name)?).kind() {
            BodyKind::Rigid => "rigid",
            BodyKind::Deformable => "deformable",
            BodyKind::Open => "open",
        })
    }

    fn _vertices<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let held = self.hold()?;
        Ok(point_array(py, held.scene.body(held.find(name)?).positions()))
    }

    fn _faces<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let held = self.hold()?;
        Ok(row_array(py, held.scene.body(held.find(name)?).surface().faces()))
    }

    fn _move(&self, py: Python<'_>, name: &str, vertices: Points<'_>) -> PyResult<()> {
        let mut held = self.hold()?;
        let (body, x) = (held.find(name)?, points(&vertices)?);
        let scene = &mut held.scene;
        short(py, || scene.move_body(body, x))
    }

    fn _pose(&self, py: Python<'_>, name: &str, placement: Placement) -> PyResult<()> {
        let mut held = self.hold()?;
        let body = held.find(name)?;
        let scene = &mut held.scene;
        short(py, || scene.pose_body(body, &placement.pose()))
    }

    /// Returns the numbers of a body's particles: the first, and the one after the last.
    fn _particles(&self, name: &str) -> PyResult<(u32, u32)> {
        let held = self.hold()?;
        let particles = held.scene.body(held.find(name)?).particles();
        Ok((particles.start, particles.end))
    }

    fn _ignore(&self, a: &str, b: &str) -> PyResult<()> {
        let mut held = self.hold()?;
        let [a, b] = [held.find(a)?, held.find(b)?];
        held.scene.ignore(a, b);
        Ok(())
    }

    #[pyo3(signature = (margin, measures, depth_tolerance, threads, progress))]
    fn _check<'py>(
        &self,
        py: Python<'py>,
        margin: f64,
        measures: bool,
        depth_tolerance: Option<f64>,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let mut held = self.hold()?;
        let params = CheckParams { margin, measures, depth_tolerance };
        let scene = &mut held.scene;
        let reports =
            Call::new(threads, progress)?.run(py, |progress| scene.check(&params, progress))?;
        reports.iter().map(|report| record::pair(py, report, &held.scene)).collect()
    }

    /// Sweeps bodies, by their names, on their ways during a step.
    #[pyo3(signature = (moves, first_of_pairs, separation, threads, progress))]
    fn _sweep<'py>(
        &self,
        py: Python<'py>,
        moves: Vec<(String, Motion<'py>)>,
        first_of_pairs: bool,
        separation: f64,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut held = self.hold()?;
        // Bodies are moved while their ways are swept: paths keep where they were.
        let mut starts = Vec::with_capacity(moves.len());
        for (name, _) in &moves {
            let body = held.find(name)?;
            starts.push((body, held.scene.body(body).positions().to_vec()));
        }
        let mut paths = Vec::with_capacity(moves.len());
        for ((_, motion), (body, start)) in moves.iter().zip(&starts) {
            paths.push(motion.paths(held.scene.body(*body), start)?);
        }
        let mut ways = Vec::with_capacity(moves.len());
        for ((body, _), path) in starts.iter().zip(&paths) {
            ways.push(PathMove { body: *body, path: path.as_ref() });
        }

        let params = CcdParams { min_separation: separation, ..CcdParams::EXACT };
        let scene = &mut held.scene;
        let report = Call::new(threads, progress)?.run(py, |progress| {
            if first_of_pairs {
                scene.first_contacts(&ways, &params, progress)
            } else {
                scene.sweep_paths(&ways, &params, progress)
            }
        })?;
        record::sweep(py, &report, &held.scene)
    }

    /// Measures the contact of pairs of bodies, named in order.
    #[pyo3(signature = (pairs, margin, resolution, cartilage, threads, progress))]
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn _joint_contacts<'py>(
        &self,
        py: Python<'py>,
        pairs: Vec<(String, String)>,
        margin: f64,
        resolution: f64,
        cartilage: Option<Cartilage>,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<(Bound<'py, PyDict>, Bound<'py, PyDict>)>> {
        let mut held = self.hold()?;
        let mut ids = Vec::with_capacity(pairs.len());
        for (a, b) in &pairs {
            ids.push(held.pair(a, b)?);
        }
        let foundation = cartilage.map(|layer| layer.foundation()).transpose()?;
        let params = JointContactParams { margin, resolution, foundation };
        let scene = &mut held.scene;
        let found = Call::new(threads, progress)?
            .run(py, |progress| scene.joint_contacts(&ids, &params, progress))?;

        // The library has the body that was added first as the first of a pair.
        let mut contacts = Vec::with_capacity(found.len());
        for ((pair, (a, _)), [of_a, of_b]) in ids.iter().zip(&pairs).zip(&found) {
            let [of_a, of_b] = [joint::contact(py, of_a)?, joint::contact(py, of_b)?];
            let is_in_order = held.find(a)? == pair.a;
            contacts.push(if is_in_order { (of_a, of_b) } else { (of_b, of_a) });
        }
        Ok(contacts)
    }

    /// Pushes overlapping bodies apart, as the settings say and where the conditions allow.
    #[pyo3(signature = (settings, conditions, threads, progress))]
    fn _resolve<'py>(
        &self,
        py: Python<'py>,
        settings: ResolveSettings,
        conditions: ResolveConditions,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut held = self.hold()?;
        let conditions = held.conditions(conditions)?;
        let resolver = Resolver::new(settings.params()?).map_err(refused)?;
        let mut resolver = resolver.with_conditions(conditions);
        let scene = &mut held.scene;
        let found =
            Call::new(threads, progress)?.run(py, |progress| resolver.resolve(scene, progress))?;
        resolution::record(py, &found, &held.scene)
    }
}

impl Scene {
    /// Holds the scene for a call.
    pub(crate) fn hold(&self) -> PyResult<MutexGuard<'_, Bodies>> {
        self.0.hold("the scene")
    }
}

impl Bodies {
    /// Finds the pair of two bodies.
    pub(crate) fn pair(&self, a: &str, b: &str) -> PyResult<PairId> {
        let pair = PairId::new(self.find(a)?, self.find(b)?);
        if pair.a == pair.b {
            return Err(refused(format!("both bodies of a pair are {a:?}")));
        }
        Ok(pair)
    }

    /// Finds the bodies that conditions of overlap removal name.
    fn conditions(&self, conditions: ResolveConditions) -> PyResult<Conditions> {
        let ResolveConditions { fixed, ties, stiffnesses, uncrossed } = conditions;
        let mut conditions = Conditions::default();
        for (name, vertices) in fixed {
            let body = self.find(&name)?;
            let count = self.scene.body(body).positions().len();
            if let Some(vertex) = vertices.iter().find(|vertex| **vertex as usize >= count) {
                return Err(refused(format!("body {name:?} has no vertex {vertex}, but {count}")));
            }
            conditions.fixed.push(FixedVertices { body, vertices });
        }
        for (a, b, distance) in ties {
            // The first body follows the second: the order counts.
            self.pair(&a, &b)?;
            conditions.ties.push(Tie { bodies: [self.find(&a)?, self.find(&b)?], distance });
        }
        for (name, factor) in stiffnesses {
            conditions.stiffnesses.push(BodyStiffness { body: self.find(&name)?, factor });
        }
        for name in uncrossed {
            conditions.uncrossed.push(self.find(&name)?);
        }
        Ok(conditions)
    }

    /// Finds a body by its name.
    pub(crate) fn find(&self, name: &str) -> PyResult<BodyId> {
        self.scene.find(name).ok_or_else(|| {
            let names: Vec<&str> = self.scene.bodies().iter().map(|body| body.name()).collect();
            refused(format!("no body is named {name:?}; there are {names:?}"))
        })
    }
}

impl ResolveSettings {
    fn params(&self) -> PyResult<ResolveParams> {
        let default = ResolveParams::with_smoothing(self.smoothing);
        Ok(ResolveParams {
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            gap: self.gap,
            max_rounds: count(self.max_rounds, "max_rounds")?,
            max_volume_change: self.max_volume_change,
            max_strain: self.max_strain,
            max_displacement: self.max_displacement,
            keep_going: self.keep_going,
            ..default
        })
    }
}
