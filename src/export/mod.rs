//! Scenes in the languages of other renderers, so that their pictures can be compared with ours:
//! the same objects, the same camera, flat colours, one ray through the centre of each pixel.
//!
//! Every number of the scene is written so that it reads back as the same f64, and so are the
//! colours. What a renderer makes of them is its own: POV-Ray calculates in f64, and Tachyon's
//! reader rounds all numbers to f32.

mod pov;
mod tachyon;

use std::fmt;
use std::io::{self, Write};

use crate::rays::View;
use crate::scene::{Color, Object, Scene};

/// A language that scenes can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// The scene description language of POV-Ray 3.7.
    Pov,
    /// The scene files of Tachyon 0.99.
    Tachyon,
}

impl Language {
    /// All languages.
    pub const ALL: [Language; 2] = [Language::Pov, Language::Tachyon];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Language::Pov => "pov",
            Language::Tachyon => "tachyon",
        }
    }

    /// The renderer that reads it.
    pub fn renderer(self) -> &'static str {
        match self {
            Language::Pov => "POV-Ray",
            Language::Tachyon => "Tachyon",
        }
    }

    fn syntax(self) -> &'static dyn Syntax {
        match self {
            Language::Pov => &pov::Pov,
            Language::Tachyon => &tachyon::Tachyon,
        }
    }

    /// The command line that renders a file in this language as [`write()`] meant it.
    pub fn command(self, file: &str, [width, height]: [u32; 2]) -> String {
        match self {
            Language::Pov => format!("povray +I{file} +W{width} +H{height} -A -D"),
            Language::Tachyon => format!("tachyon {file} -format PNG -o {file}.png"),
        }
    }
}

/// Writes what `view` sees of `scene` in a picture of `size` pixels, width and height. Every object
/// has the colour that `color_of` gives its id, and so has the background, id 0; with
/// [`Color::from_srgb8`] a pixel of a PNG that the renderer makes has exactly these bytes.
///
/// # Errors
/// Those of `out`.
pub fn write(
    language: Language,
    scene: &Scene,
    view: &View,
    size: [u32; 2],
    color_of: impl Fn(u32) -> Color,
    out: &mut impl Write,
) -> io::Result<()> {
    let syntax = language.syntax();
    out.write_all(syntax.head(view, size, color_of(0)).as_bytes())?;
    for (id, object) in scene.objects() {
        let name = scene.name(id);
        writeln!(out, "{}", syntax.object(id, name, object, color_of(id)))?;
    }
    out.write_all(syntax.end().as_bytes())
}

/// The texts of a language.
trait Syntax {
    /// All before the objects.
    fn head(&self, view: &View, size: [u32; 2], background: Color) -> String;
    /// One line.
    fn object(&self, id: u32, name: Option<&str>, object: Object, color: Color) -> String;
    /// All after the objects.
    fn end(&self) -> &'static str {
        ""
    }
}

/// Numbers between a separator. Debug prints the shortest text that reads back as the same f64,
/// and an exponent where digits would be many.
struct Numbers<const N: usize> {
    numbers: [f64; N],
    separator: &'static str,
}

impl<const N: usize> fmt::Display for Numbers<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, number) in self.numbers.iter().enumerate() {
            let separator = if i == 0 { "" } else { self.separator };
            write!(f, "{separator}{number:?}")?;
        }
        Ok(())
    }
}
