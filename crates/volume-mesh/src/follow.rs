//! Interior nodes that follow the boundary, step by step, without inverting a cell.
//!
//! Each step solves for the elastic equilibrium at the present positions and goes as far towards it
//! as no cell falls below a share of its scaled Jacobian at the start: the whole way, or half of it,
//! and so on, once nodes inside have been moved to where cells in the way are less flat.
//! Boundary and interior move together, so that every state on the way is a mesh.

use glam::DVec3;
use surface::progress::Progress;

use crate::elastic::ElasticBody;
use crate::{Boundary, MeshQuality, VolumeError, VolumeMesh};

/// Parameters of an interior that follows its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowParams {
    /// Poisson's ratio of the elastic body, in `-1.0..0.5`. More keeps volumes of cells better;
    /// near 0.5 the solver takes many steps.
    pub poisson_ratio: f64,
    /// Share of its scaled Jacobian at the start that each cell keeps, in `0.0..1.0`. More keeps
    /// better cells and cuts steps earlier; 0 lets cells become thin, but not flat.
    pub min_jacobian_share: f64,
    /// Maximum number of steps. Fewer give up earlier where steps are cut.
    pub max_steps: u32,
}

impl Default for FollowParams {
    /// Returns a ratio of 0.3, a share of a tenth, and 24 steps.
    fn default() -> Self {
        Self { poisson_ratio: 0.3, min_jacobian_share: 0.1, max_steps: 24 }
    }
}

/// Cell that keeps a mesh from following its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockingCell {
    /// Index of the cell.
    pub cell: usize,
    /// Its scaled Jacobian after the step that was cut.
    pub scaled_jacobian: f64,
    /// Scaled Jacobian that it must keep.
    pub limit: f64,
}

/// Volume mesh behind its boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Positions of all nodes.
    pub positions: Vec<DVec3>,
    /// Share of the boundary's displacement that the mesh has followed, 1 for all of it.
    pub share: f64,
    /// Number of steps.
    pub steps: u32,
    /// Quality at the start.
    pub before: MeshQuality,
    /// Quality at the positions.
    pub after: MeshQuality,
    /// Cell in the way, where the share is below 1.
    pub blocking: Option<BlockingCell>,
}

/// Smallest part of a step that is taken: less would hardly move, more would give up where the
/// equilibrium of the next step leads around.
const MIN_STEP: f64 = 1.0 / 64.0;

/// Smallest share of the displacement that a step gains. Below, steps that lead nowhere take long; above, slow ones
/// are given up.
const MIN_GAIN: f64 = 1.0 / 256.0;

/// Scaled Jacobian below which a cell is nearly flat \[its limit\]. Below, cells that are just open stay so; above, nodes of
/// good cells move, too.
pub(crate) const NEARLY_FLAT: f64 = 3.0;

impl VolumeMesh {
    /// Moves the nodes inside after those of the boundary, from `rest` to `target`, the positions of
    /// the boundary's nodes.
    ///
    /// Where a displacement is linear in space, so is that of the interior. Nothing moves where the
    /// boundary stays. Nodes in the middle of edges that move are then in the middle to the rounding.
    ///
    /// # Errors
    ///
    /// - [`VolumeError::Inverted`] for cells that are inverted or flat at the start;
    /// - [`VolumeError::Count`], [`VolumeError::NotFinite`] and [`VolumeError::Parameter`];
    /// - [`VolumeError::Interrupted`] when the handler of `progress` ends the call.
    ///
    /// # Panics
    ///
    /// When `boundary` has a node that the mesh has not.
    pub fn follow(
        &self,
        rest: &[DVec3],
        boundary: &Boundary,
        target: &[DVec3],
        params: &FollowParams,
        progress: Progress<'_>,
    ) -> Result<Followed, VolumeError> {
        params.validate()?;
        check_count("nodes", self.node_count(), rest)?;
        check_count("nodes of the boundary", boundary.nodes.len(), target)?;
        if let Some(place) = target.iter().position(|x| !x.is_finite()) {
            return Err(VolumeError::NotFinite { node: boundary.nodes[place] as usize });
        }
        let mut used = self.cells().iter().flat_map(|cell| cell.nodes());
        if let Some(&node) = used.find(|node| !rest[**node as usize].is_finite()) {
            return Err(VolumeError::NotFinite { node: node as usize });
        }
        let limits = self.limits(rest, params)?;

        // Nodes without a cell stay, as the given ones do.
        let mut is_given = vec![true; rest.len()];
        for cell in self.cells() {
            for &node in cell.nodes() {
                is_given[node as usize] = false;
            }
        }
        for &node in &boundary.nodes {
            is_given[node as usize] = true;
        }

        // Each step starts from the present shape, so that large displacements turn cells, too.
        let before = self.quality(rest);
        let (positions, share, blocking) = (rest.to_vec(), 0.0, None);
        let mut followed = Followed { positions, share, steps: 0, before, after: before, blocking };
        while followed.share < 1.0 && followed.steps < params.max_steps {
            let u = boundary.displacements(&followed.positions, target);
            if u.iter().all(|u| *u == DVec3::ZERO) {
                followed.share = 1.0;
                break;
            }
            let body = ElasticBody::new(self, &followed.positions, params.poisson_ratio);
            let u = body.equilibrium(u, &is_given, progress_of_step(progress, followed.steps))?;
            followed.steps += 1;
            let share = followed.share;
            self.advance(&mut followed, &u, &is_given, &limits);
            if followed.share < share + MIN_GAIN {
                break;
            }
        }

        // The end of the whole way is the target, to the bit.
        if followed.share >= 1.0 {
            followed.blocking = None;
            for (&node, x) in boundary.nodes.iter().zip(target) {
                followed.positions[node as usize] = *x;
            }
        }
        self.move_middle_nodes(rest, &mut followed.positions);
        followed.after = self.quality(&followed.positions);
        Ok(followed)
    }

