//! The same work over many numbers, on one thread or on the caller's pool.

/// `f` of `0..count`, in that order. Each thread has one workspace, on which the
/// results must not depend.
pub(crate) fn map<T: Send, W>(
    count: usize,
    workspace: impl Fn() -> W + Sync + Send,
    f: impl Fn(&mut W, usize) -> T + Sync + Send,
) -> Vec<T> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map_init(workspace, |w, i| f(w, i)).collect()
    }
    #[cfg(not(feature = "rayon"))]
    {
        let mut workspace = workspace();
        (0..count).map(|i| f(&mut workspace, i)).collect()
    }
}
