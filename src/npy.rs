//! NumPy's `.npy` files: tables of floats in, structured arrays of hits out.

use std::io::{self, BufReader, Read};
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use exr::prelude::f16;
use npyz::{
    AutoSerialize, DType, Deserialize, Endianness, Field, NpyFile, NpyHeader, Order, TypeChar,
    WriteOptions, WriterBuilder,
};

use crate::error::{Error, Result};
use crate::memory;
use crate::plain::Shown;
use crate::trace::{Coverage, Hits};

/// The layout of one record of a structured array of hits: `id` (u4), `t` (f4), `normal` (3f4),
/// then what is asked for. Fields follow each other without padding, in this machine's byte order,
/// which the header tells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    /// `rgb` (3f4): linear colour.
    pub rgb: bool,
    /// `a` (f4): alpha.
    pub alpha: bool,
    /// `level` (u1).
    pub level: bool,
}

impl Record {
    /// Bytes of a record.
    pub fn bytes(self) -> usize {
        let n_words = 1 + 1 + 3 + if self.rgb { 3 } else { 0 } + usize::from(self.alpha);
        n_words * 4 + usize::from(self.level)
    }

    /// Appends the header of an array of this `shape` to `out`.
    pub fn write_header(self, shape: &[u64], out: &mut Vec<u8>) -> io::Result<()> {
        let vector = || DType::Array(3, Box::new(f32::default_dtype()));
        let mut fields =
            vec![("id", u32::default_dtype()), ("t", f32::default_dtype()), ("normal", vector())];
        if self.rgb {
            fields.push(("rgb", vector()));
        }
        if self.alpha {
            fields.push(("a", f32::default_dtype()));
        }
        if self.level {
            fields.push(("level", u8::default_dtype()));
        }
        let fields =
            fields.into_iter().map(|(name, dtype)| Field { name: name.into(), dtype }).collect();
        write_header(DType::Record(fields), shape, out)
    }

    /// Appends the records of the hits in `range`, which have every field of this layout.
    /// `rgb` has their linear colours; a layout without `rgb` doesn't look at it. Alpha is 1 without
    /// a coverage.
    pub fn append(
        self,
        hits: &Hits,
        range: Range<usize>,
        rgb: &[[f32; 3]],
        coverage: Option<&Coverage>,
        out: &mut Vec<u8>,
    ) {
        out.reserve(range.len() * self.bytes());
        for i in range {
            // One copy of the whole record: many small ones are several times slower.
            let mut words = [[0_u8; 4]; 9];
            let mut n_words = 5;
            words[0] = hits.id[i].to_ne_bytes();
            words[1] = hits.t[i].to_ne_bytes();
            for axis in 0..3 {
                words[2 + axis] = hits.normal[i][axis].to_ne_bytes();
            }
            if self.rgb {
                for channel in 0..3 {
                    words[n_words + channel] = rgb[i][channel].to_ne_bytes();
                }
                n_words += 3;
            }
            if self.alpha {
                let alpha = coverage.map_or(1.0, |coverage| coverage.alpha(i));
                words[n_words] = alpha.to_ne_bytes();
                n_words += 1;
            }
            out.extend_from_slice(words[..n_words].as_flattened());
            if self.level {
                out.push(hits.level[i]);
            }
        }
    }
}

/// An array in a file whose header is read.
pub(crate) struct Array<R: Read> {
    header: NpyHeader,
    n_header_bytes: u64,
    n_file_bytes: Option<u64>,
    path: PathBuf,
    reader: BufReader<R>,
}

/// A two-dimensional array of f32 or f64 in a file: C or Fortran order, either byte order.
pub(crate) struct FloatTable<R: Read> {
    /// Rows.
    pub n_rows: usize,
    /// Columns: one of the numbers that were allowed.
    pub n_columns: usize,
    path: PathBuf,
    file: NpyFile<BufReader<R>>,
}

/// A one-dimensional structured array in a file.
pub(crate) struct Records<R: Read> {
    /// Records.
    pub n_rows: usize,
    /// The numbers of a record, in their order.
    pub cells: Vec<Cell>,
    record_bytes: usize,
    path: PathBuf,
    reader: BufReader<R>,
}

