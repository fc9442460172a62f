//! Parallel maps that poll for interruption.

use surface::parallel;
use surface::progress::{Interrupted, Progress};

/// Maps the numbers `0..count`, in order, and reports progress after each batch of `size`.
///
/// Results must not depend on what earlier items left in the scratch value. A batch is shared by
/// all threads: fewer items leave threads idle at its end, more delay an interruption.
pub(crate) fn map_in_batches<S, R: Send>(
    count: usize,
    size: usize,
    progress: Progress<'_>,
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, usize) -> R + Sync + Send,
) -> Result<Vec<R>, Interrupted> {
    let mut results = Vec::with_capacity(count);
    for start in (0..count).step_by(size) {
        let length = size.min(count - start);
        results.extend(parallel::map_with(length, &scratch, |scratch, i| f(scratch, start + i)));
        progress.report(crate::real(start + length) / crate::real(count))?;
    }
    Ok(results)
}
