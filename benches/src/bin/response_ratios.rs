//! Responses to contact: cost of sweeps beside plain memory and from small to
//! large, and of carrying contacts beside finding them.
//!
//! One line a figure: name, ours, the other's, ratio, allowed, verdict.

use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Duration;

use benches::ratio::{Ratio, Report, Timing, amount, interleave};
use benches::response::scenes::Sheets;
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use response::{
    ContactLaw, ContactRows, ContactSystem, GapMeasure, Impulse, LinearForces, Margins,
    NormalForce, PermanentContacts, SoftContacts, SoftLaw, SolveLevel, SolverParams,
    SurfaceCarrier, SweepOrder,
};
use surface::closest_on_triangle;

const BUDGET: Duration = Duration::from_millis(1500);

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut report = Report::default();
    let per_contact: Vec<[f64; 2]> = [32, 100, 316, 1000]
        .into_iter()
        .map(|side| sweeps(&Sheets::new(side)?, &mut report))
        .collect::<Result<_, Box<dyn Error>>>()?;
    let [least, .., most] = per_contact[..] else { return Err("no sizes".into()) };
    let [ours, plain] = [0, 1].map(|side| most[side] / least[side]);
    report.add(&Ratio::new("growth from 1k to 1M contacts / plain", ours, plain, "x", 1.5));
    let sheets = Sheets::new(100)?;
    preparation(&sheets, &mut report)?;
    warm_start(&sheets, &mut report)?;
    products(&sheets, &mut report)?;
    carrying(sheets, &mut report)?;
    Ok(report.finish())
}

/// Ten sweeps beside reading and writing as many bytes, and for 10k contacts
/// beside 5 ms; returns both times of one sweep of a contact \[ns\].
fn sweeps(sheets: &Sheets, report: &mut Report) -> Result<[f64; 2], Box<dyn Error>> {
    let rows = sheets.rows()?;
    let system = ContactSystem::new(&rows, &sheets.inverse_mass, SweepOrder::Colored)?;
    let mut v = sheets.v.clone();
    let mut impulses = system.no_impulses();
    let mut failed = 0;
    // A contact's row, bias and impulse, its four terms, and their particles
    // read and written.
    let words = (64 + 24 + 2 * 32 + 4 * 24 + 4 * 2 * 24) / 8;
    let mut memory = vec![1.0_f64; words * rows.len()];
    let [ours, plain] = interleave(
        BUDGET,
        [
            &mut || {
                v.copy_from_slice(&sheets.v);
                impulses.fill(Impulse::default());
                let params = SolverParams::default();
                let solved = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params);
                failed += usize::from(solved.is_err());
                failed
            },
            &mut || {
                for _ in 0..10 {
                    black_box(&mut memory).iter_mut().for_each(|word| *word += 1.0);
                }
                memory.len()
            },
        ],
    );
    assert!(failed == 0, "sheets are valid");
    let count = rows.len();
    report.add(&Ratio::of_times(&format!("10 sweeps, {count} contacts / plain"), ours, plain, 6.0));
    if count == 10_000 {
        let allowed = Timing { least: 5e6, median: 5e6 };
        report.add(&Ratio::of_times("10 sweeps, 10000 contacts / 5 ms", ours, allowed, 1.0));
    }
    Ok([ours, plain].map(|timing| timing.least / 10.0 / amount(count)))
}

/// Rows and system from contacts, beside ten sweeps of them.
fn preparation(sheets: &Sheets, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let rows = sheets.rows()?;
    let system = ContactSystem::new(&rows, &sheets.inverse_mass, SweepOrder::Colored)?;
    let mut v = sheets.v.clone();
    let [prepared, solved] = interleave(
        BUDGET,
        [
            &mut || {
                let Ok(rows) = sheets.rows() else { return 0 };
                let system = ContactSystem::new(&rows, &sheets.inverse_mass, SweepOrder::Colored);
                system.map_or(0, |system| system.batch_count())
            },
            &mut || {
                v.copy_from_slice(&sheets.v);
                let mut impulses = system.no_impulses();
                let params = SolverParams::default();
                let solved = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params);
                usize::from(solved.is_ok())
            },
        ],
    );
    report.add(&Ratio::of_times("preparing 10k contacts / 10 sweeps", prepared, solved, 2.0));
    Ok(())
}

