//! NumPy's `.npy` files: tables of floats in, structured arrays of hits out.

mod header;

use std::io::{self, BufReader, Read};
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use exr::prelude::f16;

use self::header::Plain;
pub(crate) use self::header::{DType, Header, Kind};
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
    pub fn write_header(self, shape: &[u64], out: &mut Vec<u8>) {
        let order = if cfg!(target_endian = "big") { '>' } else { '<' };
        let mut fields =
            format!("('id', '{order}u4'), ('t', '{order}f4'), ('normal', '{order}f4', (3,)), ");
        if self.rgb {
            fields += &format!("('rgb', '{order}f4', (3,)), ");
        }
        if self.alpha {
            fields += &format!("('a', '{order}f4'), ");
        }
        if self.level {
            fields += "('level', '|u1'), ";
        }
        write_header(&format!("[{fields}]"), shape, out);
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
    header: Header,
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
    value_bytes: usize,
    is_big_endian: bool,
    is_fortran: bool,
    reader: BufReader<R>,
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
    pub kind: Option<Kind>,
    /// Its bytes.
    pub n_bytes: usize,
    /// Bytes before it in the record.
    offset: usize,
    is_big_endian: bool,
}

/// Appends the header of a table of little-endian f64 to `out`.
pub(crate) fn write_float_header(shape: [u64; 2], out: &mut Vec<u8>) {
    write_header("'<f8'", &shape, out);
}

