//! NumPy's `.npy` files: tables of numbers, structured arrays of hits, and the header of both.

mod literal;

use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use exr::prelude::f16;
use literal::{Literal, LiteralValue};

use crate::error::{Error, Result};
use crate::plain::Shown;
use crate::support::memory;
use crate::words::{count, joined};

/// The header of an array; `descr` is the type of an element.
pub(crate) fn header(descr: &str, shape: &[u64]) -> Vec<u8> {
    const N_BEFORE_TEXT: usize = 10;
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({shape}), }}");
    // Spaces and a newline put the numbers at a multiple of 64 bytes.
    let n_bytes = (N_BEFORE_TEXT + text.len() + 1).next_multiple_of(64) - N_BEFORE_TEXT;
    let text = format!("{text:<width$}\n", width = n_bytes - 1);
    [&b"\x93NUMPY\x01\x00"[..], &(n_bytes as u16).to_le_bytes(), text.as_bytes()].concat()
}

/// An array in a file whose header is read. That of a table has the numbers of a row as cells, in their order.
pub(crate) struct Array<R: Read> {
    /// What the file says of it.
    pub header: NpyHeader,
    n_data_bytes: Option<u64>,
    path: PathBuf,
    reader: BufReader<R>,
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
        let (header, n_header_bytes) = NpyHeader::read(&mut reader).map_err(|error| {
            // A file that ends too early is a wrong file, not a failing disk.
            match error.kind() {
                io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => Error::Input {
                    path: path.to_owned(),
                    message: format!("not a readable .npy file ({error}); expected {expected}"),
                },
                _ => Error::io(path)(error),
            }
        })?;
        let n_data_bytes = n_file_bytes.map(|n| n.saturating_sub(n_header_bytes));
        Ok(Array { header, n_data_bytes, path: path.to_owned(), reader })
    }

    /// An error about this file.
    pub fn wrong(&self, message: impl Into<String>) -> Error {
        Error::Input { path: self.path.clone(), message: message.into() }
    }

    /// Bytes of an element.
    ///
    /// # Errors
    /// [`Error::Input`] where they differ from one to the next, or are very many.
    pub fn element_bytes(&self) -> Result<usize> {
        let message = "its records have no fixed length, or a large one";
        self.header.element_bytes.ok_or_else(|| self.wrong(message))
    }

    /// Bytes of `n_rows` rows of `row_bytes`, as many as a `u64` holds.
    ///
    /// # Errors
    /// [`Error::Input`] where the file has more or fewer.
    pub fn data_bytes(&self, n_rows: u64, row_bytes: u128) -> Result<u64> {
        let n_bytes = u128::from(n_rows).saturating_mul(row_bytes);
        match self.n_data_bytes {
            Some(n_found) if u128::from(n_found) != n_bytes => {
                let is_less = u128::from(n_found) < n_bytes;
                let hint = if is_less { "; the file may be truncated" } else { "" };
                let rows = count(usize::try_from(n_rows).unwrap_or(usize::MAX), "row");
                Err(self.wrong(format!(
                    "expected {n_bytes} bytes of data ({rows}, according to the header), found {n_found}{hint}"
                )))
            }
            _ => Ok(u64::try_from(n_bytes).unwrap_or(u64::MAX)),
        }
    }

    /// Returns the table of numbers with an allowed number of columns, C or Fortran order, either byte order. `expected` is for
    /// messages.
    ///
    /// # Errors
    /// [`Error::Input`] for any other array.
    pub fn numbers(mut self, is_allowed: impl Fn(u64) -> bool, expected: &str) -> Result<Array<R>> {
        let wrong = |found: String| self.wrong(format!("{found}; expected {expected}"));
        let NpyHeader { cells, shape, is_structured, is_fortran, .. } = &self.header;
        let cell = match &cells[..] {
            [cell] if cell.kind.is_some() && !is_structured => cell,
            _ => return Err(wrong(format!("its dtype is {}", self.header.dtype()))),
        };
        let &[n_rows, n_columns] = &shape[..] else {
            return Err(wrong(format!("it has {} dimensions", shape.len())));
        };
        if !is_allowed(n_columns) {
            return Err(wrong(format!("its shape is ({n_rows}, {n_columns})")));
        }
        let row_bytes = u128::from(n_columns) * cell.n_bytes as u128;
        self.data_bytes(n_rows, row_bytes)?;
        let n_bytes_at_once = if *is_fortran { cell.n_bytes } else { row_bytes as usize };
        let offset = |column| if *is_fortran { 0 } else { column * cell.n_bytes };
        // No more than were allowed.
        let cells = (0..n_columns as usize).map(|i| NpyCell { offset: offset(i), ..cell.clone() });
        self.header.cells = cells.collect();
        // Of Fortran order, each column stands by itself.
        self.header.element_bytes = Some(n_bytes_at_once);
        Ok(self)
    }

    /// The table whose rows are the records of a structured array.
    ///
    /// # Errors
    /// [`Error::Input`] for one of several dimensions, and for fields without a fixed length.
    pub fn records(mut self) -> Result<Array<R>> {
        let &[n_rows] = &self.header.shape[..] else {
            let n_axes = self.header.shape.len();
            let message = format!("it has {n_axes} dimensions; a structured array has one, (N,)");
            return Err(self.wrong(message));
        };
        self.data_bytes(n_rows, self.element_bytes()? as u128)?;
        self.header.is_fortran = false;
        Ok(self)
    }

    /// Rows of a table.
    pub fn n_rows(&self) -> usize {
        self.header.shape.first().map_or(0, |&n| usize::try_from(n).unwrap_or(usize::MAX))
    }

    /// Room for one `T` a row of a table.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when there is none.
    pub fn rows_of<T: Clone>(&self, zero: T) -> Result<Vec<T>> {
        // Of a pipe, the header alone says how much there is, and it may say anything.
        let n_rows = self.n_rows();
        let n_bytes = (n_rows as u64).saturating_mul(size_of::<T>() as u64);
        let what = format!("{}: reading {n_rows} rows", self.path.shown());
        memory::require(&what, n_bytes, "give them in parts")?;
        let mut rows = Vec::new();
        rows.try_reserve_exact(n_rows).map_err(|_| {
            Error::TooLarge(
                format!("{what} needs more memory than there is; give them in parts").into(),
            )
        })?;
        rows.resize(n_rows, zero);
        Ok(rows)
    }

    /// Reads all rows of a table and gives `put` the number of each `wanted` cell, with its row and what stands
    /// beside the cell, in the order of the file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] when the file ends too early.
    pub fn read<T: Copy>(
        mut self,
        wanted: &[(usize, T)],
        mut put: impl FnMut(usize, T, f64),
    ) -> Result<()> {
        let NpyHeader { cells, is_fortran, .. } = &self.header;
        let mut bytes = vec![0; self.element_bytes()?];
        let n_passes = if *is_fortran { cells.len() } else { 1 };
        for pass in 0..n_passes {
            let is_here = |(column, _): &&(usize, T)| !is_fortran || *column == pass;
            let here = wanted.iter().filter(is_here);
            let here: Vec<_> = here.map(|(column, what)| (&cells[*column], *what)).collect();
            for row in 0..self.n_rows() {
                self.reader.read_exact(&mut bytes).map_err(|error| match error.kind() {
                    io::ErrorKind::UnexpectedEof => {
                        self.wrong(format!("the file ends before row {row} is whole"))
                    }
                    _ => Error::io(&self.path)(error),
                })?;
                for &(cell, what) in &here {
                    put(row, what, cell.to_f64(&bytes));
                }
            }
        }
        Ok(())
    }
}

