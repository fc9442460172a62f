//! Cavities: regions of negative volume, each a part of the region around it.
//!
//! A cavity is joined to the region that contains it: to the innermost one, which of those that contain
//! it encloses the least volume. Boxes leave one candidate nearly always. Where they leave several, the
//! exact winding number of a border about a point of the cavity decides.

use glam::DVec3;
use surface::ray_crosses_triangle;

use crate::located::Located;
use crate::measures::Parts;
use crate::patches::{ClippedFace, Clipper};

/// Cavities of a pair with the regions that may be around them, in memory that is reused.
#[derive(Debug, Default)]
pub(crate) struct Cavities {
    /// Regions of positive volume, by the lower end of their box along x.
    solids: Vec<usize>,
    /// Regions of negative volume, by the same.
    cavities: Vec<usize>,
    /// Solids whose box reaches along x to that of the present cavity.
    reaching: Vec<usize>,
    /// The regions whose boxes hold that of a cavity, with the cavity: cavities ascending, of each the
    /// regions by volume.
    around: Vec<[usize; 2]>,
}

/// Borders of some regions, as triangles that form closed surfaces.
struct Borders {
    /// One per region.
    triangles: Vec<Vec<[DVec3; 3]>>,
}

impl Cavities {
    /// Finds the region around each cavity, in place of those found before.
    ///
    /// `regions` has the sums of each region and `owners` its number, which becomes that of the region
    /// around it for a cavity.
    pub(crate) fn find(&mut self, parts: Parts<'_>, regions: &[Located], owners: &mut [usize]) {
        self.find_by_boxes(regions);
        let is_single = self.around.chunk_by(of_one_cavity).all(|around| around.len() == 1);

        // Where a place is covered twice, borders cross each other: boxes are all there is.
        let covers_twice = parts.inside.iter().any(|inside| inside.covers_twice);
        let borders = if is_single || covers_twice {
            None
        } else {
            Some(Borders::of(parts, regions.len(), &self.around))
        };
        for around in self.around.chunk_by(of_one_cavity) {
            let [cavity, smallest] = around[0];
            let innermost = borders.as_ref().map(|borders| borders.innermost(around));
            owners[cavity] = innermost.unwrap_or(smallest);
        }
    }

    /// Finds the regions whose boxes hold those of cavities, by a sweep along x.
    fn find_by_boxes(&mut self, regions: &[Located]) {
        let Self { solids, cavities, reaching, around } = self;
        for list in [&mut *solids, &mut *cavities, &mut *reaching] {
            list.clear();
        }
        around.clear();
        for (number, region) in regions.iter().enumerate() {
            if region.sums.volume < 0.0 {
                cavities.push(number);
            }
        }
        if cavities.is_empty() {
            return;
        }
        for (number, region) in regions.iter().enumerate() {
            if region.sums.volume > 0.0 {
                solids.push(number);
            }
        }

        let lower = |number: usize| regions[number].sums.lower.x;
        for list in [&mut *solids, &mut *cavities] {
            list.sort_by(|&p, &q| lower(p).total_cmp(&lower(q)));
        }
        let mut next = solids.iter().copied().peekable();
        for &cavity in &*cavities {
            while let Some(solid) = next.next_if(|&solid| lower(solid) <= lower(cavity)) {
                reaching.push(solid);
            }
            // Later cavities begin no earlier.
            reaching.retain(|&solid| regions[solid].sums.upper.x >= lower(cavity));
            for &solid in &*reaching {
                if regions[solid].sums.holds(&regions[cavity].sums) {
                    around.push([cavity, solid]);
                }
            }
        }
        let volume = |number: usize| regions[number].sums.volume;
        around.sort_by(|&[cavity_p, p], &[cavity_q, q]| {
            let by_volume = volume(p).total_cmp(&volume(q));
            cavity_p.cmp(&cavity_q).then(by_volume).then(p.cmp(&q))
        });
    }
}

fn of_one_cavity(p: &[usize; 2], q: &[usize; 2]) -> bool {
    p[0] == q[0]
}

impl Borders {
    /// Takes the borders of cavities with several regions around them, and of these regions.
    fn of(parts: Parts<'_>, regions: usize, around: &[[usize; 2]]) -> Self {
        let mut is_needed = vec![false; regions];
        for around in around.chunk_by(of_one_cavity) {
            if around.len() > 1 {
                for &number in around.as_flattened() {
                    is_needed[number] = true;
                }
            }
        }

        let mut borders = Self { triangles: vec![Vec::new(); regions] };
        let Parts { bodies, curve, inside, regions } = parts;
        for (side, body) in bodies.into_iter().enumerate() {
            let inside = &inside[side];
            let clipper = Clipper { side, body, curve, inside, regions, region: None };
            for patch in clipper.patches() {
                if is_needed[patch.region as usize] {
                    borders.add(&patch);
                }
            }
        }
        borders
    }

    /// Adds a part of a face: fans over its loops, of which those of holes count against the others.
    fn add(&mut self, patch: &ClippedFace) {
        let triangles = &mut self.triangles[patch.region as usize];
        for border in &patch.loops {
            let Some((&first, others)) = border.split_first() else { continue };
            for side in others.windows(2) {
                triangles.push([first, side[0], side[1]]);
            }
        }
    }

    /// Returns the first of the regions around a cavity that contains it; the last one where no other does.
    fn innermost(&self, around: &[[usize; 2]]) -> usize {
        let [cavity, _] = around[0];
        let (&[_, outermost], inner) = around.split_last().unwrap_or((&around[0], &[]));
        let Some(&[point, ..]) = self.triangles[cavity].first() else { return around[0][1] };
        for &[_, solid] in inner {
            if self.contains(solid, point) {
                return solid;
            }
        }
        outermost
    }

    fn contains(&self, region: usize, point: DVec3) -> bool {
        let mut winding = 0;
        for &corners in &self.triangles[region] {
            winding += ray_crosses_triangle(point, corners).unwrap_or(0);
        }
        winding != 0
    }
}
