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

    /// Goes through the file once and back to its start: the number of its line breaks, or of those
    /// before a line of more than `n_most` bytes. Such a line is not read to its end.
    pub fn count_line_breaks(&mut self, n_most: u64) -> io::Result<usize> {
        let mut bytes = vec![0; 1 << 18];
        let (mut n_breaks, mut n_since) = (0, 0);
        while n_since <= n_most {
            let n = match self.read(&mut bytes)? {
                0 => break,
                n => n,
            };
            let n_here = bytes[..n].iter().filter(|&&byte| byte == b'\n').count();
            n_breaks += n_here;
            n_since = if n_here > 0 { 0 } else { n_since + n as u64 };
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