/// The header of a file: what an array consists of, and how it lies there.
pub(crate) struct NpyHeader {
    /// The numbers of an element, one where it has no fields.
    pub cells: Vec<NpyCell>,
    /// Bytes of an element; `None` where it has no fixed length, or more than [`MAX_RECORD_BYTES`].
    element_bytes: Option<usize>,
    /// True for records with fields.
    pub is_structured: bool,
    /// How many elements there are along each axis. The product is below 10¹⁸.
    pub shape: Vec<u64>,
    /// True where neighbours in the file are neighbours along the first axis.
    pub is_fortran: bool,
}

/// One number of an element.
#[derive(Clone)]
pub(crate) struct NpyCell {
    /// The name of its field, `outer.inner` of a record in a record; empty in an array without fields.
    pub field: String,
    /// Place of the number in a field of several numbers.
    pub element: Option<usize>,
    /// The type as NumPy writes it.
    pub type_name: String,
    /// What kind of number, of at most 64 bits; `None` for what is none.
    pub kind: Option<Kind>,
    /// Bytes of the number.
    pub n_bytes: usize,
    /// Bytes before it in the record.
    offset: usize,
    is_big_endian: bool,
}

/// A kind of number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Bool,
    Int,
    Uint,
    Float,
}

/// Most bytes of a record.
const MAX_RECORD_BYTES: usize = 1 << 16;

