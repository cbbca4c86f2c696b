//! A file of text, line by line.

use std::io::{BufRead, BufReader, Read};

use super::Reading;
use super::watched::Watched;
use crate::input::MAX_LINE_BYTES;
use crate::scene::places::Stop;

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// The lines of a file, one at a time.
pub(super) struct Lines<'c> {
    reader: BufReader<Watched<'c>>,
    line: Vec<u8>,
    /// Lines read so far, the present one included: its number, counted from 1.
    pub n_read: u64,
    help: &'static str,
}

impl<'c> Lines<'c> {
    /// `help` says how such a file is written.
    pub fn new(file: Watched<'c>, help: &'static str) -> Lines<'c> {
        let reader = BufReader::with_capacity(BUFFER_BYTES, file);
        Lines { reader, line: Vec::new(), n_read: 0, help }
    }

    /// The next line, or `None` at the end.
    pub fn next(&mut self, cloud: &Reading) -> Result<Option<&str>, Stop> {
        self.line.clear();
        self.n_read += 1;
        let n = (&mut self.reader)
            .take(MAX_LINE_BYTES)
            .read_until(b'\n', &mut self.line)
            .map_err(|error| cloud.failed(&error))?;
        let wrong = |what: &str| cloud.wrong(format!("line {}: {what}", self.n_read), self.help);
        match n {
            0 => Ok(None),
            _ if n as u64 == MAX_LINE_BYTES => {
                Err(wrong(&format!("the line is longer than {} MiB", MAX_LINE_BYTES >> 20)))
            }
            _ => std::str::from_utf8(&self.line)
                .map(Some)
                .map_err(|_| wrong("the line is not UTF-8 text")),
        }
    }
}
