//! Files that are read, and files that are refused with advice.

/// A file, and what its spheres must be.
pub struct Readable {
    pub file: &'static str,
    /// Keys of the cloud, as TOML.
    pub keys: &'static str,
    /// Each sphere: x, y, z, radius and colour.
    pub spheres: &'static [&'static str],
    /// All notes, in their order.
    pub notes: &'static [&'static str],
}

/// A file, and the error that it must give.
pub struct Refused {
    pub file: &'static str,
    /// Keys of the cloud, as TOML.
    pub keys: &'static str,
    /// Line, row, column and key of the error, each if it is known.
    pub place: &'static str,
    /// Offending value.
    pub value: &'static str,
    pub message: &'static str,
    pub hint: &'static str,
    pub cure: Cure,
}

/// Effect of the advice.
pub enum Cure {
    /// Each alternative of the hint makes the file readable; the first one gives these spheres.
    Settings(&'static [&'static str]),
    /// The chosen alternatives of one hint after the other make it readable.
    Steps(&'static [usize], &'static [&'static str]),
    /// The file with the first text replaced by the second one is readable.
    Edit(&'static str, &'static str, &'static [&'static str]),
    /// The file must be written again by its program.
    Elsewhere,
    /// The hint names the end of a range, or a similar name: the intention of the user is unknown.
    Unknown,
}

use Cure::{Edit, Elsewhere, Settings, Steps, Unknown};

const fn reads(
    file: &'static str,
    keys: &'static str,
    spheres: &'static [&'static str],
    notes: &'static [&'static str],
) -> Readable {
    Readable { file, keys, spheres, notes }
}

