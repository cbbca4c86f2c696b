//! A file that counts what is read from it and can be stopped.

use std::fs::File;
use std::io::{self, Read};

use crate::control::Control;

/// Counts bytes into a [`Control`], and fails once that is cancelled.
pub(crate) struct Watched<'c> {
    file: File,
    control: &'c Control,
}

impl<'c> Watched<'c> {
    pub fn new(file: File, control: &'c Control) -> Watched<'c> {
        Watched { file, control }
    }
}

impl Read for Watched<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        // Not as `ErrorKind::Interrupted`, upon which callers would read again.
        self.control.check().map_err(io::Error::other)?;
        let n = self.file.read(bytes)?;
        self.control.advance_bytes(n as u64);
        Ok(n)
    }
}