    /// Moves nodes to the middle of edges of which an end has moved.
    fn move_middle_nodes(&self, rest: &[DVec3], positions: &mut [DVec3]) {
        for middle in self.middle_nodes() {
            if middle.ends.iter().any(|&end| positions[end as usize] != rest[end as usize]) {
                positions[middle.node as usize] = middle.middle(positions);
            }
        }
    }

    /// Returns the scaled Jacobian that each cell must keep.
    fn limits(&self, rest: &[DVec3], params: &FollowParams) -> Result<Vec<f64>, VolumeError> {
        let quality = self.quality(rest);
        if quality.inverted > 0 {
            return Err(VolumeError::Inverted {
                count: quality.inverted,
                cell: quality.worst_cell,
                scaled_jacobian: quality.min_scaled_jacobian,
            });
        }
        let mut limits = self.scaled_jacobians(rest);
        for limit in &mut limits {
            *limit *= params.min_jacobian_share;
        }
        Ok(limits)
    }

    /// Moves all nodes along their displacements, as far as cells keep their limits and nodes inside give way to them.
    fn advance(&self, followed: &mut Followed, u: &[DVec3], is_given: &[bool], limits: &[f64]) {
        let mut step = 1.0;
        while step >= MIN_STEP {
            let mut positions = Vec::with_capacity(u.len());
            for (x, u) in followed.positions.iter().zip(u) {
                positions.push(*x + step * *u);
            }
            let mut blocking = self.first_below(&positions, limits);
            if blocking.is_some() {
                self.open_cells(&mut positions, is_given, limits);
                blocking = self.first_below(&positions, limits);
            }
            let Some(blocking) = blocking else {
                followed.positions = positions;
                followed.share = 1.0 - (1.0 - followed.share) * (1.0 - step);
                return;
            };
            followed.blocking = Some(blocking);
            step *= 0.5;
        }
    }

    /// Returns the cell that is the farthest below its limit.
    fn first_below(&self, positions: &[DVec3], limits: &[f64]) -> Option<BlockingCell> {
        let mut worst: Option<BlockingCell> = None;
        for (cell, scaled_jacobian) in self.scaled_jacobians(positions).into_iter().enumerate() {
            let limit = limits[cell];
            let is_worse = worst
                .is_none_or(|worst| scaled_jacobian - limit < worst.scaled_jacobian - worst.limit);
            // A limit of 0 keeps cells from becoming flat, too.
            if (scaled_jacobian < limit || scaled_jacobian <= 0.0) && is_worse {
                worst = Some(BlockingCell { cell, scaled_jacobian, limit });
            }
        }
        worst
    }
}

impl Boundary {
    /// Returns the displacements of all nodes that bring those of the boundary to their targets.
    fn displacements(&self, positions: &[DVec3], target: &[DVec3]) -> Vec<DVec3> {
        let mut u = vec![DVec3::ZERO; positions.len()];
        for (&node, target) in self.nodes.iter().zip(target) {
            u[node as usize] = *target - positions[node as usize];
        }
        u
    }
}

impl FollowParams {
    /// Checks that all parameters are in their ranges.
    fn validate(&self) -> Result<(), VolumeError> {
        let Self { poisson_ratio, min_jacobian_share, .. } = *self;
        let (name, value, range) = if !(-1.0 < poisson_ratio && poisson_ratio < 0.5) {
            ("poisson_ratio", poisson_ratio, "between -1 and 0.5")
        } else if !(0.0..1.0).contains(&min_jacobian_share) {
            ("min_jacobian_share", min_jacobian_share, "at least 0 and below 1")
        } else {
            return Ok(());
        };
        Err(VolumeError::Parameter { name, value, range })
    }
}

/// Returns the handle of a step: half of what is left, since others may follow.
fn progress_of_step(progress: Progress<'_>, steps_before: u32) -> Progress<'_> {
    let left = 0.5_f64.powf(f64::from(steps_before));
    progress.part(1.0 - left, 1.0 - 0.5 * left)
}

fn check_count(of: &'static str, expected: usize, given: &[DVec3]) -> Result<(), VolumeError> {
    let found = given.len();
    if found == expected { Ok(()) } else { Err(VolumeError::Count { of, expected, found }) }
}
