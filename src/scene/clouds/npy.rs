//! Data in NumPy's format: tables of numbers, and structured arrays.

use super::columns::{ColumnLayout, Header, Part, put};
use super::text::FileColor;
use super::{CloudFile, Reading, RowError, RowPlace};
use crate::error::{Error, Hint, Result, Setting, SettingValue};
use crate::npy::{self, Array, NpyCell};
use crate::plain::Shown;
use crate::scene::Color;
use crate::scene::decode::Input;

/// Numbers of columns that need no names: x, y, z; with r; with r and red, green, blue.
const COLUMNS: [u64; 3] = [3, 4, 7];
const NAMES: [&str; 7] = ["x", "y", "z", "r", "red", "green", "blue"];

/// Largest number of columns.
const MAX_COLUMNS: u64 = u16::MAX as u64;

const HELP: &str = "save an array of numbers of shape (N, 3): x, y, z; (N, 4): with r; (N, 7): with r, red, green, blue; or a \
                    structured array with fields of these names";

/// Reads the spheres of an `.npy` file, in the order of its rows.
pub(super) fn read<'r>(cloud: &mut Reading<'_, 'r>, input: Input<'r>) -> Result<ColumnLayout> {
    let source = cloud.source;
    source.refuse_frame()?;
    source.refuse_header()?;
    let n_bytes = input.n_bytes();
    let has_names = source.keys.color_by.is_some() || source.keys.columns.is_some();
    let array = Array::new(input, n_bytes, &source.path, "a NumPy array of numbers");
    let array = array.map_err(|error| of_file(source, error))?;
    let array = if array.header.is_structured {
        array.records()
    } else {
        check_shape(source, &array.header, has_names)?;
        array.numbers(|_| true, "numbers")
    };
    let array = array.map_err(|error| of_file(source, error))?;
    let npy::NpyHeader { cells, is_structured, .. } = &array.header;

    let n = cells.len();
    // With other numbers of columns, only the coordinates are known.
    let n_named = if COLUMNS.contains(&(n as u64)) { n } else { n.min(3) };
    let by_place = |i: usize| NAMES[..n_named].get(i).map_or(i.to_string(), |name| (*name).into());
    let (what, names): (_, Vec<String>) = if *is_structured {
        ("the structured array", cells.iter().map(NpyCell::name).collect())
    } else {
        ("the array", (0..n).map(by_place).collect())
    };
    let header = Header { names: &names, what, help: HELP, has_elements: false, has_places: true };
    let mut notes = Vec::new();
    let layout = ColumnLayout::find(source, &header, &mut notes)?;
    notes.into_iter().for_each(|note| cloud.note(note));
    if layout.element.is_some() {
        let hint = Hint::new("remove `element` from {}", [Setting::named("columns")]);
        return Err(source.wrong("arrays have no elements", hint).into());
    }
    let sphere = cloud.template(&layout)?;
    if let Some(colors) = &mut cloud.file_colors {
        let is_byte = |(column, part, _): &(usize, Part, _)| match part {
            Part::Color(_) | Part::Alpha => cells[*column].is_byte(),
            _ => true,
        };
        colors.are_bytes = layout.parts.iter().all(is_byte);
    }
    let is_no_number = |(column, ..): &&(usize, Part, _)| cells[*column].kind.is_none();
    if let Some(&(column, part, _)) = layout.parts.iter().find(is_no_number) {
        let message = format!("expected numbers, found the type {}", cells[column].type_name);
        let hint = match part {
            Part::WholeColor { .. } => Hint::new(
                "save the colours as three columns red, green, blue; or ignore them with {}",
                [Setting::no_column("color")],
            ),
            _ => "save numbers: floats of up to 64 bits, integers or bool".into(),
        };
        return Err(source.wrong(message, hint).in_column(names[column].as_str()).into());
    }

    let n_rows = array.n_rows();
    cloud.reserve(n_rows)?;
    let n_colors = if cloud.color.is_none() { n_rows } else { 0 };
    cloud.spheres.resize(n_rows, sphere);
    cloud.colors.resize(n_colors, Color::default());
    let has_alpha = layout.parts.iter().any(|(_, part, _)| *part == Part::Alpha);
    let mut alphas = vec![f64::NAN; if has_alpha { n_rows } else { 0 }];
    let (spheres, colors) = (&mut cloud.spheres, &mut cloud.colors);
    // A value and not a row at a time: in Fortran order, a column comes first.
    let mut not_packed = None;
    let wanted: Vec<_> =
        layout.parts.iter().map(|&(column, part, factor)| (column, (part, factor))).collect();
    let read = array.read(&wanted, |row, (part, factor), value| {
        let mut unused = Color::default();
        let color = colors.get_mut(row).unwrap_or(&mut unused);
        match part {
            Part::Alpha => alphas[row] = value,
            Part::WholeColor { .. } => match packed(value) {
                Some(found) => *color = found.color,
                None => not_packed = not_packed.or(Some((row, value))),
            },
            _ => put(part, factor.apply(value), &mut spheres[row], color),
        }
    });
    read.map_err(|error| of_file(source, error))?;
    if let Some((row, value)) = not_packed {
        let settings = [Setting::no_column("color")];
        let hint = Hint::new(
            "save the colours as red, green, blue; or ignore the column with {}",
            settings,
        );
        let fault = RowError::new(format!("expected a packed colour, found {value:?}"), hint);
        return Err(source
            .wrong_row(RowPlace::Row(row as u64), fault.with_value(value.to_string()))
            .into());
    }
    let is_bytes = matches!(&layout.parts[..], [.., (_, Part::WholeColor { .. }, _)]);
    let mut n_kept = 0;
    for row in 0..n_rows {
        let sphere = cloud.spheres[row];
        if cloud.is_missing(&sphere) {
            cloud.n_missing += 1;
            continue;
        }
        let color = cloud.colors.get(row).copied();
        let alpha = alphas.get(row).copied().unwrap_or(f64::NAN);
        let seen = FileColor { color: color.unwrap_or_default(), alpha, is_bytes };
        cloud.check(sphere, seen, RowPlace::Row(row as u64))?;
        cloud.spheres[n_kept] = sphere;
        if let Some(color) = color {
            cloud.colors[n_kept] = color;
        }
        n_kept += 1;
    }
    cloud.spheres.truncate(n_kept);
    cloud.colors.truncate(n_kept);
    Ok(layout)
}

