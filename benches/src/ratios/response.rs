//! Contact responses: sweeps of the solver beside plain memory and from few contacts to many, and
//! permanent contacts beside new detection.

use std::error::Error;
use std::hint::black_box;

use ::response::{
    ContactLaw, ContactRows, ContactSystem, GapMeasure, Impulse, LinearForces, Margins,
    NormalForce, PermanentContacts, ResponseError, SoftContacts, SoftLaw, SolveLevel, SolverParams,
    SurfaceCarrier, SweepOrder,
};
use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;

use crate::measure::{Report, Sides, as_f64};
use crate::sheets::Sheets;

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 1500;

/// Vertices along the sides of the sheets; contacts are their squares.
const SIDES: [u32; 4] = [32, 100, 316, 1000];

/// Sweeps per solution with default parameters.
const SWEEPS: usize = 10;

type Outcome = Result<(), Box<dyn Error>>;

/// Compares solutions of sheets pressed together.
pub(super) fn run(report: &mut Report) -> Outcome {
    // From a thousand contacts to a million.
    let mut sweep_times = Vec::new();
    for side in SIDES {
        sweep_times.push(sweeps(&Sheets::new(side)?, report)?);
    }
    let [few, .., many] = sweep_times[..] else { return Ok(()) };
    let growth = [many.solver / few.solver, many.memory / few.memory];
    report.ratio("growth from 1k to 1M contacts / plain", growth, "x", 1.5);

    // The rest with ten thousand contacts.
    let sheets = Sheets::new(100)?;
    preparation(&sheets, report)?;
    warm_start(&sheets, report)?;
    products(&sheets, report)?;
    permanent(sheets, report)
}

/// Time of one sweep per contact \[ns\], and that to read and write as many bytes.
#[derive(Clone, Copy)]
struct SweepTime {
    solver: f64,
    memory: f64,
}

/// Compares ten sweeps with the memory that they read and write, and ten sweeps of 10,000
/// contacts with 5 ms.
fn sweeps(sheets: &Sheets, report: &mut Report) -> Result<SweepTime, Box<dyn Error>> {
    let rows = sheets.rows()?;
    let mut solver = Solver::new(&rows, sheets)?;

    // A contact's row, bias and impulse, its four terms, and their particles read and written.
    let words = (64 + 24 + 2 * 32 + 4 * 24 + 4 * 2 * 24) / 8;
    let mut memory = vec![1.0_f64; words * rows.len()];
    let mut add_to_all = || {
        for _ in 0..SWEEPS {
            for word in black_box(&mut memory) {
                *word += 1.0;
            }
        }
        memory.len()
    };

    let count = rows.len();
    let name = format!("10 sweeps, {count} contacts / plain");
    let sides: Sides<'_> = [&mut || solver.solve(), &mut add_to_all];
    let [ours, plain] = report.compare(&name, BUDGET, 6.0, sides);
    if count == 10_000 {
        report.times("10 sweeps, 10000 contacts / 5 ms", [ours, 5e6], 1.0);
    }
    let per_contact = 1.0 / as_f64(SWEEPS * count);
    Ok(SweepTime { solver: ours * per_contact, memory: plain * per_contact })
}

/// Compares rows and system from contacts with ten sweeps of them.
fn preparation(sheets: &Sheets, report: &mut Report) -> Outcome {
    let rows = sheets.rows()?;
    let mut solver = Solver::new(&rows, sheets)?;
    let mut prepare = || {
        let Ok(rows) = sheets.rows() else { return 0 };
        Solver::new(&rows, sheets).map_or(0, |solver| solver.system.batch_count())
    };
    let sides: Sides<'_> = [&mut prepare, &mut || solver.solve()];
    report.compare("preparing 10k contacts / 10 sweeps", BUDGET, 2.0, sides);
    Ok(())
}

/// Contacts of sheets with velocities and impulses, which are solved again and again.
struct Solver<'a> {
    sheets: &'a Sheets,
    system: ContactSystem,
    v: Vec<DVec3>,
    impulses: Vec<Impulse>,
}

impl<'a> Solver<'a> {
    fn new(rows: &ContactRows, sheets: &'a Sheets) -> Result<Self, ResponseError> {
        let system = ContactSystem::new(rows, &sheets.inverse_mass, SweepOrder::Colored)?;
        let impulses = system.no_impulses();
        Ok(Self { sheets, system, v: sheets.v.clone(), impulses })
    }

