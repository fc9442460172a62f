//! Memory of a grid, requested before it is taken.

use crate::FieldError;

/// Allocates `count` zeros, or returns an error where the system refuses them.
///
/// Zeros come from the system as untouched pages: parts of a grid that a build never
/// visits cost nothing.
pub(crate) fn zeroed<T: Clone + Default>(count: usize) -> Result<Vec<T>, FieldError> {
    // `vec!` aborts where memory is refused, so that a fallible reservation tries first.
    let mut attempt: Vec<T> = Vec::new();
    let bytes = count.saturating_mul(size_of::<T>());
    attempt.try_reserve_exact(count).map_err(|_| FieldError::OutOfMemory { bytes })?;
    drop(attempt);
    Ok(vec![T::default(); count])
}
