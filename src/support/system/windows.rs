//! Windows.

use std::fs::{File, Metadata};
use std::io;
use std::os::windows::io::AsHandle;
use std::path::Path;

/// New files are ordinary ones already.
pub fn like_ordinary_files(_: &mut tempfile::Builder) {}

/// A file has those of its folder.
pub fn keep_permissions(_: &File, _: &Metadata) -> io::Result<()> {
    Ok(())
}

/// Opens a file to read.
pub fn open_at_once(path: &Path) -> io::Result<File> {
    File::open(path)
}

/// Standard input as a file: it may be one that is read from somewhere amid it.
pub fn stdin() -> io::Result<File> {
    Ok(io::stdin().as_handle().try_clone_to_owned()?.into())
}

/// There is no limit.
pub fn address_space_left() -> Option<u64> {
    None
}

/// There is no limit.
pub fn data_left() -> Option<u64> {
    None
}
