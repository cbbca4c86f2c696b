//! A file that counts what is read from it and can be stopped.

use std::fs::File;
use std::io::{self, Read, Seek};

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

    /// Goes through the file once and back to its start: the number of its line breaks.
    pub fn count_line_breaks(&mut self) -> io::Result<usize> {
        let mut bytes = vec![0; 1 << 18];
        let mut n_breaks = 0;
        loop {
            match self.read(&mut bytes)? {
                0 => break,
                n => n_breaks += bytes[..n].iter().filter(|&&byte| byte == b'\n').count(),
            }
        }
        self.file.rewind()?;
        Ok(n_breaks)
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