/// Longest header, bytes. NumPy itself refuses to read headers of more than 10 000.
const MAX_HEADER_BYTES: u64 = 10_000;

/// Most numbers that a shape may tell of, so that products with the bytes of each are no larger than u128.
const MAX_NUMBERS: u64 = 10u64.pow(18);

fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message.into())
}

impl NpyHeader {
    /// Reads the header of versions 1 to 3, and tells its length in bytes.
    ///
    /// # Errors
    /// `InvalidData` where it is none, `UnexpectedEof` where the file ends in it.
    pub fn read(reader: &mut impl Read) -> io::Result<(NpyHeader, u64)> {
        let mut start = Vec::new();
        reader.take(8).read_to_end(&mut start)?;
        let &[0x93, b'N', b'U', b'M', b'P', b'Y', major, minor] = &start[..] else {
            return Err(invalid("it does not begin like one"));
        };
        let n_length_bytes = match (major, minor) {
            (1, 0) => 2,
            (2 | 3, 0) => 4,
            _ => return Err(invalid(format!("unsupported version: ({major}, {minor})"))),
        };
        let mut length = [0; 4];
        reader.read_exact(&mut length[..n_length_bytes])?;
        let n_text_bytes = u64::from(u32::from_le_bytes(length));
        if n_text_bytes > MAX_HEADER_BYTES {
            return Err(invalid("its header is too long"));
        }
        let mut text = vec![0; n_text_bytes as usize];
        reader.read_exact(&mut text)?;
        // Before version 3 it is Latin-1 (NEP 1).
        let text = match major {
            3 => String::from_utf8(text).map_err(|_| invalid("its header is not UTF-8"))?,
            _ => text.into_iter().map(char::from).collect(),
        };
        Ok((NpyHeader::parse(&text)?, 8 + n_length_bytes as u64 + n_text_bytes))
    }

    fn parse(text: &str) -> io::Result<NpyHeader> {
        let header = literal::parse(text)?;
        let LiteralValue::Dict(entries) = &header.value else {
            return Err(header.wrong("a dictionary"));
        };
        let entry = |name: &str| {
            let entry = entries.iter().find(|(key, _)| key == name);
            let entry = entry.map(|(_, literal)| literal);
            entry.ok_or_else(|| invalid(format!("its header lacks `{name}`")))
        };
        let descr = entry("descr")?;
        let (mut cells, mut at) = (Vec::new(), Some(0));
        add_cells(&mut cells, "", descr, &mut at)?;
        let order = entry("fortran_order")?;
        let LiteralValue::Bool(is_fortran) = order.value else {
            return Err(order.wrong("`True` or `False`"));
        };
        Ok(NpyHeader {
            cells,
            element_bytes: at.filter(|n| *n > 0),
            is_structured: matches!(descr.value, LiteralValue::Sequence(_)),
            shape: shape_of(entry("shape")?)?,
            is_fortran,
        })
    }

    /// The type of an element, as the file has it; of a record, that of each field.
    pub fn dtype(&self) -> String {
        let field = |cell: &NpyCell| format!("('{}', '{}')", cell.name(), cell.type_name);
        match &self.cells[..] {
            [cell] if !self.is_structured => format!("'{}'", cell.type_name),
            cells => format!("[{}]", joined(cells.iter().map(field), ", ")),
        }
    }
}

/// Returns the sizes along the axes of an array or of a field.
fn shape_of(shape: &Literal) -> io::Result<Vec<u64>> {
    let size = |size: &Literal| match size.value {
        LiteralValue::Int(n) => u64::try_from(n).map_err(|_| size.wrong("a size from 0 to 10¹⁸")),
        _ => Err(size.wrong("a size, which is a whole number")),
    };
    let axes: Vec<u64> = shape
        .items("a tuple of sizes, such as (1000, 4)")?
        .iter()
        .map(size)
        .collect::<io::Result<_>>()?;
    // An axis of nothing makes no product smaller.
    let product = axes.iter().try_fold(1, |product: u64, n| product.checked_mul(*n.max(&1)));
    match product.filter(|product| *product < MAX_NUMBERS) {
        Some(_) => Ok(axes),
        None => Err(shape.wrong("a shape of fewer than 10¹⁸ numbers")),
    }
}

