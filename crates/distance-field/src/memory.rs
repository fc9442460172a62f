//! Memory that is asked for before it is taken.

use crate::FieldError;

/// `count` zeros, or an error where the system does not grant them.
///
/// Zeros come straight from the system, so that parts of a grid that a build
/// never touches cost nothing.
pub(crate) fn zeroed<T: Zero>(count: usize) -> Result<Vec<T>, FieldError> {
    let mut probe: Vec<T> = Vec::new();
    let bytes = count.saturating_mul(size_of::<T>());
    probe.try_reserve_exact(count).map_err(|_| FieldError::OutOfMemory { bytes })?;
    drop(probe);
    Ok(T::zeros(count))
}

/// Numbers whose zero is all bits zero. The literal in each `vec!` is what lets
/// the system hand out untouched pages.
pub(crate) trait Zero: Sized {
    fn zeros(count: usize) -> Vec<Self>;
}

impl Zero for f32 {
    fn zeros(count: usize) -> Vec<Self> {
        vec![0.0; count]
    }
}

impl Zero for u32 {
    fn zeros(count: usize) -> Vec<Self> {
        vec![0; count]
    }
}

impl Zero for i16 {
    fn zeros(count: usize) -> Vec<Self> {
        vec![0; count]
    }
}

impl Zero for u8 {
    fn zeros(count: usize) -> Vec<Self> {
        vec![0; count]
    }
}

impl Zero for bool {
    fn zeros(count: usize) -> Vec<Self> {
        vec![false; count]
    }
}