    /// Solves from the start with default parameters; returns 1 if it converges.
    fn solve(&mut self) -> usize {
        self.v.copy_from_slice(&self.sheets.v);
        self.impulses.fill(Impulse::default());
        let params = SolverParams::default();
        let Self { system, v, impulses, .. } = self;
        let solved = system.solve(SolveLevel::Velocity, v, impulses, &params);
        usize::from(solved.expect("sheets are valid").converged)
    }
}

/// Compares sweeps to the same residual, warm started from the step before and cold.
fn warm_start(sheets: &Sheets, report: &mut Report) -> Outcome {
    let rows = sheets.rows()?;
    let system = ContactSystem::new(&rows, &sheets.inverse_mass, SweepOrder::Colored)?;
    let params = SolverParams { max_iterations: 1000, tolerance: 1e-9, ..Default::default() };
    let mut impulses = system.no_impulses();
    let cold = system.solve(SolveLevel::Velocity, &mut sheets.v.clone(), &mut impulses, &params)?;

    // In the next step all velocities are 1 % larger.
    let mut next = sheets.v.clone();
    for v in &mut next {
        *v *= 1.01;
    }
    let warm = system.solve(SolveLevel::Velocity, &mut next, &mut impulses, &params)?;
    let sweeps = [warm, cold].map(|report| f64::from(report.iterations));
    report.ratio("sweeps to 1e-9, warm / cold", sweeps, "sweeps", 1.0);
    Ok(())
}

/// Compares K dx without a matrix with stored blocks that are multiplied.
fn products(sheets: &Sheets, report: &mut Report) -> Outcome {
    let mut rows = ContactRows::new(sheets.x.len());
    rows.extend(&sheets.contacts, ContactLaw::new(Margins::new(0.1, 1.0)?, 0.0)?)?;
    let law = SoftLaw::new(NormalForce::Penalty { stiffness: 10.0, damping: 0.0 }, 1.0)?;
    let soft = SoftContacts::new(&rows, &sheets.v, law)?;
    let blocks = soft.stiffness_blocks();

    // The blocks are built beforehand: only their products are timed.
    let mut free = vec![DVec3::ZERO; sheets.x.len()];
    let mut stored = free.clone();
    report.compare(
        "K dx without a matrix / from blocks",
        BUDGET,
        1.0,
        [
            &mut || {
                soft.add_stiffness(&sheets.v, &mut free);
                free.len()
            },
            &mut || {
                for block in &blocks {
                    stored[block.row as usize] += block.value * sheets.v[block.column as usize];
                }
                stored.len()
            },
        ],
    );
    Ok(())
}

/// Compares sticking and sliding of permanent contacts with new detection of each in a tree that
/// is refitted.
fn permanent(mut sheets: Sheets, report: &mut Report) -> Outcome {
    let margins = Margins::new(0.0, 1.0)?;
    let keep = |sheets: &Sheets| {
        PermanentContacts::new(&sheets.contacts, &sheets.x, GapMeasure::AlongNormal, margins)
    };
    let (mut sticking, mut sliding) = (keep(&sheets)?, keep(&sheets)?);

    // The upper sheet has slipped by a third of an edge.
    let first = sheets.first_lower as usize;
    for x in &mut sheets.x[..first] {
        *x += DVec3::new(-0.33, 0.2, 0.0);
    }
    let (upper, lower) = sheets.x.split_at(first);
    let on = sheets.lower.positions(lower)?;

    // New detection refits a tree, and finds the closest face of each vertex.
    let carrier = SurfaceCarrier::Particles { first: sheets.first_lower };
    let mut tree = SurfaceTree::new(sheets.lower.clone(), lower.to_vec())?;
    let mut workspace = Workspace::default();
    let [stuck, slid, found] = report.interleave(
        "10k contacts",
        BUDGET,
        [
            ("stick", &mut || usize::from(sticking.stick(&sheets.x).is_ok())),
            ("slide", &mut || {
                usize::from(sliding.slide(&sheets.x, &sheets.lower, on, carrier).is_ok())
            }),
            ("found anew", &mut || {
                let mut faces = usize::from(tree.set_positions(lower.iter().copied()).is_ok());
                for &p in upper {
                    let closest = tree.closest_point(p, f64::INFINITY, None, &mut workspace);
                    faces += closest.map_or(0, |closest| closest.face as usize);
                }
                faces
            }),
        ],
    );
    report.times("10k contacts stick / found anew", [stuck, found], 0.2);
    report.times("10k contacts slide / found anew", [slid, found], 1.0);
    Ok(())
}
