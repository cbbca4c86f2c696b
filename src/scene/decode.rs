//! Streams of files, decompressed and as UTF-8 with line feeds, whatever the file is stored as.

use std::io::{self, Read};

use flate2::read::MultiGzDecoder;

/// Bytes at the start of a stream that are known before it is read.
const HEAD_BYTES: usize = 1 << 16;

/// The bytes of a file: gzip is decompressed; UTF-16 becomes UTF-8; a byte order mark is left out; in a text whose lines end in
/// carriage returns, these become line feeds.
pub(crate) struct Input<'c> {
    /// First bytes, at most [`HEAD_BYTES`].
    head: Vec<u8>,
    /// Bytes of the head that were read.
    n_read: usize,
    rest: Box<dyn Read + 'c>,
    /// Length of the file, if it is a regular one.
    n_file_bytes: Option<u64>,
    /// Whether the file is stored as these bytes.
    is_as_stored: bool,
}

impl<'c> Input<'c> {
    /// Reads the first bytes of a stream. `n_file_bytes` is the length of the file, if it is a regular one.
    ///
    /// # Errors
    /// Returns the errors of reading.
    pub fn new(stream: Box<dyn Read + 'c>, n_file_bytes: Option<u64>) -> io::Result<Input<'c>> {
        let mut input =
            Input { head: Vec::new(), n_read: 0, rest: stream, n_file_bytes, is_as_stored: true };
        input.fill_head()?;
        if input.head.starts_with(b"\x1f\x8b") {
            input = input.through(|stored| Box::new(MultiGzDecoder::new(stored)))?;
        }
        let is_big_endian = input.head.starts_with(b"\xfe\xff");
        if is_big_endian || input.head.starts_with(b"\xff\xfe") {
            input = input.through(|stored| Box::new(Utf16::new(stored, is_big_endian)))?;
        }
        if input.head.starts_with("\u{feff}".as_bytes()) {
            input.n_read = '\u{feff}'.len_utf8();
        }
        let has = |byte| input.head.contains(&byte);
        if has(b'\r') && !has(b'\n') && !has(0) {
            input = input.through(|stored| Box::new(CarriageReturns(stored)))?;
        }
        Ok(input)
    }

    /// Returns the stream through a decoder.
    fn through(
        self,
        decoder: impl FnOnce(Input<'c>) -> Box<dyn Read + 'c>,
    ) -> io::Result<Input<'c>> {
        let n_file_bytes = self.n_file_bytes;
        let (head, rest) = (Vec::new(), decoder(self));
        let mut input = Input { head, n_read: 0, rest, n_file_bytes, is_as_stored: false };
        input.fill_head()?;
        Ok(input)
    }

    fn fill_head(&mut self) -> io::Result<()> {
        (&mut self.rest).take(HEAD_BYTES as u64).read_to_end(&mut self.head).map(drop)
    }

    /// Returns the first bytes, without a byte order mark.
    pub fn head(&self) -> &[u8] {
        &self.head[self.n_read.min(self.head.len())..]
    }

    /// Returns the length of all bytes, if it is known beforehand.
    pub fn n_bytes(&self) -> Option<u64> {
        self.n_file_bytes.filter(|_| self.is_as_stored)
    }

    /// Whether the file can be opened again.
    pub fn is_regular(&self) -> bool {
        self.n_file_bytes.is_some()
    }
}

impl Read for Input<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n = self.head().read(bytes)?;
        self.n_read += n;
        if n == 0 && !bytes.is_empty() { self.rest.read(bytes) } else { Ok(n) }
    }
}

/// Decodes UTF-16 to UTF-8. Unpaired surrogates become U+FFFD.
struct Utf16<R> {
    stream: R,
    is_big_endian: bool,
    /// Bytes that are not decoded yet: a part of a character.
    stored: Vec<u8>,
    decoded: String,
    /// Bytes of `decoded` that were read.
    n_read: usize,
}

impl<R: Read> Utf16<R> {
    fn new(stream: R, is_big_endian: bool) -> Utf16<R> {
        Utf16 { stream, is_big_endian, stored: Vec::new(), decoded: String::new(), n_read: 0 }
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        const PART_BYTES: u64 = 1 << 13;
        while self.n_read == self.decoded.len() {
            let n = (&mut self.stream).take(PART_BYTES).read_to_end(&mut self.stored)?;
            let unit = |pair: &[u8; 2]| match self.is_big_endian {
                true => u16::from_be_bytes(*pair),
                false => u16::from_le_bytes(*pair),
            };
            let mut units: Vec<u16> = self.stored.as_chunks().0.iter().map(unit).collect();
            // The second half of a pair may be in the next part.
            let is_half = |unit: &u16| (0xd800..0xdc00).contains(unit);
            if n > 0 && units.last().is_some_and(is_half) {
                units.pop();
            }
            let n_left = self.stored.len() - 2 * units.len();
            self.stored.drain(..self.stored.len() - n_left);
            let chars = char::decode_utf16(units);
            self.decoded = chars.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
            self.n_read = 0;
            if n == 0 {
                self.stored.clear();
                break;
            }
        }
        let n = (&self.decoded.as_bytes()[self.n_read..]).read(bytes)?;
        self.n_read += n;
        Ok(n)
    }
}

/// Turns carriage returns into line feeds.
struct CarriageReturns<R>(R);

impl<R: Read> Read for CarriageReturns<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n = self.0.read(bytes)?;
        bytes[..n].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn decoded(stored: &[u8]) -> String {
        let input = Input::new(Box::new(stored), Some(stored.len() as u64)).unwrap();
        io::read_to_string(input).unwrap()
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        format!("\u{feff}{text}").encode_utf16().flat_map(bytes).collect()
    }

    /// Texts longer than one decoded part, with pairs of surrogates at odd and even places.
    #[test]
    fn all_encodings_are_the_same_text() {
        for text in ["", "a", "ü\r\n球", &"x😀".repeat(70_001), &"😀\n".repeat(70_000)] {
            let marked = format!("\u{feff}{text}").into_bytes();
            let forms = [
                text.as_bytes().to_vec(),
                marked.clone(),
                utf16(text, u16::to_le_bytes),
                utf16(text, u16::to_be_bytes),
            ];
            for form in forms {
                assert!(decoded(&form) == text, "{:?}…", &form[..form.len().min(9)]);
                assert!(decoded(&gzip(&form)) == text);
            }
            // Several members one after the other are one text.
            let members = [gzip(text.as_bytes()), gzip(b"!")].concat();
            assert!(decoded(&members) == format!("{text}!"));
        }
        assert_eq!(decoded(b"a\rb\r"), "a\nb\n");
        assert_eq!(decoded(b"a\rb\r\n"), "a\rb\r\n");
        assert_eq!(decoded(b"a\r\0"), "a\r\0");
        assert_eq!(decoded(b"\xff\xfea\0\x3d\xd8"), "a\u{fffd}");
    }

    #[test]
    fn a_damaged_archive_is_an_error() {
        let mut zipped = gzip(&b"x".repeat(1000));
        zipped.truncate(20);
        assert!(Input::new(Box::new(&zipped[..]), None).is_err());
    }

    #[test]
    fn only_the_length_of_what_is_stored_as_it_is_is_known() {
        for (stored, n) in [(&b"abc"[..], Some(3)), (&gzip(b"abc"), None), (b"\xff\xfea\0", None)] {
            let input = Input::new(Box::new(stored), Some(stored.len() as u64)).unwrap();
            assert_eq!((input.n_bytes(), input.is_regular()), (n, true));
        }
    }
}
