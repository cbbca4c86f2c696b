//! The threads that the work is shared out to.

use std::num::NonZeroUsize;

use kugelblitz::memory::address_space;
use kugelblitz::{Error, Result};

/// The variable that tells their number, as in every program that uses rayon.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// More than any machine has use for.
const MOST: usize = 1024;

/// Address space of a thread: its stack, and the range that glibc's allocator sets aside for it.
const ADDRESSES: u64 = (2 + 64) << 20;

/// Starts them.
///
/// # Errors
/// [`Error::Usage`] for a number in the variable that is none or makes no sense,
/// [`Error::TooLarge`] where the system starts no more.
pub fn start() -> Result<()> {
    let n = match std::env::var_os(VARIABLE) {
        Some(text) if !text.is_empty() => parse(&text.to_string_lossy())?,
        _ => None,
    };
    let n = n.map_or_else(automatic, NonZeroUsize::get);
    // A first allocation sets a thread's range aside before anything is measured.
    let touch = |_| drop(std::hint::black_box(vec![0_u8; 64]));
    rayon::ThreadPoolBuilder::new().num_threads(n).start_handler(touch).build_global().map_err(
        |error| {
            Error::TooLarge(format!(
                "{n} threads can't be started ({error}): set {VARIABLE} to fewer, or raise the \
                 limits of the address space (`ulimit -v`) and of processes (`ulimit -u`)"
            ))
        },
    )
}

/// As many as there are processors; within a limit of the address space, no more than take a
/// quarter of it.
fn automatic() -> usize {
    let n = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let most = address_space().map_or(u64::MAX, |left| left / 4 / ADDRESSES);
    n.min(usize::try_from(most).unwrap_or(usize::MAX)).max(1)
}

/// `None` is rayon's 0: as many as suit the machine.
fn parse(text: &str) -> Result<Option<NonZeroUsize>> {
    match text.trim().parse() {
        Ok(n) if n <= MOST => Ok(NonZeroUsize::new(n)),
        _ => Err(Error::Usage(format!(
            "{VARIABLE} is {text:?}: give a number of threads from 1 to {MOST}, or 0 for as many \
             as there are processors"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sensible_numbers_of_threads_are_taken() {
        assert_eq!(parse("0").unwrap(), None);
        assert_eq!(parse(" 3 ").unwrap(), NonZeroUsize::new(3));
        assert_eq!(parse("1024").unwrap(), NonZeroUsize::new(1024));
        for text in ["1025", "1000000", "99999999999999999999", "-1", "1.5", "many", " "] {
            assert_eq!(parse(text).unwrap_err().exit_code(), 2, "{text}");
        }
    }
}