/// Reads a packed colour: PCL's float, whose bits are the bytes, or a whole number.
fn packed(value: f64) -> Option<FileColor> {
    if let Some(color) = FileColor::packed_in_float(value as f32) {
        return Some(color);
    }
    let is_whole = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    is_whole.then(|| FileColor::packed(value as u32))
}

/// Refuses an array that is not a table of numbers, with the step that makes it one.
fn check_shape(source: &CloudFile, header: &npy::NpyHeader, has_names: bool) -> Result<()> {
    let wrong = |found: String, hint: Hint| {
        Err(source
            .wrong(
                format!("expected numbers of shape (N, 3), (N, 4) or (N, 7), found {found}"),
                hint,
            )
            .into())
    };
    let npy::NpyHeader { shape, cells, .. } = header;
    let convert = |arguments: &str, step: &str| {
        let (path, stem) = (source.path.shown(), source.path.with_extension("").shown());
        format!(
            "`python3 -c \"import numpy; numpy.save('{stem}-new.npy', numpy.load('{path}'{arguments}){step})\"`"
        )
    };
    let is_number = matches!(&cells[..], [cell] if cell.kind.is_some());
    if !is_number {
        let hint = if header.dtype().contains('O') {
            let command = convert(", allow_pickle=True", ".astype(float)");
            format!("it holds Python objects; if you trust the file, save numbers: {command}")
        } else {
            format!("save floats of up to 64 bits: {}", convert("", ".astype(float)"))
        };
        return wrong(format!("the type {}", header.dtype()), hint.into());
    }
    let text = |shape: &[u64]| {
        let sides: Vec<String> = shape.iter().map(u64::to_string).collect();
        format!("({}{})", sides.join(", "), if sides.len() == 1 { "," } else { "" })
    };
    let number = |text: &str| SettingValue::Number(text.into());
    match shape[..] {
        [_, n] if COLUMNS.contains(&n) => Ok(()),
        [3, n] if n > 4 => {
            let hint =
                format!("each row must be a sphere; transpose the array: {}", convert("", ".T"));
            wrong(text(shape), hint.into())
        }
        [_, n] if has_names && (1..=MAX_COLUMNS).contains(&n) => Ok(()),
        [_, 2] => {
            let hint = Hint::new(
                "for data in a plane, give all spheres the same z with {}",
                [Setting::column("z", number("0.0"))],
            );
            wrong(text(shape), hint)
        }
        [_, n @ 3..=MAX_COLUMNS] => {
            let radius = Setting::column("radius", number("3"));
            let colors = [("red", "3"), ("green", "4"), ("blue", "5")];
            let colors = colors.map(|(key, place)| (key, number(place))).to_vec();
            let colors = Setting { key: "columns", value: Some(SettingValue::Table(colors)) };
            let hint = match n {
                5 => Hint::new(
                    "the first three are x, y, z; name others by their place, from 0: {}",
                    [radius],
                ),
                _ => Hint::new(
                    "the first three are x, y, z; name others by their place, from 0: {} or {}",
                    [radius, colors],
                ),
            };
            wrong(text(shape), hint)
        }
        _ => wrong(text(shape), HELP.into()),
    }
}

fn of_file(file: &CloudFile, error: Error) -> Error {
    match error {
        Error::Input { message, .. } => file.wrong(message, HELP).into(),
        Error::Io { source, .. } => file.failed(&source),
        other => other,
    }
}