/// One number of a record.
pub(crate) struct Cell {
    /// The name of its field, `outer.inner` of a record in a record; empty in an array without fields.
    pub field: String,
    /// Its place in a field of several numbers.
    pub element: Option<usize>,
    /// The type as NumPy writes it.
    pub type_name: String,
    /// What kind of number; `None` for what is none.
    pub kind: Option<TypeChar>,
    /// Its bytes.
    pub n_bytes: usize,
    /// Bytes before it in the record.
    offset: usize,
    is_big_endian: bool,
}

/// Appends the header of a table of little-endian f64 to `out`.
pub(crate) fn write_float_header(shape: [u64; 2], out: &mut Vec<u8>) -> io::Result<()> {
    let f64_little = "<f8".parse().map_err(io::Error::other)?;
    write_header(DType::Plain(f64_little), &shape, out)
}

fn write_header(dtype: DType, shape: &[u64], out: &mut Vec<u8>) -> io::Result<()> {
    let options = WriteOptions::new_header_only().dtype(dtype).shape(shape);
    options.writer(out).write_header_only().map(drop)
}

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

impl<R: Read> Array<R> {
    /// Reads the header. `n_file_bytes` is the length of the whole file, where it is known; `path`
    /// and `expected` are for messages.
    ///
    /// # Errors
    /// [`Error::Io`] when the file can't be read, [`Error::Input`] when it is something else.
    pub fn new(
        reader: R,
        n_file_bytes: Option<u64>,
        path: &Path,
        expected: &str,
    ) -> Result<Array<R>> {
        let mut reader = BufReader::with_capacity(BUFFER_BYTES, reader);
        let (header, n_header_bytes) = read_header(&mut reader).map_err(|error| {
            // A file that ends too early is a wrong file, not a failing disk.
            match error.kind() {
                io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => Error::Input {
                    path: path.to_owned(),
                    message: format!("not a readable .npy file ({error}); expected {expected}"),
                },
                _ => Error::io(path)(error),
            }
        })?;
        Ok(Array { header, n_header_bytes, n_file_bytes, path: path.to_owned(), reader })
    }

    /// True for an array of records with fields.
    pub fn is_structured(&self) -> bool {
        matches!(self.header.dtype(), DType::Record(_))
    }

    fn wrong(&self, message: String) -> Error {
        Error::Input { path: self.path.clone(), message }
    }

    /// Fails where the file has more or fewer bytes than `n_rows` rows of `row_bytes`.
    fn check_length(&self, n_rows: u64, row_bytes: u128) -> Result<usize> {
        let n_data_bytes = u128::from(n_rows).saturating_mul(row_bytes);
        if let Some(n_file_bytes) = self.n_file_bytes {
            let n_found = u128::from(n_file_bytes.saturating_sub(self.n_header_bytes));
            if n_found != n_data_bytes {
                return Err(self.wrong(format!(
                    "its header tells of {n_rows} rows, which are {n_data_bytes} bytes, but \
                     {n_found} bytes follow; is the file cut off?"
                )));
            }
        }
        usize::try_from(n_rows).map_err(|_| {
            Error::TooLarge(format!(
                "{}: {n_rows} rows don't fit this machine's memory; give them in parts",
                self.path.shown()
            ))
        })
    }

    /// A table of floats with an allowed number of columns.
    ///
    /// # Errors
    /// [`Error::Input`] for any other array.
    pub fn floats(self, columns: &[RangeInclusive<u64>]) -> Result<FloatTable<R>> {
        let expected = || {
            let columns: Vec<String> = columns
                .iter()
                .map(|n| match n.start() == n.end() {
                    true => format!("(N, {})", n.start()),
                    false => format!("(N, {}) or more columns", n.start()),
                })
                .collect();
            format!(
                "expected a NumPy array of float64 or float32 with shape {}",
                columns.join(" or ")
            )
        };
        let dtype = self.header.dtype();
        if f64::reader(&dtype).is_err() && f32::reader(&dtype).is_err() {
            return Err(self.wrong(format!("its dtype is {}; {}", dtype.descr(), expected())));
        }
        let &[n_rows, n_columns] = self.header.shape() else {
            let n_axes = self.header.shape().len();
            return Err(self.wrong(format!("it has {n_axes} dimensions; {}", expected())));
        };
        if !columns.iter().any(|allowed| allowed.contains(&n_columns)) {
            return Err(self.wrong(format!("its shape is ({n_rows}, {n_columns}); {}", expected())));
        }
        let value_bytes = dtype.num_bytes().unwrap_or_default() as u128;
        let n_rows = self.check_length(n_rows, u128::from(n_columns) * value_bytes)?;
        let Array { header, path, reader, .. } = self;
        let file = NpyFile::with_header(header, reader);
        // No more than were allowed.
        Ok(FloatTable { n_rows, n_columns: n_columns as usize, path, file })
    }

