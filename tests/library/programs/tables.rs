//! One table in all its forms: separators, decimal marks, quotes, line ends, headers, units and encodings.

use kugelblitz_tests::folder::Folder;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Keys, read};

/// x, y, z and radius.
type Row = [f64; 4];

/// Names of the columns of each header.
const HEADERS: [[&str; 4]; 6] = [
    ["x", "y", "z", "r"],
    ["X", "Y", "Z", "Radius"],
    ["pos_x", "pos_y", "pos_z", "radius"],
    ["Position X", "Position Y", "Position Z", "R"],
    ["Points:0", "Points:1", "Points:2", "radii"],
    ["x", "y", "z", "diameter"],
];

/// Units of a column, and how many of them are a metre.
const UNITS: [(&str, f64); 4] = [("m", 1.0), ("cm", 100.0), ("mm", 1000.0), ("um", 1e6)];

/// The form of a table.
#[derive(Clone, Debug)]
struct Form {
    separator: char,
    mark: char,
    quotes: Quotes,
    line_end: &'static str,
    names: [&'static str; 4],
    header: HeaderForm,
    /// Unit of each column, from [`UNITS`]; `None` for a table without units.
    units: Option<[usize; 4]>,
    row_names: RowNames,
    has_exponents: bool,
    ends_in_separator: bool,
    ends_in_line_end: bool,
    has_colors: bool,
    encoding: Encoding,
    /// Places of the columns.
    order: [usize; 4],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Quotes {
    None,
    Names,
    All,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum HeaderForm {
    Baseline,
    /// After comments and an empty line.
    AfterComments,
    /// Itself a comment.
    Hash,
    Slashes,
    /// After Excel's line `sep=`.
    Excel,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum RowNames {
    None,
    /// Under an empty name.
    Unnamed,
    /// With a header of one cell less, as R writes it.
    WithoutCell,
    /// Words under a name.
    Words,
}

#[derive(Clone, Copy, Debug)]
enum Encoding {
    Utf8,
    Marked,
    Utf16(fn(u16) -> [u8; 2]),
}

fn one_of<T: Copy>(rng: &mut ChaCha8Rng, all: &[T]) -> T {
    all[rng.random_range(0..all.len())]
}

impl Form {
    /// The plainest table.
    const PLAIN: Form = Form {
        separator: ',',
        mark: '.',
        quotes: Quotes::None,
        line_end: "\n",
        names: HEADERS[0],
        header: HeaderForm::Baseline,
        units: None,
        row_names: RowNames::None,
        has_exponents: false,
        ends_in_separator: false,
        ends_in_line_end: true,
        has_colors: false,
        encoding: Encoding::Utf8,
        order: [0, 1, 2, 3],
    };

    /// Draws a form in which a table means one thing only.
    fn random(rng: &mut ChaCha8Rng) -> Form {
        let mut order = [0, 1, 2, 3];
        order.shuffle(rng);
        let encodings = [
            Encoding::Utf8,
            Encoding::Utf8,
            Encoding::Marked,
            Encoding::Utf16(u16::to_le_bytes),
            Encoding::Utf16(u16::to_be_bytes),
        ];
        let row_names = [
            RowNames::None,
            RowNames::None,
            RowNames::Unnamed,
            RowNames::WithoutCell,
            RowNames::Words,
        ];
        let headers = [
            HeaderForm::Baseline,
            HeaderForm::AfterComments,
            HeaderForm::Hash,
            HeaderForm::Slashes,
            HeaderForm::Excel,
        ];
        let has_units = rng.random_bool(0.4);
        let mut form = Form {
            separator: one_of(rng, &[',', ';', '\t', ' ']),
            mark: one_of(rng, &['.', ',']),
            quotes: one_of(rng, &[Quotes::None, Quotes::Names, Quotes::All]),
            line_end: one_of(rng, &["\n", "\r\n", "\r"]),
            names: one_of(rng, &HEADERS),
            header: one_of(rng, &headers),
            units: has_units.then(|| [(); 4].map(|()| rng.random_range(0..UNITS.len()))),
            row_names: one_of(rng, &row_names),
            has_exponents: rng.random_bool(0.3),
            ends_in_separator: rng.random_bool(0.2),
            ends_in_line_end: rng.random_bool(0.8),
            has_colors: rng.random_bool(0.3),
            encoding: one_of(rng, &encodings),
            order,
        };
        if form.separator == ',' && form.mark == ',' {
            form.quotes = Quotes::All;
        }
        if form.separator == ' ' {
            // White space of any length separates: there are no empty cells, and names have one word.
            form.ends_in_separator = false;
            if form.row_names == RowNames::Unnamed {
                form.row_names = RowNames::WithoutCell;
            }
            if form.names[0].contains(' ') {
                form.names = HEADERS[0];
            }
            if form.header == HeaderForm::Excel {
                form.header = HeaderForm::Baseline;
            }
        }
        let is_comment = matches!(form.header, HeaderForm::Hash | HeaderForm::Slashes);
        if form.row_names == RowNames::Unnamed && is_comment && form.separator == '\t' {
            // A tab after the mark of a comment is white space.
            form.row_names = RowNames::Words;
        }
        if form.row_names == RowNames::WithoutCell {
            // One cell more than names is a separator at the end or a row name, not both; R quotes names.
            form.ends_in_separator = false;
            if form.quotes == Quotes::None {
                form.quotes = Quotes::Names;
            }
        }
        form
    }

    fn cell(&self, text: String, is_name: bool) -> String {
        match self.quotes {
            Quotes::All => format!("\"{text}\""),
            Quotes::Names if is_name => format!("\"{text}\""),
            _ => text,
        }
    }

    fn line(&self, cells: Vec<String>) -> String {
        let mut line = cells.join(&self.separator.to_string());
        line.extend(self.ends_in_separator.then_some(self.separator));
        line + self.line_end
    }

    /// Writes a table of these rows.
    fn table(&self, rows: &[Row], colors: &[[u8; 3]]) -> Vec<u8> {
        let unit = |column: usize| self.units.map_or(("", 1.0), |units| UNITS[units[column]]);
        let mut names: Vec<String> = Vec::new();
        match self.row_names {
            RowNames::Unnamed => names.push(String::new()),
            RowNames::Words => names.push("label".into()),
            RowNames::None | RowNames::WithoutCell => {}
        }
        names.extend(self.order.iter().map(|&column| match self.units {
            // A space would begin another name.
            Some(_) if self.separator == ' ' => {
                format!("{}[{}]", self.names[column], unit(column).0)
            }
            Some(_) => format!("{} [{}]", self.names[column], unit(column).0),
            None => self.names[column].into(),
        }));
        names.extend(self.has_colors.then(|| "color".into()));
        let names = names.into_iter().map(|name| self.cell(name, true)).collect();
        let mut text = match self.header {
            HeaderForm::Baseline => String::new(),
            HeaderForm::AfterComments => {
                format!("# a measurement, 5 s{0}{0}# by hand{0}", self.line_end)
            }
            HeaderForm::Hash => "# ".into(),
            HeaderForm::Slashes => "//".into(),
            HeaderForm::Excel => format!("sep={}{}", self.separator, self.line_end),
        };
        text += &self.line(names);
        for (at, (row, color)) in rows.iter().zip(colors).enumerate() {
            let mut cells = Vec::new();
            match self.row_names {
                RowNames::Words => cells.push(format!("p{at}")),
                // R quotes them, whatever else is quoted.
                RowNames::WithoutCell if self.quotes != Quotes::All => {
                    cells.push(format!("\"{}\"", at + 1));
                }
                RowNames::Unnamed | RowNames::WithoutCell => cells.push((at + 1).to_string()),
                RowNames::None => {}
            }
            for &column in &self.order {
                let number = row[column] * unit(column).1;
                let number = if self.names[column] == "diameter" { 2.0 * number } else { number };
                let number =
                    if self.has_exponents { format!("{number:e}") } else { number.to_string() };
                cells.push(number.replace('.', &self.mark.to_string()));
            }
            cells.extend(self.has_colors.then(|| {
                let [red, green, blue] = color;
                format!("#{red:02x}{green:02x}{blue:02x}")
            }));
            text += &self.line(cells.into_iter().map(|cell| self.cell(cell, false)).collect());
        }
        if !self.ends_in_line_end {
            text.truncate(text.len() - self.line_end.len());
        }
        match self.encoding {
            Encoding::Utf8 => text.into_bytes(),
            Encoding::Marked => format!("\u{feff}{text}").into_bytes(),
            Encoding::Utf16(bytes) => {
                format!("\u{feff}{text}").encode_utf16().flat_map(bytes).collect()
            }
        }
    }
}

/// Numbers that have few binary digits: each of them is a number of f64 in every unit.
fn random_row(rng: &mut ChaCha8Rng) -> Row {
    let mut number = |low: i32, high: i32| f64::from(rng.random_range(low..high)) / 1024.0;
    let [x, y, z] = [(); 3].map(|()| number(-2_000_000, 2_000_000));
    [x, y, z, number(1, 100_000)]
}

/// Checks that a table reads as these rows, in metres or in the unit of x.
fn check(form: &Form, bytes: &[u8], rows: &[Row], colors: &[[u8; 3]], case: &str) {
    let folder = Folder::default();
    folder.write("a.txt", bytes);
    let shown = String::from_utf8_lossy(bytes);
    let composed = read(&folder.path("a.txt"), &Keys::default())
        .unwrap_or_else(|error| panic!("{case}: {error}\n{form:?}\n{shown}"));
    let scale = form.units.map_or(1.0, |units| UNITS[units[0]].1);
    let scene = composed.scene;
    let found: Vec<[u64; 4]> = scene
        .spheres
        .iter()
        .map(|sphere| {
            let [x, y, z] = sphere.center.to_array();
            [x, y, z, sphere.radius].map(f64::to_bits)
        })
        .collect();
    let expected: Vec<[u64; 4]> =
        rows.iter().map(|row| row.map(|number| (number * scale).to_bits())).collect();
    assert!(
        found == expected,
        "{case}: {:?}, expected {rows:?}\n{form:?}\n{shown}",
        &scene.spheres[..]
    );
    if form.has_colors {
        let found: Vec<[u8; 3]> = scene.spheres.colors().map(|color| color.to_srgb8()).collect();
        assert_eq!(found, colors, "{case}: {form:?}\n{shown}");
    }
}

/// A few rows and their colours. One row has a mark, so that the decimal mark of the file is known.
fn random_rows(rng: &mut ChaCha8Rng) -> (Vec<Row>, Vec<[u8; 3]>) {
    let n = rng.random_range(1..6);
    let mut rows: Vec<Row> = (0..n).map(|_| random_row(rng)).collect();
    if rng.random_bool(0.3) {
        rows.push([0.0, -1.0, 2.0, 1.0]);
    }
    let colors = rows.iter().map(|_| rng.random()).collect();
    (rows, colors)
}

#[test]
fn a_table_has_one_meaning_in_all_forms() {
    let seed = std::env::var("KUGELBLITZ_SEED").map_or(1, |seed| seed.parse().expect("a seed"));
    for case in 0..800 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(case);
        let form = Form::random(&mut rng);
        let (rows, colors) = random_rows(&mut rng);
        let bytes = form.table(&rows, &colors);
        check(&form, &bytes, &rows, &colors, &format!("case {case}, KUGELBLITZ_SEED={seed}"));
    }
}

/// Combines every separator, decimal mark, kind of quotes and line end.
#[test]
fn separators_marks_quotes_and_line_ends_combine() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_240_611);
    let mut n = 0;
    for separator in [',', ';', '\t', ' '] {
        for mark in ['.', ','] {
            for quotes in [Quotes::None, Quotes::Names, Quotes::All] {
                for line_end in ["\n", "\r\n", "\r"] {
                    if separator == ',' && mark == ',' && quotes != Quotes::All {
                        continue;
                    }
                    for header in [HeaderForm::Baseline, HeaderForm::Hash] {
                        let form =
                            Form { separator, mark, quotes, line_end, header, ..Form::PLAIN };
                        let (rows, colors) = random_rows(&mut rng);
                        check(&form, &form.table(&rows, &colors), &rows, &colors, "combined");
                        n += 1;
                    }
                }
            }
        }
    }
    assert_eq!(n, 132);
}

/// Spoils one number of a table: the check must notice.
#[test]
fn a_wrong_number_in_a_table_is_noticed() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (rows, colors) = random_rows(&mut rng);
    for column in 0..4 {
        let mut wrong = rows.clone();
        wrong[0][column] += 1.0 / 1024.0;
        let bytes = Form::PLAIN.table(&wrong, &colors);
        let noticed = std::panic::catch_unwind(|| check(&Form::PLAIN, &bytes, &rows, &colors, ""));
        assert!(noticed.is_err(), "column {column}");
    }
}