fn write_header(descr: &str, shape: &[u64], out: &mut Vec<u8>) {
    const N_BEFORE_TEXT: usize = 10;
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({shape}), }}");
    // Spaces and a newline put the numbers at a multiple of 64 bytes.
    let n_bytes = (N_BEFORE_TEXT + text.len() + 1).next_multiple_of(64) - N_BEFORE_TEXT;
    out.extend(b"\x93NUMPY\x01\x00");
    out.extend((n_bytes as u16).to_le_bytes());
    out.extend(format!("{text:<width$}\n", width = n_bytes - 1).bytes());
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
        let (header, n_header_bytes) = Header::read(&mut reader).map_err(|error| {
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
        matches!(self.header.dtype, DType::Record(_))
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
        let dtype = &self.header.dtype;
        let &DType::Plain(Plain {
            kind: Some(Kind::Float),
            n_bytes: Some(value_bytes @ (4 | 8)),
            is_big_endian,
            ..
        }) = dtype
        else {
            return Err(self.wrong(format!("its dtype is {dtype}; {}", expected())));
        };
        let &[n_rows, n_columns] = &self.header.shape[..] else {
            let n_axes = self.header.shape.len();
            return Err(self.wrong(format!("it has {n_axes} dimensions; {}", expected())));
        };
        if !columns.iter().any(|allowed| allowed.contains(&n_columns)) {
            return Err(self.wrong(format!("its shape is ({n_rows}, {n_columns}); {}", expected())));
        }
        let n_rows = self.check_length(n_rows, u128::from(n_columns) * value_bytes as u128)?;
        let Array { header: Header { is_fortran, .. }, path, reader, .. } = self;
        // No more than were allowed.
        let n_columns = n_columns as usize;
        Ok(FloatTable { n_rows, n_columns, path, value_bytes, is_big_endian, is_fortran, reader })
    }

    /// A structured array.
    ///
    /// # Errors
    /// [`Error::Input`] for one of several dimensions, and for fields without a fixed length.
    pub fn records(self) -> Result<Records<R>> {
        let &[n_rows] = &self.header.shape[..] else {
            let n_axes = self.header.shape.len();
            let message = format!("it has {n_axes} dimensions; a structured array has one, (N,)");
            return Err(self.wrong(message));
        };
        let Some((cells, record_bytes)) = cells_of(&self.header.dtype) else {
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
    let record_bytes = dtype.n_bytes().filter(|n| (1..=MAX_RECORD_BYTES).contains(n))?;
    let mut cells = Vec::new();
    add_cells(&mut cells, "", dtype, &mut 0);
    Some((cells, record_bytes))
}

/// Adds the numbers of a field to those of a record; `at` counts the bytes before it.
fn add_cells(cells: &mut Vec<Cell>, field: &str, dtype: &DType, at: &mut usize) {
    match dtype {
        DType::Plain(plain) => {
            let n_bytes = plain.n_bytes.unwrap_or_default();
            cells.push(Cell {
                field: field.to_owned(),
                element: None,
                type_name: plain.name.clone(),
                kind: plain.kind,
                n_bytes,
                offset: *at,
                is_big_endian: plain.is_big_endian,
            });
            *at += n_bytes;
        }
        DType::Record(fields) => {
            for inner in fields {
                let name = match field {
                    "" => inner.name.clone(),
                    outer => format!("{outer}.{}", inner.name),
                };
                let first = cells.len();
                let is_list = !inner.shape.is_empty();
                // Of no bytes, there may be any number.
                let is_nothing = is_list && inner.dtype.n_bytes() == Some(0);
                for _ in 0..if is_nothing { 0 } else { inner.n_elements() } {
                    add_cells(cells, &name, &inner.dtype, at);
                }
                if is_list {
                    // Those of several axes are numbered through.
                    for (i, cell) in cells[first..].iter_mut().enumerate() {
                        (cell.field, cell.element) = (name.clone(), Some(i));
                    }
                }
                // Padding has no name.
                if inner.name.is_empty() {
                    cells.truncate(first);
                }
            }
        }
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
        (self.kind, self.n_bytes) == (Some(Kind::Uint), 1)
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
            Some(Kind::Int) => ((bits as i64) << n_unused >> n_unused) as u64,
            _ => bits,
        }
    }

    /// The f64 nearest to the number in a record; NaN for what is no number.
    fn to_f64(&self, record: &[u8]) -> f64 {
        match (self.kind, self.n_bytes) {
            (Some(Kind::Float), 2) => f16::from_bits(self.bits(record) as u16).to_f64(),
            (Some(Kind::Float), 4) => f32::from_bits(self.bits(record) as u32).into(),
            (Some(Kind::Float), _) => f64::from_bits(self.bits(record)),
            (Some(Kind::Int), _) => self.bits(record) as i64 as f64,
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
        let FloatTable { n_rows, n_columns, path, is_fortran, reader, .. } = self;
        let (n_outer, n_inner) = if is_fortran { (n_columns, n_rows) } else { (n_rows, n_columns) };
        let place = move |outer, inner| if is_fortran { (inner, outer) } else { (outer, inner) };
        let places =
            (0..n_outer).flat_map(|outer| (0..n_inner).map(move |inner| place(outer, inner)));
        match (self.value_bytes, self.is_big_endian) {
            (4, false) => put_all(places, reader, &path, |b| f32::from_le_bytes(b).into(), put),
            (4, true) => put_all(places, reader, &path, |b| f32::from_be_bytes(b).into(), put),
            (_, false) => put_all(places, reader, &path, f64::from_le_bytes, put),
            (_, true) => put_all(places, reader, &path, f64::from_be_bytes, put),
        }
    }
}

fn put_all<const N: usize>(
    places: impl Iterator<Item = (usize, usize)>,
    mut reader: impl Read,
    path: &Path,
    to_f64: impl Fn([u8; N]) -> f64,
    mut put: impl FnMut(usize, usize, f64),
) -> Result<()> {
    for (row, column) in places {
        let mut bytes = [0; N];
        match reader.read_exact(&mut bytes) {
            Ok(()) => put(row, column, to_f64(bytes)),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                let message = format!("the file ends before row {row}, column {column}");
                return Err(Error::Input { path: path.to_owned(), message });
            }
            Err(error) => return Err(Error::io(path)(error)),
        }
    }
    Ok(())
}
