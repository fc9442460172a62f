//! Times, misses and late answers of continuous collision queries, beside other methods.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use benches::ccd::methods::{certified, del_geo, interval_subdivision, plain_cubic};
use benches::ccd::queries::{Query, QuerySet, read};
use ccd::Params;

fn main() {
    let folder = PathBuf::from(std::env::var_os("MUSCULO_DATA").unwrap()).join("ccd");
    for name in [
        "full/simbp_vf",
        "full/simbp_ee",
        "full/simhard_vf",
        "full/simhard_ee",
        "handcrafted_vf",
        "handcrafted_ee",
        "adversarial_vf",
        "adversarial_ee",
    ] {
        let set = read(&folder, name).unwrap();
        let kind = set.kind;
        let params = Params::DEFAULT;
        let names = ["ours", "del-geo", "plain"];
        let mut best = [f64::INFINITY; 3];
        let rounds = 12;
        for _ in 0..rounds {
            best[0] = best[0].min(time(&set, |q| certified(kind, q, &params)));
            best[1] = best[1].min(time(&set, |q| del_geo(kind, q)));
            best[2] = best[2].min(time(&set, |q| plain_cubic(kind, q)));
        }
        print!("{name}: ");
        for i in 0..3 {
            print!("{} {:.1} ns ", names[i], best[i]);
        }
        println!(" ratio {:.2}", best[0] / best[1]);
        let _ = interval_subdivision;
        let x0: Vec<_> = set.queries.iter().flat_map(|q| q.x0).collect();
        let x1: Vec<_> = set.queries.iter().flat_map(|q| q.x1).collect();
        let n = u32::try_from(set.queries.len()).unwrap();
        let candidates: Vec<[u32; 4]> = (0..n).map(|i| std::array::from_fn(|k| 4 * i + k as u32)).collect();
        let motion = ccd::Motion::new(&x0, &x1).unwrap();
        let mut best = [f64::INFINITY; 3];
        let mut kept = 0;
        for _ in 0..rounds {
            let start = Instant::now();
            let left = if set.kind == benches::ccd::queries::Kind::VertexFace { motion.filter_vertex_faces(&candidates, &params) } else { motion.filter_edge_edges(&candidates, &params) }.unwrap();
            kept = left.len();
            best[0] = best[0].min(start.elapsed().as_secs_f64() * 1e9 / f64::from(n));
            let start = Instant::now();
            let found = if set.kind == benches::ccd::queries::Kind::VertexFace { motion.vertex_faces(&candidates, &params) } else { motion.edge_edges(&candidates, &params) }.unwrap();
            best[1] = best[1].min(start.elapsed().as_secs_f64() * 1e9 / f64::from(n));
            black_box(found);
        }
        println!("   filter {:.1} ns batch {:.1} ns kept {:.3}", best[0], best[1], kept as f64 / f64::from(n));
    }
}

fn time(set: &QuerySet, method: impl Fn(&Query) -> Option<f64>) -> f64 {
    let start = Instant::now();
    for query in &set.queries {
        black_box(method(black_box(query)));
    }
    start.elapsed().as_secs_f64() * 1e9 / set.queries.len() as f64
}