const fn refuses(
    file: &'static str,
    keys: &'static str,
    [place, value]: [&'static str; 2],
    message: &'static str,
    hint: &'static str,
    cure: Cure,
) -> Refused {
    Refused { file, keys, place, value, message, hint, cure }
}

/// The note of a chosen radius.
macro_rules! no_radius {
    ($radius:literal) => {
        concat!(
            "no column is known as the radius: each sphere gets ",
            $radius,
            ", half the median distance between neighbours; `radius` gives another one"
        )
    };
    ($radius:literal, $unused:literal) => {
        concat!(
            "no column is known as the radius (columns not used: ",
            $unused,
            "): each sphere gets ",
            $radius,
            ", half the median distance between neighbours; `radius` gives another one"
        )
    };
}

/// The note of commas in numbers.
macro_rules! commas {
    ($found:literal) => {
        concat!("commas in numbers are read as decimal marks: ", $found)
    };
}

const BYTES: &str = "its colours are whole numbers up to 255, read as sRGB";
const FLOATS: &str = "its colours are numbers up to 1, read as sRGB; `color_space = \"linear\"` reads them as linear";
const ELEMENTS: &str = "radii are the van der Waals radii of the elements, in ångström";
const BOX: &str = "the box is not drawn";

/// Two spheres of two common colours.
const GREENS: &[&str] = &["0 0 0 1 #2e995f", "2 0 0 1 #00ff01"];
/// Two spheres of one radius, and of two.
const EQUAL: &[&str] = &["0 0 0 1 #8fb4d9", "2 0 0 1 #8fb4d9"];
const UNEQUAL: &[&str] = &["0 0 0 1 #8fb4d9", "2 0 0 0.5 #8fb4d9"];
const WATER: &[&str] = &["0 0 0 1.5 #ff0d0d", "0.96 0 0 1.2 #ffffff", "-0.24 0.93 0 1.2 #ffffff"];

/// All readable cases.
pub const READABLE: &[Readable] = &[
    // Units of length.
    reads(
        "units.csv",
        "",
        &["0 0 0 0.2 #8fb4d9", "0.5 0 0 0.2 #8fb4d9", "1 0 0 0.15 #8fb4d9"],
        &["`diameter [mm]` is converted to m, the unit of `x [m]`"],
    ),
    reads("units_x_only.csv", "", &["0 0 0 4 #8fb4d9", "5 0 0 2 #8fb4d9"], &[]),
    reads("units_pixels.csv", "", &["0 0 0 4 #8fb4d9", "5 0 0 2 #8fb4d9"], &[]),
    reads(
        "units_h.csv",
        "",
        &["0.5 0 0 0.25 #8fb4d9", "1.5 0 0 0.125 #8fb4d9"],
        &["`r [kpc/h]` is converted to Mpc/h, the unit of `x [Mpc/h]`"],
    ),
    reads(
        "units_line.csv",
        "",
        &["0 0 0 0.25 #8fb4d9", "1.5 0 0 0.125 #8fb4d9"],
        &["`r [mm]` is converted to m, the unit of `x [m]`"],
    ),
    // Decimal marks.
    reads("thousands.csv", "", &["1234567.5 0 0 1000.5 #8fb4d9", "1234 -2500 0 100 #8fb4d9"], &[]),
    reads(
        "thousands_german.csv",
        "",
        &["1234567.5 0 0 1000.5 #8fb4d9", "1.234 -2.5 0 100 #8fb4d9"],
        &[commas!("\"1.234.567,5\" in line 2 is 1234567.5")],
    ),
    reads(
        "decimal_comma.csv",
        "",
        &["1.234 0 0 0.5 #8fb4d9", "-2.5 0 0 1 #8fb4d9"],
        &[commas!("\"1,234\" in line 2 is 1.234")],
    ),
    reads(
        "quoted_commas.csv",
        "",
        &["1.5 0 0 0.25 #8fb4d9", "-1.5 0 0 1 #8fb4d9"],
        &[commas!("\"1,5\" in line 2 is 1.5")],
    ),
    reads(
        "r_csv2.csv",
        "",
        &["0 0 0 1 #8fb4d9", "2.5 0 0 0.5 #8fb4d9"],
        &[commas!("\"2,5\" in line 3 is 2.5")],
    ),
    // Colours.
    reads("hex.csv", "", &["0 0 0 1 #ff0000", "2 0 0 1 #00ff00"], &[]),
    reads("hex_comment.txt", "", &["0 0 0 1 #ff8000", "2 0 0 1 #00ff00"], &[]),
    reads("names.csv", "", &["0 0 0 1 #4682b4", "2 0 0 1 #ff0000", "4 0 0 1 #00ff00"], &[]),
    reads("bytes.csv", "", GREENS, &[BYTES]),
    reads("bytes.csv", "color_space = \"srgb\"", GREENS, &[]),
    reads("floats.csv", "", &["0 0 0 1 #2e995f", "2 0 0 1 #00ff00"], &[FLOATS]),
    reads("floats.csv", "color_space = \"srgb\"", &["0 0 0 1 #2e995f", "2 0 0 1 #00ff00"], &[]),
    reads(
        "floats_linear.csv",
        "color_space = \"linear\"",
        &["0 0 0 1 #2e995f", "2 0 0 1 #00ff00"],
        &[],
    ),
    reads("packed.csv", "", GREENS, &[]),
    reads("pcl_floats.csv", "", GREENS, &[]),
    reads("pcl_alpha.csv", "", GREENS, &[]),
    reads("pcl_rgb.npy", "", GREENS, &[no_radius!("1.0")]),
    reads("pcl_float_rgb.npy", "", GREENS, &[no_radius!("1.0")]),
    reads("rgb.csv", "", GREENS, &[no_radius!("1.0"), BYTES]),
    reads("opaque.csv", "", GREENS, &[BYTES]),
    reads("dark.csv", "", &["0 0 0 1 #000000", "2 0 0 1 #000100"], &[BYTES]),
    reads("rgba.npy", "", &["0 0 0 1 #ff0000", "2 0 0 1 #ff0000"], &[FLOATS]),
    reads("fields.npy", "", &["0 0 0 1 #2e995f", "2 0 0 0.5 #00ff01"], &[BYTES]),
    reads("colors.npy", "", &["0 0 0 1 #2e995f", "2 0 0 0.5 #00ff00"], &[FLOATS]),
    reads(
        "six.npy",
        "columns = { red = 3, green = 4, blue = 5 }",
        &["0 0 0 1 #2e995f", "2 0 0 1 #01ff01"],
        &[no_radius!("1.0"), BYTES],
    ),
    reads("ase_colors.xyz", "", &["0 0 0 1.77 #808080", "4 0 0 1.77 #ff8000"], &[ELEMENTS, FLOATS]),
    reads("cloudcompare.txt", "", GREENS, &[no_radius!("1.0", "Intensity"), BYTES]),
    reads(
        "cloudcompare_floats.asc",
        "",
        &["0 0 0 1 #2e995f", "2 0 0 1 #00ff00"],
        &[no_radius!("1.0"), FLOATS],
    ),
    reads(
        "clusters.csv",
        "color_by = \"color\"",
        &["0 0 0 1 #440154", "2 0 0 1 #fde725"],
        &["coloured by `color`, viridis from 3.0 to 7.0"],
    ),
    reads(
        "kinds.csv",
        "color_by = \"active\"",
        &["0 0 0 1 #fde725", "2 0 0 1 #440154", "4 0 0 1 #fde725"],
        &["coloured by `active`, viridis from 0.0 to 1.0"],
    ),
    reads("kinds.csv", "", &["0 0 0 1 #8fb4d9", "2 0 0 1 #8fb4d9", "4 0 0 1 #8fb4d9"], &[]),
    // Atoms.
    reads("water.xyz", "", WATER, &[ELEMENTS]),
    reads("water.xyz.gz", "", WATER, &[ELEMENTS]),
    reads(
        "water.xyz",
        "columns = { radius = false }",
        &["0 0 0 0.48 #ff0d0d", "0.96 0 0 0.48 #ffffff", "-0.24 0.93 0 0.48 #ffffff"],
        &[no_radius!("0.48")],
    ),
    reads(
        "water.xyz",
        "radius = 0.25\ncolumns = { color = false }",
        &["0 0 0 0.25 #8fb4d9", "0.96 0 0 0.25 #8fb4d9", "-0.24 0.93 0 0.25 #8fb4d9"],
        &[],
    ),
    reads("bom.xyz", "", &["0 0 0 1.5 #ff0d0d", "1 0 0 1.2 #ffffff"], &[ELEMENTS]),
    reads(
        "ca_trace.xyz",
        "",
        &["0 0 0 2.62 #3dff00", "3.8 0 0 2.62 #3dff00", "7.6 0 0 2.62 #3dff00"],
        &[
            ELEMENTS,
            "`CA` in line 3 is read as the element calcium; if it is the Cα atom of a protein, draw all labels alike with `columns = { element = false }`",
        ],
    ),
    reads(
        "ca_trace.xyz",
        "columns = { element = false }",
        &["0 0 0 1.9 #8fb4d9", "3.8 0 0 1.9 #8fb4d9", "7.6 0 0 1.9 #8fb4d9"],
        &[no_radius!("1.9", "element")],
    ),
    reads(
        "lammps_types.xyz",
        "",
        &["0 0 0 0.986 #8fb4d9", "2 0 0 0.986 #8fb4d9", "1 1.7 0 0.986 #8fb4d9"],
        &[no_radius!("0.986"), "\"1\" and the other labels are read as types, not as elements"],
    ),
    reads(
        "lidar.xyz",
        "",
        &["0 0 0 0.5 #8fb4d9", "1 0 0 0.5 #8fb4d9", "0.5 1 0 0.5 #8fb4d9"],
        &[no_radius!("0.5"), "no number of atoms in the first line: read as a table of x, y, z"],
    ),
    reads(
        "lattice.extxyz",
        "",
        &["1 2 3 0.5 #ff6600", "-1.5 0.25 0.004 2 #000000"],
        &["the box (Lattice) is not drawn", FLOATS],
    ),
    reads(
        "protein.xyz",
        "columns = { element = false }\nradius = 0.5",
        &["0 0 0 0.5 #8fb4d9", "1.5 0 0 0.5 #8fb4d9", "2 1 0 0.5 #8fb4d9"],
        &[],
    ),
    // Boxes whose coordinates need no arithmetic that rounds. `boxes.rs` has the others.
    reads(
        "tilt_0.dump",
        "",
        &["0.5 0.5 0.5 2.17 #8fb4d9", "3 3 3 2.17 #8fb4d9"],
        &[no_radius!("2.17", "id, type"), BOX],
    ),
    reads(
        "lammps_tilted.dump",
        "",
        &["1.5 2.5 3.5 0.935 #8fb4d9", "3 4 6 0.935 #8fb4d9", "2.5 3 7.5 0.935 #8fb4d9"],
        &[no_radius!("0.935", "id, type, xs, ys, zs, xu, yu, zu, xsu, ysu, zsu, ix, iy, iz"), BOX],
    ),
    reads(
        "lammps_general.dump",
        "",
        &[
            "0.75 0.675 -1.5 0.971 #8fb4d9",
            "1.75 2.625 -2.5 0.971 #8fb4d9",
            "0.65 3.875 -3.5 0.971 #8fb4d9",
        ],
        &[no_radius!("0.971", "id, type, xs, ys, zs, xu, yu, zu, xsu, ysu, zsu"), BOX],
    ),
    reads(
        "lammps_box.dump",
        "",
        &["0 1 2 0.4 #8fb4d9", "1 2 3 0.4 #8fb4d9", "2 3 4 0.4 #8fb4d9"],
        &[BOX],
    ),
    reads(
        "lammps_box.dump.gz",
        "",
        &["0 1 2 0.4 #8fb4d9", "1 2 3 0.4 #8fb4d9", "2 3 4 0.4 #8fb4d9"],
        &[BOX],
    ),
    reads(
        "binary2txt.bin.txt",
        "",
        &["0 1 2 0.4 #8fb4d9", "1 2 3 0.4 #8fb4d9", "2 3 4 0.4 #8fb4d9"],
        &[BOX],
    ),
    reads("elements.dump", "", &["1 2 3 1.5 #ff0d0d", "2 2 3 1.2 #ffffff"], &[BOX, ELEMENTS]),
    // Trajectories.
    reads(
        "trajectory.xyz",
        "",
        &["0 0 0 1.5 #ff0d0d", "0 1 0 1.2 #ffffff"],
        &[
            ELEMENTS,
            "frame 0 of 3 frames; choose another one, for example the last one with `frame = -1`",
        ],
    ),
    reads("trajectory.xyz", "frame = 0", &["0 0 0 1.5 #ff0d0d", "0 1 0 1.2 #ffffff"], &[ELEMENTS]),
    reads("trajectory.xyz", "frame = -1", &["2 0 0 1.5 #ff0d0d", "2 1 0 1.2 #ffffff"], &[ELEMENTS]),
    reads("trajectory.xyz", "frame = -2", &["1 0 0 1.5 #ff0d0d", "1 1 0 1.2 #ffffff"], &[ELEMENTS]),
    reads("trajectory.xyz", "frame = 2", &["2 0 0 1.5 #ff0d0d", "2 1 0 1.2 #ffffff"], &[ELEMENTS]),
    reads(
        "trajectory.lammpstrj",
        "",
        &["0 0 0 1.5 #ff0d0d", "0 1 0 1.2 #ffffff"],
        &[
            BOX,
            ELEMENTS,
            "frame 0 of 3 frames; choose another one, for example the last one with `frame = -1`",
        ],
    ),
    reads(
        "trajectory.lammpstrj",
        "frame = -2",
        &["1 0 0 1.5 #ff0d0d", "1 1 0 1.2 #ffffff"],
        &[BOX, ELEMENTS],
    ),
    reads(
        "empty_first.melt",
        "frame = 1",
        &["0.1 0.1 0.1 0.05 #8fb4d9", "0.3 0.1 0.1 0.05 #8fb4d9"],
        &[BOX],
    ),
    // Headers of programs.
    reads("yade.txt", "", &["0 0 0 1 #8fb4d9", "2 0 0 1 #8fb4d9", "1 1.7 0 0.8 #8fb4d9"], &[]),
    reads("yade_attrs.txt", "", UNEQUAL, &[]),
    reads("yade_comment.txt", "", UNEQUAL, &[]),
    reads("savetxt.csv", "", EQUAL, &[]),
    reads("savetxt_text.txt", "columns = { x = 0, y = 1, z = 2, radius = 3 }", EQUAL, &[]),
    reads("counted_rows.txt", "columns = { x = 0, y = 1, z = 2, radius = 3 }", EQUAL, &[]),
    reads("latin1.csv.gz", "columns = { radius = \"Größe\" }", EQUAL, &[]),
    reads(
        "blocks.txt",
        "",
        EQUAL,
        &["empty lines separate blocks of rows, which are drawn together"],
    ),
    reads(
        "ions.xyz",
        "",
        &["0 0 0 2.5 #ab5cf2", "5 0 0 1.77 #909090", "0 5 0 1.82 #1ff01f"],
        &[ELEMENTS],
    ),
    reads("footer.txt", "", EQUAL, &[]),
    reads("comments.dat", "", UNEQUAL, &[]),
    reads("labels_below_comment.dat", "", UNEQUAL, &[]),
    reads("r_table.txt", "", UNEQUAL, &[]),
    reads("r_csv.csv", "", UNEQUAL, &[]),
    reads("pandas_index.csv", "", UNEQUAL, &[]),
    reads("pandas_index.tsv", "", UNEQUAL, &[]),
    reads("trailing.csv", "", UNEQUAL, &[]),
    reads("dem.csv", "", UNEQUAL, &[]),
    reads("fortran.dat", "", EQUAL, &[]),
    reads("fortran_exponents.dat", "", &["150 0 -1e-100 1 #8fb4d9", "2 0 0 1 #8fb4d9"], &[]),
    reads("title.csv", "header = 3", UNEQUAL, &[]),
    // Encodings.
    reads("mac.csv", "", EQUAL, &[]),
    reads(
        "excel_sep.csv",
        "",
        &["0 0 0 1 #8fb4d9", "2.5 0 0 1 #8fb4d9"],
        &[commas!("\"2,5\" in line 4 is 2.5")],
    ),
    reads(
        "excel_utf16.txt",
        "",
        &["0 0 0 1 #8fb4d9", "2.5 0 0 1 #8fb4d9"],
        &[commas!("\"2,5\" in line 3 is 2.5")],
    ),
    reads(
        "utf16_be.csv",
        "",
        &["0 0 0 1 #8fb4d9", "2.5 0 0 1 #8fb4d9"],
        &[commas!("\"2,5\" in line 3 is 2.5")],
    ),
    reads("table.csv.gz", "", EQUAL, &[]),
    reads("gzip.csv", "", EQUAL, &[]),
    reads("members.csv.gz", "", UNEQUAL, &[]),
    // Missing numbers.
    reads(
        "nan_row.csv",
        "missing = \"skip\"",
        EQUAL,
        &["1 of 3 rows without a coordinate or a radius left out"],
    ),
    reads(
        "missing_words.csv",
        "missing = \"skip\"",
        &["0 0 0 1 #8fb4d9", "4 0 0 1 #8fb4d9"],
        &["4 of 6 rows without a coordinate or a radius left out"],
    ),
    reads(
        "r_missing.csv",
        "missing = \"skip\"",
        &["0 0 0 1 #8fb4d9", "4 0 0 1 #8fb4d9"],
        &["2 of 4 rows without a coordinate or a radius left out"],
    ),
    reads(
        "nan.npy",
        "missing = \"skip\"",
        EQUAL,
        &["1 of 3 rows without a coordinate or a radius left out"],
    ),
    reads("savetxt.csv", "missing = \"skip\"", EQUAL, &[]),
    // Arrays.
    reads("big_endian.npy", "", UNEQUAL, &[]),
    reads("fortran_order.npy", "", UNEQUAL, &[]),
    reads("bytes.npy", "", EQUAL, &[no_radius!("1.0")]),
    reads("int64.npy", "", EQUAL, &[no_radius!("1.0")]),
    reads("float16.npy", "", EQUAL, &[no_radius!("1.0")]),
    reads("bool.npy", "", &["0 0 0 0.5 #8fb4d9", "1 0 0 0.5 #8fb4d9"], &[no_radius!("0.5")]),
];

const ROW: &str = "write a value for each column, numbers as 1.5 or 2e-3";
const CELLS: &str = "write a value for each column; begin a line that is not a row with #";
const TABLE: &str = "the first line names the columns: x, y, z, and optionally r or radius, and red, green, blue (0 to 1, or 0 to 255) \
                     or color (\"#rrggbb\"), with commas, semicolons, tabs or spaces between them";
const XYZ: &str = "the first line of an .xyz file is the number of atoms, the second a comment, and each further line an atom: its \
                   element, x, y and z in ångström; in the second, Properties= may name other columns";
const DUMP: &str = "a LAMMPS dump in text has for each step the lines ITEM: TIMESTEP, ITEM: NUMBER OF ATOMS, ITEM: BOX BOUNDS \
                    and ITEM: ATOMS with the names of columns, x, y and z among them";
const ARRAY: &str = "save an array of numbers of shape (N, 3): x, y, z; (N, 4): with r; (N, 7): with r, red, green, blue; or a \
                     structured array with fields of these names";
/// The command that saves an array as floats.
macro_rules! save_floats {
    ($name:literal) => {
        concat!(
            "save floats of up to 64 bits: `python3 -c \"import numpy; numpy.save('",
            $name,
            "-new.npy', numpy.load('",
            $name,
            ".npy').astype(float))\"`"
        )
    };
}
const SKIP: &str = "leave out such rows with `missing = \"skip\"`";
const LABELS: &str = "to draw all labels alike, give `columns = { element = false }`; or give `radius = 1` and `color = \"steelblue\"`";
const SCALES: &str =
    "red, green and blue are from 0 to 1; or whole numbers from 0 to 255 in all rows";
const LIKE_COLOR: &str = "the column may be the colour, but its name is not a known one";

/// All refused cases.
pub const REFUSED: &[Refused] = &[
    // Units of length.
    refuses(
        "units_unknown.csv",
        "",
        ["column diameter [mm]", "mm"],
        "its unit cannot be converted to the unit of `x [px]`",
        "convert one of them in the file, so that both have the same unit",
        Edit("px", "mm", &["0 0 0 2 #8fb4d9", "5 0 0 1 #8fb4d9"]),
    ),
    refuses(
        "units_one_side.csv",
        "",
        ["column r [mm]", "mm"],
        "it has a unit, but `x` has none",
        "write the unit of `x` into the file, for example `x [mm]`",
        Edit("x,", "x [mm],", &["0 0 0 4 #8fb4d9", "5 0 0 2 #8fb4d9"]),
    ),
    refuses(
        "units_h_one_side.csv",
        "",
        ["column r [kpc]", "kpc"],
        "its unit cannot be converted to the unit of `x [Mpc/h]`",
        "convert one of them in the file, so that both have the same unit",
        Edit("Mpc/h", "kpc", &["0.5 0 0 250 #8fb4d9", "1.5 0 0 125 #8fb4d9"]),
    ),
    // Decimal marks.
    refuses(
        "two_marks.csv",
        "",
        ["line 2", "0.5"],
        "two decimal marks in one file: \"1,234\" in line 2, \"0.5\" here",
        "write all numbers with the same decimal mark",
        Edit("1,234", "1.234", &["1.234 0 0 0.5 #8fb4d9", "999.5 0 0 0.5 #8fb4d9"]),
    ),
    // Colours.
    refuses(
        "clusters.csv",
        "",
        ["line 2, column color", "3"],
        "expected a colour, found \"3\"",
        "if its numbers are not colours, apply a colour map with `color_by = \"color\"`, or ignore them with \
         `columns = { color = false }`",
        Settings(&["0 0 0 1 #440154", "2 0 0 1 #fde725"]),
    ),
    refuses(
        "half_rgb.csv",
        "",
        ["line 2, column rgb", "0.5"],
        "expected a colour, found \"0.5\"",
        "if its numbers are not colours, apply a colour map with `color_by = \"rgb\"`, or ignore them with \
         `columns = { color = false }`",
        Settings(&["0 0 0 1 #fde725", "2 0 0 1 #440154"]),
    ),
    refuses(
        "paints.csv",
        "",
        ["line 3, column color", "sand"],
        "expected a colour, found \"sand\"",
        "write \"#rrggbb\" or a CSS name in each row, or ignore the column with `columns = { color = false }`",
        Settings(EQUAL),
    ),
    refuses(
        "color_class.csv",
        "",
        ["column color class", ""],
        LIKE_COLOR,
        "to use it, give `columns = { color = \"color class\" }`; to ignore it, `columns = { color = false }`",
        Settings(&["0 0 0 1 #000003", "2 0 0 1 #000007"]),
    ),
    refuses(
        "two_parts.csv",
        "",
        ["", ""],
        "the header has a part of a colour, but no column `blue`",
        "name it with `columns = { blue = \"NAME\" }`, or ignore the colours with `columns = { color = false }`",
        Settings(EQUAL),
    ),
    refuses(
        "two_parts.csv",
        "columns = { blue = \"b_valu\" }",
        ["", ""],
        "the header has no column \"b_valu\"",
        "did you mean \"b_value\"? its columns are x, y, z, radius, red, green, b_value",
        Unknown,
    ),
    refuses(
        "mixed_scales.csv",
        "",
        ["line 3", ""],
        "the colour is (200.0, 0.0, 1.0)",
        SCALES,
        Edit("0.5,0.25,1", "5,25,1", &["0 0 0 1 #051901", "2 0 0 1 #c80001"]),
    ),
    refuses(
        "negative_color.csv",
        "",
        ["line 3", ""],
        "the colour is (0.5, -0.25, 1.0)",
        SCALES,
        Edit("0.5,-0.25,1", "0.2,0.4,1", &["0 0 0 1 #8040ff", "2 0 0 1 #3366ff"]),
    ),
    refuses(
        "transparent.csv",
        "",
        ["line 3", ""],
        "the alpha is 128.0, but spheres are opaque",
        "to ignore alpha, name the columns of the colour: `columns = { red = \"r\", green = \"g\", blue = \"b\" }`",
        Settings(GREENS),
    ),
    refuses(
        "transparent_floats.csv",
        "",
        ["line 2", ""],
        "the alpha is 0.5, but spheres are opaque",
        "to ignore alpha, name the columns of the colour: `columns = { red = \"red\", green = \"green\", blue = \"blue\" }`",
        Settings(&["0 0 0 1 #8040ff", "2 0 0 1 #00ff00"]),
    ),
    refuses(
        "rgba_half.npy",
        "",
        ["row 1", ""],
        "the alpha is 0.5, but spheres are opaque",
        "to ignore alpha, name the columns of the colour: `columns = { red = \"rgba:0\", green = \"rgba:1\", blue = \"rgba:2\" }`",
        Settings(&["0 0 0 1 #ff0000", "2 0 0 1 #ff0000"]),
    ),
    refuses(
        "labels.npy",
        "",
        ["column color", ""],
        "expected numbers, found the type <U3",
        "save the colours as three columns red, green, blue; or ignore them with `columns = { color = false }`",
        Settings(&["0 0 0 1 #8fb4d9"]),
    ),
    refuses(
        "hex.csv",
        "color = \"red\"",
        ["key color", ""],
        "the file has a colour for each sphere, but `color` is given as well",
        "remove `color`, or ignore the file's with `columns = { color = false }`",
        Settings(&["0 0 0 1 #ff0000", "2 0 0 1 #00ff00"]),
    ),
    refuses(
        "kinds.csv",
        "color_by = \"kind\"",
        ["line 2, column kind", "sand"],
        "expected numbers, found words such as \"sand\"",
        "colour maps need numbers; name a column of numbers, for example `color_by = \"active\"`",
        Settings(&["0 0 0 1 #fde725", "2 0 0 1 #440154", "4 0 0 1 #fde725"]),
    ),
    refuses(
        "word_columns.csv",
        "color_by = \"kind\"",
        ["line 2, column kind", "sand"],
        "expected numbers, found words such as \"sand\"",
        "colour maps need numbers; name a column of numbers, for example `color_by = \"x\"`",
        Settings(&["0 0 0 1 #440154", "2 0 0 1 #fde725"]),
    ),
    refuses(
        "r_words.txt",
        "color_by = \"kind\"",
        ["line 2, column kind", "sand"],
        "expected numbers, found words such as \"sand\"",
        "colour maps need numbers; name a column of numbers, for example `color_by = \"x\"`",
        Settings(&["0 0 0 1 #440154", "2 0 0 0.5 #fde725"]),
    ),
    // Radii.
    refuses(
        "influence.csv",
        "",
        ["column radius_of_influence", ""],
        "the column may be the radius, but its name is not a known one",
        "to use it, give `columns = { radius = \"radius_of_influence\" }`; to ignore it, `columns = { radius = false }`",
        Settings(&["0 0 0 5 #8fb4d9", "2 0 0 5 #8fb4d9"]),
    ),
    refuses(
        "two_radii.csv",
        "",
        ["", ""],
        "both \"r\" and \"radius\" may be the radius",
        "choose one, for example with `columns = { radius = \"r\" }`",
        Settings(&["0 0 0 1 #8fb4d9", "5 0 0 1 #8fb4d9"]),
    ),
    refuses(
        "units.csv",
        "radius = 1",
        ["key radius", ""],
        "the file has a radius for each sphere, but `radius` is given as well",
        "remove `radius`, or ignore the file's with `columns = { radius = false }`",
        Settings(&["0 0 0 0.2 #8fb4d9", "0.5 0 0 0.2 #8fb4d9", "1 0 0 0.15 #8fb4d9"]),
    ),
    refuses(
        "negative_radius.csv",
        "",
        ["line 3", ""],
        "the radius is -1.0",
        "a radius is greater than 0",
        Edit("-1", "0.5", UNEQUAL),
    ),
    refuses(
        "zero_radius.csv",
        "",
        ["line 2", ""],
        "the radius is 0.0",
        "a radius is greater than 0",
        Edit("0,0,0,0", "0,0,0,1", EQUAL),
    ),
    // Names of columns.
    refuses(
        "two_x.csv",
        "",
        ["", ""],
        "the header has two columns `x`",
        "choose one with `columns = { x = \"x [m]\" }`",
        Settings(&["0 0 0 1 #8fb4d9", "5 0 0 2 #8fb4d9"]),
    ),
    refuses(
        "two_diameters.csv",
        "",
        ["", ""],
        "the header has two columns `diam`",
        "choose one with `columns = { diameter = \"diam [m]\" }`",
        Settings(&["0 0 0 1 #8fb4d9", "5 0 0 2 #8fb4d9"]),
    ),
    refuses(
        "same_names.csv",
        "",
        ["", ""],
        "the header has two columns `x`",
        "rename one of them",
        Edit("x,x", "x,a", &["0 0 0 1 #8fb4d9", "5 0 0 2 #8fb4d9"]),
    ),
    refuses(
        "grain_size.csv",
        "",
        ["", ""],
        "the header has no column `x`, only \"px, py, pz, grain\"",
        "name the columns, for example `columns = { x = \"px\", y = \"py\", z = \"pz\" }`",
        Settings(&["0 0 0 2.5 #8fb4d9", "5 0 0 2.5 #8fb4d9"]),
    ),
    refuses(
        "grain_size.csv",
        "columns = { x = \"px\" }",
        ["", ""],
        "the header has no column `y`, only \"px, py, pz, grain\"",
        "name the columns, for example `columns = { y = \"py\", z = \"pz\" }`",
        Settings(&["0 0 0 2.5 #8fb4d9", "5 0 0 2.5 #8fb4d9"]),
    ),
    refuses(
        "abc.csv",
        "",
        ["", ""],
        "the header has no column `x`, only \"a, b, c\"",
        "name the columns, for example `columns = { x = \"a\", y = \"b\", z = \"c\" }`",
        Settings(EQUAL),
    ),
    refuses(
        "html.csv",
        "",
        ["", ""],
        "the header has no column `x`, only \"<!DOCTYPE, html>\"",
        TABLE,
        Elsewhere,
    ),
    refuses(
        "halos.csv",
        "",
        ["column Rvir(kpc/h)", ""],
        "the column may be the radius, but its name is not a known one",
        "to use it, give `columns = { radius = \"Rvir(kpc/h)\" }`; to ignore it, `columns = { radius = false }`",
        Settings(EQUAL),
    ),
    refuses(
        "savetxt_text.txt",
        "columns = { x = 0, y = 1, z = 0, radius = 3 }",
        ["", ""],
        "`x` and `z` are the same column",
        "to give all spheres one coordinate, write `columns = { z = 0.0 }`, with a decimal point",
        Settings(EQUAL),
    ),
    refuses(
        "twod.csv",
        "",
        ["", ""],
        "the header has no column `z`, only \"id, x, y, r\"",
        "for data in a plane, give all spheres the same z with `columns = { z = 0.0 }`",
        Settings(EQUAL),
    ),
    refuses(
        "twod.dump",
        "",
        ["", ""],
        "ITEM: ATOMS has no column `z`, only \"id, type, x, y\"",
        "for data in a plane, give all spheres the same z with `columns = { z = 0.0 }`",
        Settings(&["1 1 0 1 #8fb4d9", "3 1 0 1 #8fb4d9"]),
    ),
    refuses(
        "no_header.csv",
        "",
        ["line 1", ""],
        "the table has no line with names of columns, and begins with \"0,0,0,1\"",
        "name columns by their place, from 0: `columns = { x = 0, y = 1, z = 2 }`; or `columns = { x = 0, y = 1, z = 2, radius = 3 }` if the fourth is the radius",
        Settings(EQUAL),
    ),
    refuses(
        "cloudcompare_bare.asc",
        "",
        ["line 1", ""],
        "the table has no line with names of columns, and begins with \"0 0 0\"",
        "name columns by their place, from 0: `columns = { x = 0, y = 1, z = 2 }`",
        Settings(EQUAL),
    ),
    // Lines above and below the header.
    refuses(
        "imaris.csv",
        "",
        ["line 2", ""],
        "expected names of columns, found \"Position\"",
        "line 4 looks like the header; use it with `header = 4`",
        Settings(&["161.035 101.236 70.1593 5.27 #8fb4d9", "150.5 101 70 5.27 #8fb4d9"]),
    ),
    refuses(
        "title.csv",
        "",
        ["line 1", ""],
        "expected names of columns, found \"Export, of, a, measurement\"",
        "line 3 looks like the header; use it with `header = 3`",
        Settings(UNEQUAL),
    ),
    refuses(
        "header_below.csv",
        "",
        ["line 2, column x", "metres"],
        "expected a number, found \"metres\"",
        "line 1 looks like the header, with more text below it; skip that with `header = 1`",
        Settings(UNEQUAL),
    ),
    refuses(
        "trackmate.csv",
        "",
        ["column MANUAL_SPOT_COLOR", ""],
        LIKE_COLOR,
        "to use it, give `columns = { color = \"MANUAL_SPOT_COLOR\" }`; to ignore it, `columns = { color = false }`",
        Steps(&[1, 0], &["1.5 2.5 0 5 #8fb4d9", "11.5 2.5 0 4 #8fb4d9"]),
    ),
    refuses(
        "title.csv",
        "header = 9",
        ["", ""],
        "the file has no line 9, which `header` names",
        "give a number up to `header = 5`",
        Unknown,
    ),
    refuses(
        "water.xyz",
        "header = 1",
        ["key header", ""],
        "the file is not a table",
        "remove `header`; it is for tables of text (.csv)",
        Settings(WATER),
    ),
    // Rows.
    refuses(
        "short_row.csv",
        "",
        ["line 3", ""],
        "expected 4 values, one for each column, found 3",
        CELLS,
        Edit("2,0,0", "2,0,0,0.5", UNEQUAL),
    ),
    refuses(
        "open_quote.csv",
        "",
        ["line 2", ""],
        "a quote is opened, but not closed",
        "close it, or remove it",
        Edit("\"a", "a", EQUAL),
    ),
    refuses(
        "fortran_stars.dat",
        "",
        ["line 3, column x", "********"],
        "expected a number, found \"********\"",
        ROW,
        Edit("********", "2.0", EQUAL),
    ),
    refuses(
        "empty.csv",
        "",
        ["", ""],
        "the data have no sphere",
        "give a row or a line for each sphere",
        Edit("r\n", "r\n0,0,0,1\n", &["0 0 0 1 #8fb4d9"]),
    ),
    // Missing numbers.
    refuses(
        "nan_row.csv",
        "",
        ["line 3", ""],
        "expected finite coordinates, found [NaN, NaN, NaN]",
        SKIP,
        Settings(EQUAL),
    ),
    refuses(
        "nan.npy",
        "",
        ["row 1", ""],
        "expected finite coordinates, found [NaN, 0.0, 0.0]",
        SKIP,
        Settings(EQUAL),
    ),
    refuses(
        "inf.csv",
        "",
        ["line 3", ""],
        "expected finite coordinates, found [inf, 0.0, 0.0]",
        SKIP,
        Settings(&["0 0 0 1 #8fb4d9"]),
    ),
    refuses(
        "missing_words.csv",
        "",
        ["line 3, column x", ""],
        "expected a number, found \"\"",
        SKIP,
        Settings(&["0 0 0 1 #8fb4d9", "4 0 0 1 #8fb4d9"]),
    ),
    refuses(
        "r_missing.csv",
        "",
        ["line 3, column x", "NA"],
        "expected a number, found \"NA\"",
        SKIP,
        Settings(&["0 0 0 1 #8fb4d9", "4 0 0 1 #8fb4d9"]),
    ),
    // Atoms.
    refuses(
        "protein.xyz",
        "",
        ["line 5", "OXT"],
        "the label \"OXT\" is no element with a known radius",
        LABELS,
        Settings(&["0 0 0 0.559 #8fb4d9", "1.5 0 0 0.559 #8fb4d9", "2 1 0 0.559 #8fb4d9"]),
    ),
    refuses(
        "polonium.xyz",
        "",
        ["line 3", "Po"],
        "the label \"Po\" is no element with a known radius",
        LABELS,
        Settings(&["0 0 0 1.5 #8fb4d9", "3 0 0 1.5 #8fb4d9"]),
    ),
    refuses(
        "mixed_labels.xyz",
        "",
        ["line 4", "1"],
        "the label \"1\" is no element with a known radius",
        LABELS,
        Settings(&["0 0 0 1.5 #8fb4d9", "3 0 0 1.5 #8fb4d9"]),
    ),
    refuses(
        "too_few.xyz",
        "",
        ["", ""],
        "expected 3 atoms, as line 1 gives, found 2 before the end of the file",
        "the file may be truncated; copy it again, or correct that line",
        Edit("3\n", "2\n", &["0 0 0 1.5 #ff0d0d", "0.96 0 0 1.2 #ffffff"]),
    ),
    refuses(
        "too_many.xyz",
        "",
        ["line 5", "H -0.24 0.93 0"],
        "expected the end of the file or another frame after the 2 atoms that line 1 gives",
        "correct the number of atoms in that line",
        Edit("2\n", "3\n", WATER),
    ),
    // Boxes.
    refuses(
        "no_box.dump",
        "",
        ["", ""],
        "scaled coordinates (xs ys zs) need ITEM: BOX BOUNDS, which is missing",
        "dump x y z instead",
        Edit("xs ys zs", "x y z", &["0.5 0.5 0.5 1 #8fb4d9"]),
    ),
    refuses(
        "mixed_general.dump",
        "",
        ["", ""],
        "scaled and unscaled coordinates together are not supported in a general triclinic box",
        "dump x y z, or xs ys zs",
        Edit("x ys z", "x y z", &["1 0.5 2 1 #8fb4d9"]),
    ),
    // Trajectories.
    refuses(
        "trajectory.xyz",
        "frame = 3",
        ["", ""],
        "the file has 3 frames, but no frame 3",
        "frames count from 0; the last one is `frame = 2`",
        Settings(&["2 0 0 1.5 #ff0d0d", "2 1 0 1.2 #ffffff"]),
    ),
    refuses(
        "trajectory.lammpstrj",
        "frame = -4",
        ["", ""],
        "the file has 3 frames, but no frame -4",
        "frames count from 0; the last one is `frame = 2`",
        Settings(&["2 0 0 1.5 #ff0d0d", "2 1 0 1.2 #ffffff"]),
    ),
    refuses(
        "empty_first.melt",
        "",
        ["", ""],
        "frame 0 of 2 has no atoms",
        "choose another frame, for example the last one: `frame = -1`",
        Settings(&["0.1 0.1 0.1 0.05 #8fb4d9", "0.3 0.1 0.1 0.05 #8fb4d9"]),
    ),
    refuses(
        "units.csv",
        "frame = 1",
        ["key frame", ""],
        "the file has no frames",
        "remove `frame`; it is for .xyz files and LAMMPS dumps",
        Settings(&["0 0 0 0.2 #8fb4d9", "0.5 0 0 0.2 #8fb4d9", "1 0 0 0.15 #8fb4d9"]),
    ),
    // Arrays.
    refuses(
        "plane.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found (2, 2)",
        "for data in a plane, give all spheres the same z with `columns = { z = 0.0 }`",
        Settings(&["0 0 0 0.5 #8fb4d9", "1 0 0 0.5 #8fb4d9"]),
    ),
    refuses(
        "five.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found (2, 5)",
        "the first three are x, y, z; name others by their place, from 0: `columns = { radius = 3 }`",
        Settings(EQUAL),
    ),
    refuses(
        "six.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found (2, 6)",
        "the first three are x, y, z; name others by their place, from 0: `columns = { radius = 3 }` or \
         `columns = { red = 3, green = 4, blue = 5 }`",
        Settings(&["0 0 0 46 #8fb4d9", "2 0 0 1 #8fb4d9"]),
    ),
    refuses(
        "transposed.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found (3, 5)",
        "each row must be a sphere; transpose the array: `python3 -c \"import numpy; \
         numpy.save('transposed-new.npy', numpy.load('transposed.npy').T)\"`",
        Elsewhere,
    ),
    refuses(
        "frames.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found (1, 2, 3)",
        ARRAY,
        Elsewhere,
    ),
    refuses(
        "flat.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found (6,)",
        ARRAY,
        Elsewhere,
    ),
    refuses(
        "complex.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found the type '<c16'",
        save_floats!("complex"),
        Elsewhere,
    ),
    refuses(
        "float128.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found the type '<f16'",
        save_floats!("float128"),
        Elsewhere,
    ),
    refuses(
        "text.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found the type '<U2'",
        save_floats!("text"),
        Elsewhere,
    ),
    refuses(
        "object.npy",
        "",
        ["", ""],
        "expected numbers of shape (N, 3), (N, 4) or (N, 7), found the type '|O'",
        "it holds Python objects; if you trust the file, save numbers: `python3 -c \"import numpy; numpy.save('object-new.npy', \
         numpy.load('object.npy', allow_pickle=True).astype(float))\"`",
        Elsewhere,
    ),
    refuses(
        "short.npy",
        "",
        ["", ""],
        "expected 24 bytes of data (2 rows, according to the header), found 20; the file may be truncated",
        ARRAY,
        Elsewhere,
    ),
    refuses(
        "ca_trace.xyz",
        "format = \"npy\"",
        ["", ""],
        "not a readable .npy file (it does not begin like one); expected a NumPy array of numbers",
        ARRAY,
        Elsewhere,
    ),
    refuses(
        "water.xyz",
        "format = \"lammps\"",
        ["line 1", "3"],
        "expected ITEM:, found \"3\"",
        DUMP,
        Elsewhere,
    ),
    refuses(
        "units.csv",
        "format = \"xyz\"",
        ["line 1", "x [m],y [m],z [m],diameter [mm]"],
        "expected a number of atoms, found \"x [m],y [m],z [m],diameter [mm]\"",
        XYZ,
        Elsewhere,
    ),
];
