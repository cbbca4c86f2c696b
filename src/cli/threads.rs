//! The threads that the work is shared out to.

use std::num::NonZeroUsize;

use kugelblitz::memory::{Available, Limit, address_space};
use kugelblitz::{Error, Result};

/// The variable that tells their number, as in every program that uses rayon.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// More than any machine has use for.
const MOST: usize = 1024;

/// Address space of a thread: its stack, and what it gets to handle signals on, with guards.
const STACK: u64 = (2 << 20) + (1 << 17);

/// What glibc's allocator sets aside for a thread, of which there are eight a processor at most.
const ARENA: u64 = 64 << 20;
const ARENAS_PER_PROCESSOR: usize = 8;

/// Starts them.
///
/// # Errors
/// [`Error::Usage`] for a number in the variable that is none or makes no sense,
/// [`Error::TooLarge`] where the address space has no room for them, before any is started: one that has no room to handle signals
/// ends the process. The same where the system starts no more.
pub fn start() -> Result<()> {
    let n = match std::env::var_os(VARIABLE) {
        Some(text) if !text.is_empty() => parse(&text.to_string_lossy())?,
        _ => None,
    };
    let n = n.map_or_else(automatic, NonZeroUsize::get);
    let available =
        Available { bytes: address_space().unwrap_or(u64::MAX), limit: Limit::AddressSpace };
    let advice = format!("set {VARIABLE} to fewer, or raise the limit");
    available.require(format!("starting {n} threads"), addresses(n), &advice)?;
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
    let quarter = address_space().map_or(u64::MAX, |left| left / 4);
    (2..=n_processors()).rev().find(|&n| addresses(n) <= quarter).unwrap_or(1)
}

fn n_processors() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

/// Address space that so many threads take.
fn addresses(n: usize) -> u64 {
    n as u64 * STACK + n.min(ARENAS_PER_PROCESSOR * n_processors()) as u64 * ARENA
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
