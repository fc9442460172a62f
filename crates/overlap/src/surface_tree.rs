//! stub until proximity lands
#![allow(warnings, reason = "stub")]
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use surface::{ClosestOnTriangle, TriangleSurface, closest_on_triangle};

#[derive(Debug)]
pub struct SurfaceTree { surface: TriangleSurface, positions: Vec<DVec3>, tree: Tree, parts: Vec<u32> }

pub const NO_HINT: u32 = u32::MAX;

impl SurfaceTree {
    pub fn new(surface: TriangleSurface, positions: Vec<DVec3>) -> Self {
        let tree = Tree::build(Leaves::Triangles(surface.faces()), &positions).expect("stub");
        let mut root: Vec<u32> = (0..surface.vertex_count() as u32).collect();
        fn find(root: &mut [u32], mut v: u32) -> u32 { while root[v as usize] != v { root[v as usize] = root[root[v as usize] as usize]; v = root[v as usize]; } v }
        for f in surface.faces() { for k in 0..3 { let (a, b) = (find(&mut root, f[k]), find(&mut root, f[(k + 1) % 3])); root[a.max(b) as usize] = a.min(b); } }
        let parts = (0..surface.vertex_count() as u32).filter(|&v| root[v as usize] == v && !surface.vertex_faces(v).is_empty()).collect();
        Self { surface, positions, tree, parts }
    }
    pub fn surface(&self) -> &TriangleSurface { &self.surface }
    pub fn positions(&self) -> &[DVec3] { &self.positions }
    pub fn tree(&self) -> &Tree { &self.tree }
    pub fn parts(&self) -> &[u32] { &self.parts }
    pub fn corners(&self, face: u32) -> [DVec3; 3] { self.surface.faces()[face as usize].map(|v| self.positions[v as usize]) }
    pub fn nearest(&self, point: DVec3, limit: f64, hint: u32, traversal: &mut Workspace) -> Option<(u32, ClosestOnTriangle)> {
        let mut best: Option<(f64, u32, ClosestOnTriangle)> = None;
        let mut offer = |face: u32| {
            let foot = closest_on_triangle(point, self.corners(face));
            let distance = foot.point.distance(point);
            let better = best.is_none_or(|(least, lowest, _)| (distance, face) < (least, lowest));
            if distance <= limit && better { best = Some((distance, face, foot)); }
            best.map_or(limit, |(least, ..)| least)
        };
        let within = if hint == NO_HINT { limit } else { offer(hint) };
        self.tree.nearest(point, within, traversal, |face, _| offer(face));
        best.map(|(_, face, foot)| (face, foot))
    }
}

#[derive(Debug, Default)]
pub struct UnionFind(Vec<u32>);
impl UnionFind {
    pub fn reset(&mut self, n: usize) { self.0.clear(); self.0.extend(0..n as u32); }
    pub fn len(&self) -> usize { self.0.len() }
    pub fn find(&mut self, mut v: u32) -> u32 { while self.0[v as usize] != v { self.0[v as usize] = self.0[self.0[v as usize] as usize]; v = self.0[v as usize]; } v }
    pub fn join(&mut self, a: u32, b: u32) { let (a, b) = (self.find(a), self.find(b)); self.0[a.max(b) as usize] = a.min(b); }
}