    /// A structured array.
    ///
    /// # Errors
    /// [`Error::Input`] for one of several dimensions, and for fields without a fixed length.
    pub fn records(self) -> Result<Records<R>> {
        let dtype = self.header.dtype();
        let &[n_rows] = self.header.shape() else {
            let n_axes = self.header.shape().len();
            let message = format!("it has {n_axes} dimensions; a structured array has one, (N,)");
            return Err(self.wrong(message));
        };
        let Some((cells, record_bytes)) = cells_of(&dtype) else {
            let message = "its records have no fixed length, or a large one".to_owned();
            return Err(self.wrong(message));
        };
        let n_rows = self.check_length(n_rows, record_bytes as u128)?;
        let Array { path, reader, .. } = self;
        Ok(Records { n_rows, cells, record_bytes, path, reader })
    }
}

/// Most bytes of a record.
const MAX_RECORD_BYTES: usize = 1 << 16;

/// The numbers of a record of this type, and its bytes; `None` where it has no fixed length or a large one.
pub(crate) fn cells_of(dtype: &DType) -> Option<(Vec<Cell>, usize)> {
    let record_bytes = dtype.num_bytes().filter(|n| (1..=MAX_RECORD_BYTES).contains(n))?;
    let mut cells = Vec::new();
    add_cells(&mut cells, "", dtype, &mut 0);
    Some((cells, record_bytes))
}

/// Adds the numbers of a field to those of a record; `at` counts the bytes before it.
fn add_cells(cells: &mut Vec<Cell>, field: &str, dtype: &DType, at: &mut usize) {
    match dtype {
        DType::Plain(plain) => {
            let n_bytes = plain.num_bytes().unwrap_or_default();
            cells.push(Cell {
                field: field.to_owned(),
                element: None,
                type_name: dtype.descr().replace('\'', ""),
                kind: Some(plain.type_char()).filter(|&kind| is_number(kind, n_bytes)),
                n_bytes,
                offset: *at,
                is_big_endian: plain.endianness() == Endianness::Big,
            });
            *at += n_bytes;
        }
        // Of no bytes, there may be any number.
        DType::Array(_, inner) if inner.num_bytes().is_none_or(|n| n == 0) => {}
        DType::Array(n, inner) => {
            // Those of several axes are numbered through.
            let first = cells.len();
            (0..*n).for_each(|_| add_cells(cells, field, inner, at));
            for (i, cell) in cells[first..].iter_mut().enumerate() {
                (cell.field, cell.element) = (field.to_owned(), Some(i));
            }
        }
        DType::Record(fields) => {
            for inner in fields {
                let name = match field {
                    "" => inner.name.clone(),
                    outer => format!("{outer}.{}", inner.name),
                };
                let first = cells.len();
                add_cells(cells, &name, &inner.dtype, at);
                // Padding has no name.
                if inner.name.is_empty() {
                    cells.truncate(first);
                }
            }
        }
    }
}

fn is_number(kind: TypeChar, n_bytes: usize) -> bool {
    match kind {
        TypeChar::Bool => n_bytes == 1,
        TypeChar::Int | TypeChar::Uint => [1, 2, 4, 8].contains(&n_bytes),
        TypeChar::Float => [2, 4, 8].contains(&n_bytes),
        _ => false,
    }
}

impl Cell {
    /// The name of its field, followed by `:0`, `:1` and so on in a field of several numbers.
    pub fn name(&self) -> String {
        match self.element {
            None => self.field.clone(),
            Some(i) => format!("{}:{i}", self.field),
        }
    }