/// Sweeps to the same residual from the impulses of the step before.
fn warm_start(sheets: &Sheets, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let rows = sheets.rows()?;
    let system = ContactSystem::new(&rows, &sheets.inverse_mass, SweepOrder::Colored)?;
    let params = SolverParams { max_iterations: 1000, tolerance: 1e-9, ..Default::default() };
    let mut impulses = system.no_impulses();
    let cold = system.solve(SolveLevel::Velocity, &mut sheets.v.clone(), &mut impulses, &params)?;
    // The next step asks for almost the same: 1 % more of everything.
    let mut next: Vec<DVec3> = sheets.v.iter().map(|v| 1.01 * *v).collect();
    let warm = system.solve(SolveLevel::Velocity, &mut next, &mut impulses, &params)?;
    let [warm, cold] = [warm, cold].map(|report| f64::from(report.iterations));
    report.add(&Ratio::new("sweeps to 1e-9, warm / cold", warm, cold, "sweeps", 1.0));
    Ok(())
}

/// K dx without a matrix, beside its blocks stored and multiplied.
fn products(sheets: &Sheets, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let mut rows = ContactRows::new(sheets.x.len());
    rows.extend(&sheets.contacts, ContactLaw::new(Margins::new(0.1, 1.0)?, 0.0)?)?;
    let law = SoftLaw::new(NormalForce::Penalty { stiffness: 10.0, damping: 0.0 }, 1.0)?;
    let soft = SoftContacts::new(&rows, &sheets.v, law)?;
    let blocks: Vec<_> = soft.stiffness_blocks().collect();
    let mut out = [vec![DVec3::ZERO; sheets.x.len()], vec![DVec3::ZERO; sheets.x.len()]];
    let [free, stored] = &mut out;
    let [ours, theirs] = interleave(
        BUDGET,
        [
            &mut || {
                soft.add_stiffness(&sheets.v, free);
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
    report.add(&Ratio::of_times("K dx without a matrix / from blocks", ours, theirs, 1.0));
    Ok(())
}

/// Sticking and sliding of all contacts, beside finding each anew in a tree
/// that is refitted.
fn carrying(mut sheets: Sheets, report: &mut Report) -> Result<(), Box<dyn Error>> {
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
    let mut tree = Tree::build(Leaves::Triangles(sheets.lower.faces()), lower)?;
    let carrier = SurfaceCarrier::Particles { first: sheets.first_lower };
    let mut workspace = Workspace::<9>::default();
    let [stuck, slid, found] = interleave(
        BUDGET,
        [
            &mut || usize::from(sticking.stick(&sheets.x).is_ok()),
            &mut || usize::from(sliding.slide(&sheets.x, &sheets.lower, on, carrier).is_ok()),
            &mut || {
                let refitted = tree.refit(lower);
                let mut faces = usize::from(refitted.is_ok());
                for &p in upper {
                    faces += nearest(&tree, sheets.lower.faces(), lower, p, &mut workspace);
                }
                faces
            },
        ],
    );
    report.add(&Ratio::of_times("10k contacts stick / found anew", stuck, found, 0.2));
    report.add(&Ratio::of_times("10k contacts slide / found anew", slid, found, 1.0));
    Ok(())
}

fn nearest(
    tree: &Tree,
    faces: &[[u32; 3]],
    x: &[DVec3],
    p: DVec3,
    workspace: &mut Workspace,
) -> usize {
    let mut best = (f64::INFINITY, u32::MAX);
    tree.nearest(p, f64::INFINITY, workspace, |face, _| {
        let corners = faces[face as usize].map(|k| x[k as usize]);
        let distance = closest_on_triangle(p, corners).point.distance(p);
        if (distance, face) < best {
            best = (distance, face);
        }
        best.0
    });
    best.1 as usize
}
