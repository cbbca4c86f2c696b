//! Linux, macOS and their kin.

use std::fs::{File, Metadata, OpenOptions, Permissions};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, fchown};
use std::path::Path;

use rustix::fs::OFlags;
use rustix::process::{Resource, getrlimit};

/// The permissions of a new file, before the umask takes its part.
const NEW_FILE: u32 = 0o666;

/// Temporary files are private by default; this gives those of `builder` the permissions of ordinary
/// files.
pub fn like_ordinary_files(builder: &mut tempfile::Builder) {
    builder.permissions(Permissions::from_mode(NEW_FILE));
}

/// Gives `file` the permissions of the file that it replaces; and its owner and group, where this
/// process may do so.
pub fn keep_permissions(file: &File, old: &Metadata) -> io::Result<()> {
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
    file.set_permissions(Permissions::from_mode(old.mode() & 0o777))
}

/// Opens a file to read. A pipe that nobody writes to is not waited for.
pub fn open_at_once(path: &Path) -> io::Result<File> {
    let flags = OFlags::NONBLOCK.bits() as i32;
    OpenOptions::new().read(true).custom_flags(flags).open(path)
}

/// Standard input as a file: it may be one that is read from somewhere amid it.
pub fn stdin() -> io::Result<File> {
    Ok(io::stdin().as_fd().try_clone_to_owned()?.into())
}

/// Bytes that a limit of this process leaves; `None` where there is no limit.
fn left_of(resource: Resource, field: &str) -> Option<u64> {
    let limit = getrlimit(resource).current?;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    Some(limit.saturating_sub(used_bytes(&status, field)))
}

/// `field` of the text of `/proc/self/status`.
fn used_bytes(status: &str, field: &str) -> u64 {
    let value = status.lines().find_map(|line| line.strip_prefix(field)).unwrap_or_default();
    let kib = value.trim().trim_end_matches("kB").trim_end().parse::<u64>();
    kib.map_or(0, |kib| kib << 10)
}

/// Bytes of address space that `RLIMIT_AS` leaves; `None` without a limit.
pub fn address_space_left() -> Option<u64> {
    left_of(Resource::As, "VmSize:")
}

/// Bytes of data that `RLIMIT_DATA` leaves; `None` without a limit.
pub fn data_left() -> Option<u64> {
    left_of(Resource::Data, "VmData:")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_used_is_read_from_the_status() {
        let status = "Name:\tx\nVmPeak:\t  9 kB\nVmSize:\t    1234 kB\nVmData:\t 7 kB\n";
        assert_eq!(used_bytes(status, "VmSize:"), 1234 << 10);
        assert_eq!(used_bytes(status, "VmData:"), 7 << 10);
        assert_eq!(used_bytes("", "VmSize:"), 0);
        let own = std::fs::read_to_string("/proc/self/status").unwrap();
        assert!(used_bytes(&own, "VmSize:") > 1 << 20);
    }
}
