//! Scenes in the languages of other renderers, so that their pictures can be compared with ours:
//! the same objects, the same camera, flat colours or the scene's lights, one ray through the centre of
//! each pixel.
//!
//! A sky is written as the suns that it is made of. Samples are left to the renderer's options.
//! POV-Ray's picture of a lit scene has the bytes of ours, up to its rounding. Tachyon knows no gamma:
//! its picture holds linear light, its ambient light has no colour, and all its lights cast shadows.
//!
//! Every number of the scene is written so that it reads back as the same f64, and so are the
//! colours. What a renderer makes of them is its own: POV-Ray calculates in f64, and Tachyon's
//! reader rounds all numbers to f32.

mod pov;
mod tachyon;

use std::io::{self, Write};

use glam::DVec3;
use kugelblitz::lighting::{Lighting, PreparedLight};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Color, Object, Scene};

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

    /// The texts of the language, with light from nowhere; `None` where colours are as they are.
    fn syntax(self, ambient: Option<[f64; 3]>) -> Box<dyn Syntax> {
        match self {
            Language::Pov => Box::new(pov::Pov { ambient }),
            Language::Tachyon => Box::new(tachyon::Tachyon { ambient }),
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

/// Writes what `pixels` see of `scene`, lit as the scene is. Without light, a pixel of a PNG that the renderer makes has
/// exactly the bytes of a colour of [`Color::from_srgb8`].
///
/// # Errors
/// Those of `out`.
pub fn write(
    language: Language,
    scene: &Scene,
    pixels: &Pixels,
    out: &mut impl Write,
) -> io::Result<()> {
    let Pixels { view, width, height, .. } = pixels;
    let lighting = Lighting::new(scene, view);
    let syntax = language.syntax(lighting.as_ref().map(|lighting| lighting.ambient));
    out.write_all(syntax.head(view, [*width, *height], scene.background).as_bytes())?;
    let reach = reach(scene, view.position);
    for lamp in lighting.iter().flat_map(|lighting| &lighting.lamps) {
        writeln!(out, "{}", syntax.lamp(lamp, view.position, reach))?;
    }
    for (id, object) in scene.objects() {
        let (name, color) = (scene.name(id), scene.color(id));
        writeln!(out, "{}", syntax.object(id, name, object, color))?;
    }
    out.write_all(syntax.end().as_bytes())
}

/// The largest distance from `eye` to what is in the scene, the far sides of spheres and the points of
/// planes; at least 1.
fn reach(scene: &Scene, eye: DVec3) -> f64 {
    let extents = scene.objects().map(|(_, object)| object.extent());
    extents.map(|(at, radius)| at.distance(eye) + radius).fold(1.0, f64::max)
}

/// The texts of a language.
trait Syntax {
    /// All before the lamps and objects.
    fn head(&self, view: &View, size: [u32; 2], background: Color) -> String;
    /// One line. Nothing is farther than `reach` from `eye`.
    fn lamp(&self, lamp: &PreparedLight, eye: DVec3, reach: f64) -> String;
    /// One line.
    fn object(&self, id: u32, name: Option<&str>, object: Object, color: Color) -> String;
    /// All after the objects.
    fn end(&self) -> &'static str {
        ""
    }
}

/// Numbers between a separator. Debug prints the shortest text that reads back as the same f64,
/// and an exponent where digits would be many.
fn separated(numbers: &[f64], separator: &str) -> String {
    let texts: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
    texts.join(separator)
}
