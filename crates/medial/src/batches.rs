//! Parallel maps that poll for interruption.

use std::sync::atomic::{AtomicBool, Ordering};

use surface::parallel;
use surface::progress::{Interrupted, Progress};

/// Maps the numbers `0..count`, in order, and reports progress before each batch of `size`.
///
/// Results must not depend on what earlier items left in the scratch value. A batch is computed by
/// one thread: larger ones delay an interruption, smaller ones poll more often.
pub(crate) fn map_in_batches<S, R: Send>(
    count: usize,
    size: usize,
    progress: Progress<'_>,
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, usize) -> R + Sync + Send,
) -> Result<Vec<R>, Interrupted> {
    let batches = count.div_ceil(size);
    let steps = progress.steps(batches);
    let is_over = AtomicBool::new(false);
    let mapped = parallel::map_with(batches, scratch, |scratch, batch| {
        // Once the handler has ended the call it is not called again.
        if is_over.load(Ordering::Relaxed) {
            return Err(Interrupted);
        }
        steps.advance(1).inspect_err(|_| is_over.store(true, Ordering::Relaxed))?;
        let first = batch * size;
        let mut results = Vec::with_capacity(size);
        for i in first..count.min(first + size) {
            results.push(f(scratch, i));
        }
        Ok(results)
    });

    let mut results = Vec::with_capacity(count);
    for batch in mapped {
        results.extend(batch?);
    }
    Ok(results)
}
