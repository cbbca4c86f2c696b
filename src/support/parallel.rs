//! Work in parts, side by side. The threads' own work is compiled here, once for all kinds of parts: for each kind anew it
//! would be a sixth of what the library is compiled in.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use bytemuck::Zeroable;

use crate::error::Result;

/// The results of `work` for some parts, in their order. The calling thread alone does the work where there is one part: the
/// first who asks for threads gives them its floating-point environment.
pub fn map<P, R: Send>(
    parts: impl IntoIterator<Item = P, IntoIter: Send>,
    work: impl Fn(P) -> R + Sync,
) -> Vec<R> {
    map_in(parts, |(), part| work(part))
}

/// The results of `work`, which may fail, for some parts, in their order.
///
/// # Errors
/// That of the first part that failed. No other one is begun after it.
pub fn try_map<P, R: Send>(
    parts: impl IntoIterator<Item = P, IntoIter: Send>,
    work: impl Fn(P) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    try_map_in(parts, |(), part| work(part))
}

/// Results as those of [`try_map`], of work in a room of each thread's own, which goes from part to part.
///
/// # Errors
/// That of the first part that failed. No other one is begun after it.
pub fn try_map_in<S: Default, P, R: Send>(
    parts: impl IntoIterator<Item = P, IntoIter: Send>,
    work: impl Fn(&mut S, P) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    let has_failed = AtomicBool::new(false);
    let parts = parts.into_iter().take_while(|_| !has_failed.load(Ordering::Relaxed));
    let work_on = |scratch: &mut S, part| {
        let result = work(scratch, part);
        has_failed.fetch_or(result.is_err(), Ordering::Relaxed);
        result
    };
    map_in(parts, work_on).into_iter().collect()
}

fn map_in<S: Default, P, R: Send>(
    parts: impl IntoIterator<Item = P, IntoIter: Send>,
    work: impl Fn(&mut S, P) -> R + Sync,
) -> Vec<R> {
    let parts = parts.into_iter();
    let is_one = parts.size_hint().1.is_some_and(|n| n <= 1);
    let parts = Mutex::new(parts.enumerate());
    let results = Mutex::new(Vec::new());
    let work_on = || {
        let mut scratch = S::default();
        let next = || lock(&parts).next();
        while let Some((at, part)) = next() {
            let result = Some(work(&mut scratch, part));
            let mut results = lock(&results);
            let n = results.len().max(at + 1);
            results.resize_with(n, || None);
            results[at] = result;
        }
    };
    on_threads(if is_one { 1 } else { rayon::current_num_threads() }, &work_on);
    lock(&results).drain(..).flatten().collect()
}

/// What a thread makes at once of a [`table`], or of [`filter_map`].
const AT_ONCE: usize = 1 << 12;

/// A table of `n` values, which `make` gives by their indices.
pub fn table<T: Zeroable + Send>(n: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut table: Vec<T> = bytemuck::zeroed_vec(n);
    map(table.chunks_mut(AT_ONCE).enumerate(), |(part, values)| {
        for (index, value) in (part * AT_ONCE..).zip(values) {
            *value = make(index);
        }
    });
    table
}

/// What `make` gives for indices below `n`, in their order.
pub fn filter_map<T: Send>(n: usize, make: impl Fn(usize) -> Option<T> + Sync) -> Vec<T> {
    let of_some = |first| (first..n.min(first + AT_ONCE)).filter_map(&make).collect::<Vec<T>>();
    map((0..n).step_by(AT_ONCE), of_some).into_iter().flatten().collect()
}

fn on_threads(n: usize, work: &(dyn Fn() + Sync)) {
    match n {
        1 => work(),
        _ => rayon::scope(|scope| (0..n).for_each(|_| scope.spawn(|_| work()))),
    }
}

/// Nothing is left half done by who held it.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use crate::error::Error;

    /// What a failed part left in a scratch is of no use to another one.
    #[test]
    fn nothing_is_begun_after_a_failure() {
        let n_begun = AtomicUsize::new(0);
        let failed = try_map(0..1000, |_| -> Result<()> {
            n_begun.fetch_add(1, Ordering::Relaxed);
            Err(Error::Interrupted)
        });
        assert!(matches!(failed, Err(Error::Interrupted)));
        assert!((1..=rayon::current_num_threads()).contains(&n_begun.into_inner()));
    }

    #[test]
    fn results_are_in_the_order_of_the_parts() {
        for n in [0, 1, 2, 3, 1000, AT_ONCE, 3 * AT_ONCE + 1] {
            let squares: Vec<usize> = (0..n).map(|i| i * i).collect();
            assert_eq!(map(0..n, |i| i * i), squares);
            assert_eq!(table(n, |i| i * i), squares);
            let odd: Vec<usize> = (1..n).step_by(2).collect();
            assert_eq!(filter_map(n, |i| (i % 2 == 1).then_some(i)), odd);
            let counted = map_in(0..n, |count: &mut usize, i| {
                *count += 1;
                (*count, i * i)
            });
            assert!(counted.iter().all(|(count, _)| (1..=n).contains(count)));
            assert!(counted.iter().map(|(_, square)| square).eq(&squares));
        }
    }

    /// What goes from part to part is made once a thread at most.
    #[test]
    fn scratches_are_kept() {
        struct Counted;
        static MADE: AtomicUsize = AtomicUsize::new(0);
        impl Default for Counted {
            fn default() -> Counted {
                MADE.fetch_add(1, Ordering::Relaxed);
                Counted
            }
        }
        map_in(0..1000, |_: &mut Counted, _| ());
        let made = MADE.load(Ordering::Relaxed);
        assert!((1..=rayon::current_num_threads()).contains(&made), "{made}");
    }
}