    /// True for unsigned numbers of 8 bits.
    pub fn is_byte(&self) -> bool {
        (self.kind, self.n_bytes) == (Some(TypeChar::Uint), 1)
    }

    /// The bits of the number in a record, the lowest first; those of a signed one go on with its sign.
    pub fn bits(&self, record: &[u8]) -> u64 {
        let bytes = &record[self.offset..self.offset + self.n_bytes];
        let mut low_first = [0; 8];
        low_first[..self.n_bytes].copy_from_slice(bytes);
        if self.is_big_endian {
            low_first[..self.n_bytes].reverse();
        }
        let bits = u64::from_le_bytes(low_first);
        let n_unused = 64 - 8 * self.n_bytes as u32;
        match self.kind {
            Some(TypeChar::Int) => ((bits as i64) << n_unused >> n_unused) as u64,
            _ => bits,
        }
    }

    /// The f64 nearest to the number in a record; NaN for what is no number.
    fn to_f64(&self, record: &[u8]) -> f64 {
        match (self.kind, self.n_bytes) {
            (Some(TypeChar::Float), 2) => f16::from_bits(self.bits(record) as u16).to_f64(),
            (Some(TypeChar::Float), 4) => f32::from_bits(self.bits(record) as u32).into(),
            (Some(TypeChar::Float), _) => f64::from_bits(self.bits(record)),
            (Some(TypeChar::Int), _) => self.bits(record) as i64 as f64,
            (Some(_), _) => self.bits(record) as f64,
            (None, _) => f64::NAN,
        }
    }
}

impl<R: Read> Records<R> {
    /// Reads all records and gives `put` each number of the `wanted` cells, with its record and its
    /// cell.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] when the file ends too early.
    pub fn read(mut self, wanted: &[usize], mut put: impl FnMut(usize, usize, f64)) -> Result<()> {
        let cells: Vec<_> = wanted.iter().map(|&place| (place, &self.cells[place])).collect();
        let mut record = vec![0; self.record_bytes];
        for row in 0..self.n_rows {
            if let Err(error) = self.reader.read_exact(&mut record) {
                return Err(match error.kind() {
                    io::ErrorKind::UnexpectedEof => Error::Input {
                        path: self.path,
                        message: format!("the file ends before row {row} is whole"),
                    },
                    _ => Error::io(self.path)(error),
                });
            }
            for (place, cell) in &cells {
                put(row, *place, cell.to_f64(&record));
            }
        }
        Ok(())
    }
}

impl<R: Read> FloatTable<R> {
    /// Room for one `T` a row.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when there is none.
    pub fn rows_of<T: Clone>(&self, zero: T) -> Result<Vec<T>> {
        // Of a pipe, the header alone says how much there is, and it may say anything.
        let n_bytes = (self.n_rows as u64).saturating_mul(size_of::<T>() as u64);
        let what = format!("{}: reading {} rows", self.path.shown(), self.n_rows);
        memory::require(what, n_bytes, "give them in parts")?;
        let mut rows = Vec::new();
        rows.try_reserve_exact(self.n_rows).map_err(|_| {
            Error::TooLarge(format!(
                "{}: {} rows don't fit this machine's memory; give them in parts",
                self.path.shown(),
                self.n_rows
            ))
        })?;
        rows.resize(self.n_rows, zero);
        Ok(rows)
    }

    /// Reads all values in the order of the file and gives `put` each with its row and column.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] when the file ends too early.
    pub fn read(self, put: impl FnMut(usize, usize, f64)) -> Result<()> {
        let FloatTable { n_rows, n_columns, path, file } = self;
        let order = file.order();
        let (n_outer, n_inner) = match order {
            Order::C => (n_rows, n_columns),
            Order::Fortran => (n_columns, n_rows),
        };
        let place = move |outer, inner| match order {
            Order::C => (outer, inner),
            Order::Fortran => (inner, outer),
        };
        let places =
            (0..n_outer).flat_map(|outer| (0..n_inner).map(move |inner| place(outer, inner)));
        match file.try_data::<f64>() {
            Ok(values) => put_all(places.zip(values), &path, put),
            Err(file) => {
                let values = file.data::<f32>().map_err(io::Error::other);
                let values = values.map_err(Error::io(&path))?;
                put_all(places.zip(values), &path, put)
            }
        }
    }
}

