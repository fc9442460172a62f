//! Range of coordinates in which no product overflows and no sign is lost.
//!
//! Magnitudes are at most [`MAX_COORDINATE`], 1e30. A difference of coordinates is then at
//! most 2e30, and a product of nine differences, 5e272, still leaves room to sum 10^35 of
//! them. Exact predicates have degree 3 in coordinates, closest points 4, moments of volumes 5.
//! Bounds in single precision, which ends at 3e38, are finite too.
//!
//! The largest magnitude is at least [`MIN_SIZE`], 1e-90, unless all coordinates are zero. Below
//! it, products of three differences have digits below the smallest number, 5e-324, so that
//! exact predicates would call everything coplanar.
//!
//! Single coordinates may be smaller, as rounding leaves them in place of zeros. Products
//! with them may underflow, by at most 5e-324 each, which further factors enlarge to at most
//! 1e-290. Predicates are then exact except where the exact determinant is below that: points
//! so near to a plane may be taken to be in it or on its other side.

/// Largest magnitude of a coordinate, in any length unit.
pub const MAX_COORDINATE: f64 = 1e30;

/// Smallest magnitude of the largest coordinate of a surface, if it is not zero.
pub const MIN_SIZE: f64 = 1e-90;