/// Adds the numbers of a type to those of a record. `at` counts the bytes before it while they have a fixed
/// number, up to [`MAX_RECORD_BYTES`].
fn add_cells(
    cells: &mut Vec<NpyCell>,
    field: &str,
    descr: &Literal,
    at: &mut Option<usize>,
) -> io::Result<()> {
    if let LiteralValue::Text(type_name) = &descr.value {
        let (cell, n_bytes) = NpyCell::parse(type_name, field, at.unwrap_or_default())
            .ok_or_else(|| descr.wrong("a type such as '<f8'"))?;
        cells.push(cell);
        let sum = at.zip(n_bytes).and_then(|(before, n_bytes)| before.checked_add(n_bytes));
        // Cells of no bytes are counted, too.
        *at = sum.filter(|n| (*n).max(cells.len()) <= MAX_RECORD_BYTES);
        return Ok(());
    }
    for inner in descr.items("a type such as '<f8', or a list of fields")? {
        let expected = "a field, such as ('x', '<f8') or ('normal', '<f4', (3,))";
        let (name, descr, shape) = match inner.items(expected)? {
            [name, descr] => (name, descr, Vec::new()),
            [name, descr, shape] => (name, descr, shape_of(shape)?),
            _ => return Err(inner.wrong(expected)),
        };
        let LiteralValue::Text(name) = &name.value else {
            return Err(name.wrong("the name of a field"));
        };
        let full = if field.is_empty() { name.clone() } else { format!("{field}.{name}") };
        let first = cells.len();
        for _ in 0..shape.iter().product() {
            let before = *at;
            add_cells(cells, &full, descr, at)?;
            // Of nothing there may be any number, and beyond the limit too.
            if at.is_none() || *at == before {
                break;
            }
        }
        // Padding has no name.
        if name.is_empty() {
            cells.truncate(first);
        } else if !shape.is_empty() {
            // Those of several axes are numbered through.
            for (i, cell) in cells[first..].iter_mut().enumerate() {
                (cell.field, cell.element) = (full.clone(), Some(i));
            }
        }
    }
    Ok(())
}

impl NpyCell {
    /// Parses `<f8` and the like; the number of bytes is `None` if it differs from one element to the next. Returns `None` for
    /// any other text.
    fn parse(name: &str, field: &str, offset: usize) -> Option<(NpyCell, Option<usize>)> {
        let (order, rest) = name.split_at_checked(1)?;
        let (code, rest) = rest.split_at_checked(1)?;
        if !["<", ">", "|"].contains(&order) {
            return None;
        }
        // Units of time stand behind.
        let n: Option<usize> = rest.split('[').next().and_then(|digits| digits.parse().ok());
        let kind = match (code, n) {
            ("b", Some(1)) => Some(Kind::Bool),
            ("i", Some(1 | 2 | 4 | 8)) => Some(Kind::Int),
            ("u", Some(1 | 2 | 4 | 8)) => Some(Kind::Uint),
            ("f", Some(2 | 4 | 8)) => Some(Kind::Float),
            _ => None,
        };
        let n_bytes = if code == "U" { n.and_then(|n| n.checked_mul(4)) } else { n };
        let cell = NpyCell {
            field: field.to_owned(),
            element: None,
            type_name: name.to_owned(),
            kind: kind.filter(|_| order != "|" || n == Some(1)),
            n_bytes: n_bytes.unwrap_or_default(),
            offset,
            is_big_endian: order == ">",
        };
        Some((cell, n_bytes))
    }

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

    /// The bits of the number in the record that `bytes` begin with, the lowest first; those of a signed
    /// one go on with its sign.
    pub fn bits(&self, bytes: &[u8]) -> u64 {
        let bytes = &bytes[self.offset..];
        // One load where there are enough bytes, which is quicker than a copy.
        let window = bytes.first_chunk().copied().unwrap_or_else(|| {
            let mut window = [0; 8];
            window[..bytes.len()].copy_from_slice(bytes);
            window
        });
        let n_unused = 64 - 8 * self.n_bytes as u32;
        let high = if self.is_big_endian {
            u64::from_be_bytes(window)
        } else {
            u64::from_le_bytes(window) << n_unused
        };
        match self.kind {
            Some(Kind::Int) => (high as i64 >> n_unused) as u64,
            _ => high >> n_unused,
        }
    }

