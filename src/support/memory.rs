//! What fits: the memory that can still be used, and refusing what needs more before it is asked
//! for.

use std::fmt;

use sysinfo::{MemoryRefreshKind, ProcessRefreshKind, ProcessesToUpdate, System};

use crate::error::{Error, Hint, Message, Result, Setting};
use crate::support::system;

/// Left for what is too small to be counted one by one: buffers, what the allocator keeps, and the
/// address range of 64 MiB that glibc's allocator sets aside for a thread.
const RESERVE: u64 = 64 << 20;

/// Address space that a Vulkan driver takes for itself until the first picture is traced, and for
/// each of its threads. Measured with Mesa's llvmpipe and LLVM 15 on two processors: with 610 MiB
/// in all it works, with less it fails, and below 530 MiB it now and then ends the process.
const DEVICE_ADDRESSES: u64 = 544 << 20;
const DEVICE_THREAD_ADDRESSES: u64 = 72 << 20;

/// Threads that llvmpipe starts at most.
const MOST_DEVICE_THREADS: u64 = 32;

/// The owner of the limit to [`Available::bytes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The memory of this machine.
    Machine,
    /// That of a control group, as containers have it.
    ControlGroup,
    /// `RLIMIT_AS`.
    AddressSpace,
    /// `RLIMIT_DATA`.
    Data,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Limit::Machine => "of this machine's memory",
            Limit::ControlGroup => "within the limit of the control group",
            Limit::AddressSpace => "within the limit of the address space, `ulimit -v`",
            Limit::Data => "within the limit of a process's data, `ulimit -d`",
        })
    }
}

/// Memory that can still be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Available {
    /// Bytes, less a reserve for small things where a limit is enforced; `u64::MAX` where the
    /// system does not tell.
    pub bytes: u64,
    /// The limit that keeps it from being more.
    pub limit: Limit,
}

impl Available {
    /// The memory that this process can use now: the least of what this machine has without swapping, its
    /// control groups' limits (version 1 and 2, also nested ones), `RLIMIT_AS` and `RLIMIT_DATA`.
    pub fn now() -> Available {
        let [machine, control_group] = physical();
        [
            (machine, Limit::Machine),
            (control_group, Limit::ControlGroup),
            (left_of(system::address_space_left()), Limit::AddressSpace),
            (left_of(system::data_left()), Limit::Data),
        ]
        .into_iter()
        .map(|(bytes, limit)| Available { bytes, limit })
        .min_by_key(|available| available.bytes)
        .unwrap_or(Available { bytes: u64::MAX, limit: Limit::Machine })
    }

    /// Refuses what needs more. `what` is the subject of the message, `advice` what to do.
    ///
    /// # Errors
    /// [`Error::TooLarge`]
    pub fn require(
        self,
        what: impl fmt::Display,
        needed_bytes: u64,
        advice: impl Into<Hint>,
    ) -> Result<()> {
        if needed_bytes <= self.bytes {
            return Ok(());
        }
        let (needed, left) = (needed_bytes.div_ceil(1 << 20), self.bytes >> 20);
        Err(Error::TooLarge(Message::new(
            format!(
                "{what} needs {needed} MiB of memory, but only {left} MiB are available {}",
                self.limit
            ),
            advice,
        )))
    }
}

/// Refuses what needs more memory than there is; see [`Available::require`]. Less than 16 MiB is
/// left to the reserve.
///
/// # Errors
/// [`Error::TooLarge`]
pub fn require(what: impl fmt::Display, needed_bytes: u64, advice: impl Into<Hint>) -> Result<()> {
    if needed_bytes < 16 << 20 {
        return Ok(());
    }
    Available::now().require(what, needed_bytes, advice)
}

/// Refuses to open a Vulkan device within a limit of the address space that its driver would not
/// keep: drivers end the process there.
///
/// # Errors
/// [`Error::TooLarge`]
pub fn require_device() -> Result<()> {
    let n_threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let of_threads = n_threads.min(MOST_DEVICE_THREADS) * DEVICE_THREAD_ADDRESSES;
    let bytes = left_of(system::address_space_left());
    let available = Available { bytes, limit: Limit::AddressSpace };
    let advice = Hint::new("raise the limit, or use {}", [Setting::text("device", "cpu")]);
    available.require("a Vulkan driver", DEVICE_ADDRESSES + of_threads, advice)
}

/// Bytes that the machine and the control groups have left.
fn physical() -> [u64; 2] {
    let Ok(mut system) = System::new() else { return [u64::MAX; 2] };
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    let of_machine = match system.available_memory() {
        0 => u64::MAX,
        bytes => bytes,
    };
    let Ok(own) = sysinfo::get_current_pid() else { return [of_machine, u64::MAX] };
    let kind = ProcessRefreshKind::nothing();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), false, kind);
    let groups = system.process(own).and_then(sysinfo::Process::cgroup_limits);
    // A group's "free" memory leaves out what caches hold, which the system gives back.
    let of_groups = groups.map_or(u64::MAX, |group| {
        group.total_memory.saturating_sub(group.rss).saturating_sub(RESERVE)
    });
    [of_machine, of_groups]
}

/// What a limit of this process leaves beyond the reserve.
fn left_of(limit: Option<u64>) -> u64 {
    limit.map_or(u64::MAX, |left| left.saturating_sub(RESERVE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_has_both_numbers_the_limit_and_advice() {
        let available = Available { bytes: 10 << 20, limit: Limit::AddressSpace };
        assert!(available.require("a thing", 10 << 20, "use less").is_ok());
        let error = available.require("a thing", (10 << 20) + 1, "use less").unwrap_err();
        assert_eq!(error.exit_code(), 7);
        assert_eq!(
            error.to_string(),
            "a thing needs 11 MiB of memory, but only 10 MiB are available within the limit of \
             the address space, `ulimit -v`"
        );
    }

    #[test]
    fn some_memory_is_left() {
        assert!(Available::now().bytes > 1 << 20);
    }
}