fn put_all<T: Into<f64>>(
    values: impl Iterator<Item = ((usize, usize), io::Result<T>)>,
    path: &Path,
    mut put: impl FnMut(usize, usize, f64),
) -> Result<()> {
    for ((row, column), value) in values {
        match value {
            Ok(value) => put(row, column, value.into()),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                let message = format!("the file ends before row {row}, column {column}");
                return Err(Error::Input { path: path.to_owned(), message });
            }
            Err(error) => return Err(Error::io(path)(error)),
        }
    }
    Ok(())
}

/// Longest header, bytes. NumPy itself refuses to read headers of more than 10 000.
const MAX_HEADER_BYTES: u64 = 10_000;

/// Deepest nesting of brackets: the dictionary, the list of fields, a field, its shape.
const MAX_NESTING: usize = 8;

/// Most decimal digits in the shapes of all: a product of numbers with so many digits together is
/// below 10¹⁸, so below 2⁶⁴.
const MAX_DIGITS: usize = 18;

/// Most decimal digits that follow each other in a name or a type: a length of less than 10⁹.
const MAX_DIGITS_OF_TYPE: usize = 9;

/// The header and its length in bytes.
///
/// The parser recurses into nested brackets and multiplies the shape without looking, and so can
/// overflow the stack or an integer. Only text that can do neither is handed to it.
pub(crate) fn read_header(reader: &mut impl Read) -> io::Result<(NpyHeader, u64)> {
    let invalid = |message| io::Error::new(io::ErrorKind::InvalidData, message);
    let mut bytes = Vec::new();
    reader.take(8).read_to_end(&mut bytes)?;
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(invalid("it does not begin like one"));
    }
    let n_length_bytes = if bytes.get(6) == Some(&1) { 2 } else { 4 };
    let mut length = [0; 4];
    reader.read_exact(&mut length[..n_length_bytes])?;
    bytes.extend_from_slice(&length[..n_length_bytes]);
    let n_text_bytes = u64::from(u32::from_le_bytes(length));
    if n_text_bytes > MAX_HEADER_BYTES {
        return Err(invalid("its header is too long"));
    }
    let n_before_text = bytes.len();
    reader.take(n_text_bytes).read_to_end(&mut bytes)?;

    let text = &bytes[n_before_text..];
    let (mut depth, mut n_digits, mut n_digits_of_type) = (0_usize, 0_usize, 0_usize);
    let mut quote = None;
    for (at, &byte) in text.iter().enumerate() {
        if byte == b'\\' {
            return Err(invalid("its header has unexpected signs"));
        }
        if let Some(open) = quote {
            n_digits_of_type = if byte.is_ascii_digit() { n_digits_of_type + 1 } else { 0 };
            if n_digits_of_type > MAX_DIGITS_OF_TYPE {
                return Err(invalid("its header is not that of a table of numbers"));
            }
            quote = Some(open).filter(|open| *open != byte);
            continue;
        }
        match byte {
            b'\'' | b'"' => (quote, n_digits_of_type) = (Some(byte), 0),
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            b'0'..=b'9' => n_digits += 1,
            // Signs have no business in a header of numbers.
            b'+' | b'-' => return Err(invalid("its header has unexpected signs")),
            _ => {}
        }
        if depth > MAX_NESTING {
            return Err(invalid("its header is nested too deeply"));
        }
        if n_digits > MAX_DIGITS
            || text[at..].get(..2).is_some_and(|two| two.eq_ignore_ascii_case(b"0x"))
        {
            return Err(invalid("its header is not that of a table of numbers"));
        }
    }
    if quote.is_some() {
        return Err(invalid("its header is not closed"));
    }
    // Three quotes begin a text that may hold single ones.
    if text.windows(3).any(|three| three == b"\'\'\'" || three == b"\"\"\"") {
        return Err(invalid("its header is not that of a table of numbers"));
    }
    let n_bytes = bytes.len() as u64;
    Ok((NpyHeader::from_reader(&bytes[..])?, n_bytes))
}