    /// The f64 nearest to the number in the record that `bytes` begin with; NaN for what is no number.
    fn to_f64(&self, bytes: &[u8]) -> f64 {
        let Some(kind) = self.kind else { return f64::NAN };
        let bits = self.bits(bytes);
        match (kind, self.n_bytes) {
            (Kind::Float, 2) => f16::from_bits(bits as u16).to_f64(),
            (Kind::Float, 4) => f32::from_bits(bits as u32).into(),
            (Kind::Float, _) => f64::from_bits(bits),
            (Kind::Int, _) => bits as i64 as f64,
            (Kind::Bool | Kind::Uint, _) => bits as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::picture::hit_record::HitRecord;

    /// Returns the numbers of a file of these elements, one row after the other.
    fn numbers_of(descr: &str, shape: &[u64], data: &[u8]) -> Vec<f64> {
        let file = [header(descr, shape), data.to_vec()].concat();
        let array = Array::new(&file[..], Some(file.len() as u64), "a.npy".as_ref(), "numbers");
        let array = array.unwrap();
        let is_structured = array.header.is_structured;
        let array =
            if is_structured { array.records() } else { array.numbers(|_| true, "numbers") };
        let array = array.unwrap();
        let cells: Vec<(usize, usize)> = (0..array.header.cells.len()).map(|i| (i, i)).collect();
        let mut numbers = vec![f64::NAN; array.n_rows() * cells.len()];
        array.read(&cells, |row, cell, number| numbers[row * cells.len() + cell] = number).unwrap();
        numbers
    }

    #[test]
    fn each_dtype_is_read_back() {
        /// Adds the bytes of numbers of a type in both orders, with the numbers as f64.
        macro_rules! of_type {
            ($all:ident, $name:literal, $type:ty, $($number:expr),*) => {{
                let numbers: Vec<$type> = vec![$($number),*];
                let expected: Vec<f64> = numbers.iter().map(|&number| f64::from(number)).collect();
                let [little, big]: [Vec<u8>; 2] = [
                    numbers.iter().flat_map(|number| number.to_le_bytes()).collect(),
                    numbers.iter().flat_map(|number| number.to_be_bytes()).collect(),
                ];
                $all.push((format!("<{}", $name), little, expected.clone()));
                $all.push((format!(">{}", $name), big, expected));
            }};
        }
        let mut all: Vec<(String, Vec<u8>, Vec<f64>)> = vec![
            ("|b1".into(), vec![0, 1], vec![0.0, 1.0]),
            ("|u1".into(), vec![0, 255], vec![0.0, 255.0]),
            ("|i1".into(), vec![127, 128], vec![127.0, -128.0]),
            ("<i8".into(), (-3i64).to_le_bytes().repeat(2), vec![-3.0; 2]),
            (">i8".into(), i64::MIN.to_be_bytes().repeat(2), vec![-(2f64.powi(63)); 2]),
            ("<u8".into(), u64::MAX.to_le_bytes().repeat(2), vec![2f64.powi(64); 2]),
        ];
        of_type!(all, "u2", u16, 0x0102, u16::MAX);
        of_type!(all, "i2", i16, 0x0102, i16::MIN);
        of_type!(all, "u4", u32, 0x0102_0304, u32::MAX);
        of_type!(all, "i4", i32, 0x0102_0304, i32::MIN);
        of_type!(all, "f2", f16, f16::from_f32(0.1), f16::from_f32(-65504.0));
        of_type!(all, "f4", f32, 0.1, f32::MIN);
        of_type!(all, "f8", f64, 0.1, f64::MIN);
        for (dtype, data, expected) in all {
            assert_eq!(numbers_of(&format!("'{dtype}'"), &[2, 1], &data), expected, "{dtype}");
            assert_eq!(
                numbers_of(&format!("[('q', '{dtype}')]"), &[2], &data),
                expected,
                "{dtype}"
            );
            let of_two = numbers_of(&format!("[('q', '{dtype}', (2,))]"), &[1], &data);
            assert_eq!(of_two, expected, "{dtype}");
        }
    }

    #[test]
    fn each_record_of_hits_is_read_back() {
        for (rgb, alpha, level) in [(false, false, false), (true, false, true), (true, true, false)]
        {
            let layout = HitRecord { rgb, alpha, level };
            let file = layout.header(&[3, 5]);
            assert_eq!(file.len() % 64, 0);
            let (found, n_bytes) = NpyHeader::read(&mut &file[..]).unwrap();
            assert_eq!(n_bytes, file.len() as u64);
            assert_eq!(
                (found.element_bytes, &found.shape[..]),
                (Some(layout.bytes()), &[3, 5][..])
            );
            assert!(found.is_structured && !found.is_fortran);
            let fields: usize = layout.fields().map(|(_, _, n, _)| n).sum();
            assert_eq!(found.cells.len(), fields);
            assert_eq!(found.cells[2].name(), "normal:0");
        }
    }

    #[test]
    fn errors_of_headers_name_the_place() {
        for (text, expected) in [
            ("[1]", ", character 1: expected a dictionary, found (1)"),
            ("{'shape': ()}", " lacks `descr`"),
            ("{'descr': '<f8', 'fortran_order': False}", " lacks `shape`"),
            ("{'descr': 'f8'}", ", character 11: expected a type such as '<f8', found `'f8'`"),
            (
                "{'descr': 8}",
                ", character 11: expected a type such as '<f8', or a list of fields, found `8`",
            ),
            (
                "{'descr': [('x',)]}",
                ", character 12: expected a field, such as ('x', '<f8') or ('normal', '<f4', (3,)), found ('x')",
            ),
            ("{'descr': [(1, '<f8')]}", ", character 13: expected the name of a field, found `1`"),
            (
                "{'descr': '<f8', 'fortran_order': 0, 'shape': (3,)}",
                ", character 35: expected `True` or `False`, found `0`",
            ),
            (
                "{'descr': '<f8', 'fortran_order': True, 'shape': (3)}",
                ", character 50: expected a tuple of sizes, such as (1000, 4), found `3`",
            ),
            (
                "{'descr': '<f8', 'fortran_order': True, 'shape': (3, '4')}",
                ", character 54: expected a size, which is a whole number, found `'4'`",
            ),
            (
                "{'descr': '<f8', 'fortran_order': True, 'shape': (3000000000, 3000000000)}",
                ", character 50: expected a shape of fewer than 10¹⁸ numbers, found (3000000000, 3000000000)",
            ),
        ] {
            let error = NpyHeader::parse(text).err().unwrap().to_string();
            assert_eq!(error, format!("its header{expected}"), "{text}");
        }
    }

    #[test]
    fn no_damaged_header_panics() {
        let mut rng = ChaCha8Rng::seed_from_u64(20_260_219);
        let headers = [
            header("'<f8'", &[1000, 4]),
            HitRecord { rgb: true, alpha: true, level: true }.header(&[2, 3]),
            header(
                "[('a b', [('x', '>i2', (2, 2)), ('', '|V3')]), ('t', '<M8[ns]'), ('u', '<U7')]",
                &[9],
            ),
        ];
        let signs: Vec<char> = "'\"\\()[]{},: LTFxuU-0179é\n".chars().collect();
        let (mut n_read, mut n_refused) = (0, 0);
        for case in 0..20_000 {
            let whole = &headers[case % headers.len()];
            let mut text: Vec<char> = whole[10..].iter().copied().map(char::from).collect();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..text.len());
                let sign = signs[rng.random_range(0..signs.len())];
                match rng.random_range(0..5) {
                    0 => text[at] = sign,
                    1 => text.insert(at, sign),
                    2 => drop(text.remove(at)),
                    3 => drop(text.splice(at..at, [sign; 40])),
                    _ => text.truncate(at + 3),
                }
            }
            let text: String = text.into_iter().collect();
            match NpyHeader::parse(&text) {
                Ok(header) => {
                    assert!(header.element_bytes.is_none_or(|n| n <= MAX_RECORD_BYTES), "{text}");
                    n_read += 1;
                }
                Err(error) => {
                    let message = error.to_string();
                    let is_placed = message.starts_with("its header, character ")
                        && message.contains(": expected ")
                        && message.contains(", found ");
                    assert!(
                        is_placed || message.starts_with("its header lacks `"),
                        "{message}\n{text}"
                    );
                    n_refused += 1;
                }
            }
        }
        assert!(n_read > 1000 && n_refused > 1000, "{n_read} were read, {n_refused} were not");
    }
}
