//! A file that counts what is read from it and can be stopped.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read, Seek};

use crate::control::Control;

/// Counts bytes into a [`Control`], and fails once that is cancelled or more is read than is
/// allowed.
pub(crate) struct Watched<'c> {
    file: File,
    control: &'c Control,
    /// Bytes that may be read until [`Watched::allow`] is called again.
    allowed: Cell<u64>,
}

impl<'c> Watched<'c> {
    pub fn new(file: File, control: &'c Control) -> Watched<'c> {
        Watched { file, control, allowed: Cell::new(u64::MAX) }
    }

    /// From here on, `n_bytes` may be read.
    pub fn allow(&self, n_bytes: u64) {
        self.allowed.set(n_bytes);
    }

    /// True where all that was allowed has been read.
    pub fn is_used_up(&self) -> bool {
        self.allowed.get() == 0
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
        let allowed = self.allowed.get();
        if allowed == 0 && !bytes.is_empty() {
            return Err(io::Error::other("more than is allowed"));
        }
        let n_at_most = bytes.len().min(usize::try_from(allowed).unwrap_or(usize::MAX));
        let n = self.file.read(&mut bytes[..n_at_most])?;
        self.allowed.set(allowed - n as u64);
        self.control.advance_bytes(n as u64);
        Ok(n)
    }
}
