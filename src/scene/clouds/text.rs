//! Rows of text: cells to numbers, a sphere and its colour.

use std::cell::Cell;

use super::Template;
use super::columns::Layout;
use super::elements::Elements;
use crate::scene::places::quoted;
use crate::scene::{Color, Sphere};

/// What is wrong in a row, with advice where that of the file's kind doesn't do.
pub(super) type Wrong = (String, Option<&'static str>);

/// Words for a number that is missing, in lower case, besides `nan`.
const MISSING: [&str; 6] = ["", "na", "n/a", "null", "none", "-"];

/// Makes spheres of rows of cells.
pub(super) struct TextRows {
    pub layout: Layout,
    pub template: Template,
    elements: Elements,
    /// True where no comma stands between cells, so that one may stand in a number.
    may_have_commas: bool,
    /// True once a comma stood in a number.
    pub has_commas: Cell<bool>,
}

impl TextRows {
    pub fn new(layout: Layout, template: Template, may_have_commas: bool) -> TextRows {
        let elements = match layout.element {
            Some(_) => Elements::new(),
            None => Elements::default(),
        };
        TextRows { layout, template, elements, may_have_commas, has_commas: Cell::new(false) }
    }

    /// The sphere of a row, and its colour as the file has it: numbers of whatever scale, or what
    /// it is coloured by. A cell that lacks is empty.
    pub fn sphere<'r>(
        &self,
        cell: impl Fn(usize) -> Option<&'r [u8]>,
    ) -> Result<(Sphere, Color), Wrong> {
        let cell = |column: usize| cell(column).unwrap_or_default();
        let number = |column: usize| self.number(cell(column)).map_err(|found| (found, None));
        let layout = &self.layout;
        let Template { mut sphere, color } = self.template;
        let mut color = color.unwrap_or_default();
        for (axis, &column) in layout.center.iter().enumerate() {
            sphere.center[axis] = number(column)?;
        }
        if let Some(column) = layout.radius {
            sphere.radius = layout.radius_factor * number(column)?;
        }
        for (channel, &column) in layout.color.iter().flatten().enumerate() {
            color.0[channel] = number(column)?;
        }
        if let Some(column) = layout.element {
            let [gives_radius, gives_color] = layout.element_gives;
            let symbol = String::from_utf8_lossy(cell(column));
            let element = self.elements.get(symbol.trim()).ok_or_else(|| {
                (
                    format!(
                        "no {} is known of an element {:?}",
                        if gives_radius { "radius" } else { "colour" },
                        quoted(symbol.trim())
                    ),
                    Some(UNKNOWN_ELEMENT),
                )
            })?;
            if gives_radius {
                sphere.radius = element.radius;
            }
            if gives_color {
                color = element.color;
            }
        }
        for (part, &column) in layout.color_by.iter().enumerate() {
            let cell = cell(column);
            color.0[part] = match number(column) {
                Ok(number) => number,
                Err(_) if is_missing(cell) => f64::NAN,
                Err(wrong) => return Err(wrong),
            };
        }
        Ok((sphere, color))
    }

    fn number(&self, cell: &[u8]) -> Result<f64, String> {
        let text = std::str::from_utf8(cell).ok();
        if let Some(number) = text.and_then(|text| text.parse().ok()) {
            return Ok(number);
        }
        let text = text.map(str::trim);
        if let Some(number) = text.and_then(|text| text.parse().ok()) {
            return Ok(number);
        }
        let with_comma = text.filter(|text| self.may_have_commas && !text.contains('.'));
        if let Some(number) = with_comma.and_then(|text| text.replacen(',', ".", 1).parse().ok()) {
            self.has_commas.set(true);
            return Ok(number);
        }
        Err(format!("{:?} is not a number", quoted(&String::from_utf8_lossy(cell))))
    }
}

fn is_missing(cell: &[u8]) -> bool {
    let text = String::from_utf8_lossy(cell).trim().to_lowercase();
    MISSING.contains(&&text[..])
}

const UNKNOWN_ELEMENT: &str = "an atom begins with its symbol in the periodic table, e.g. C, N or Fe; \
     spheres of other kinds have columns for their radius and colour (a .csv or .npy file, or \
     Properties= in .xyz), or `radius`, `color` and `columns = { element = false }` in the scene";
