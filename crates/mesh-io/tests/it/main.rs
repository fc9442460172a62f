//! Readers against planted meshes and fields in every format, and against damage.

mod collapsed;
mod element_surfaces;
mod feb;
mod fields;
mod inp_parts;
mod inp_rigid;
mod legacy;
mod limits;
mod meshes;
mod msh_groups;
mod off;
mod replaced;
mod solids;
mod spellings;
mod volumes;
mod vtk;

use fixtures::random::Random;

/// Number of damaged files per test.
const ROUNDS: usize = 20_000;

/// Returns a file with one to four random bytes in random places.
fn damaged(file: &[u8], random: &mut Random) -> Vec<u8> {
    let mut file = file.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(file.len());
        file[at] = random.byte();
    }
    file
}
