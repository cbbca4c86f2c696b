//! What a picture can show of each pixel, and the colours for it: the modes of the window, and those
//! of `render --show`.

mod discriminant;
mod draw;
mod legend;
mod tint;

use kugelblitz::error::{Hint, Message, Setting};
use std::fmt;

pub use draw::{ShownPicture, draw, keep, n_steps, range_of_t, side_by_side};
pub use legend::Entry;
pub use tint::{Rgb, Tint, palette, tints};

use kugelblitz::Result;
use kugelblitz::picture::{ChannelBits, Format, PictureOptions};
use kugelblitz::query::Outputs;

use crate::wrong_usage;

/// The ways of looking at a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Show {
    /// The objects' colours.
    #[default]
    Color,
    /// `t`, which is the depth along the view axis.
    Depth,
    /// The unit normal.
    Normal,
    /// A colour for each id.
    Id,
    /// The sign of the discriminant: the lecture's figure 5.
    Discriminant,
    /// The kernel's result against exact arithmetic.
    Error,
    /// The stage that decided.
    Stage,
}

impl Show {
    /// In the order of the window's keys F1 to F7.
    pub const ALL: [Show; 7] = [
        Show::Color,
        Show::Depth,
        Show::Normal,
        Show::Id,
        Show::Discriminant,
        Show::Error,
        Show::Stage,
    ];

    /// The name and one sentence.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Show::Color => ("color", "Colour, with light and samples"),
            Show::Depth => ("depth", "Depth t along the view axis, on a logarithmic scale"),
            Show::Normal => ("normal", "Unit normal: x, y, z as red, green, blue"),
            Show::Id => ("id", "Object id, one colour each"),
            Show::Discriminant => (
                "discriminant",
                "Discriminant of the visible sphere, or of the one nearest to the line. It counts \
                 points of the line: the ray, t > 0, may have fewer",
            ),
            Show::Error => ("error", "Error of the kernel, against exact arithmetic"),
            Show::Stage => ("stage", "Arithmetic that decided the pixel: f32, f64 or exact"),
        }
    }

    /// As menus and the command line have it.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// One sentence.
    pub fn explanation(self) -> &'static str {
        self.words().1
    }

    /// The next one, or the one before.
    pub fn step(self, forward: bool) -> Show {
        let n = Show::ALL.len();
        let at = Show::ALL.iter().position(|&show| show == self).unwrap_or(0);
        Show::ALL[(at + if forward { 1 } else { n - 1 }) % n]
    }

    /// The part of [`Hits`](kugelblitz::query::Hits) that it looks at.
    pub fn wants(self) -> Outputs {
        let surface = matches!(self, Show::Depth | Show::Normal | Show::Error);
        Outputs { surface, level: self == Show::Stage }
    }

    /// Whether all pixels that see one object have one colour.
    pub fn is_of_objects(self) -> bool {
        matches!(self, Show::Color | Show::Id)
    }

    /// Refuses formats and options that its colours have no use for.
    ///
    /// # Errors
    /// [`Error::Usage`](kugelblitz::Error::Usage)
    pub fn check(self, format: Format, options: PictureOptions) -> Result<()> {
        let refuse = |why: &str, hint: Hint| {
            wrong_usage(Message::new(format!("a picture of {self} {why}"), hint))
        };
        match options {
            _ if self == Show::Color => Ok(()),
            _ if format.holds_numbers() => {
                let hint = Hint::new(
                    "write .png or .ppm; .exr and .npy have the numbers themselves without {}",
                    [Setting::named("show")],
                );
                refuse("is for the eye", hint)
            }
            PictureOptions { bits: ChannelBits::Sixteen, .. } => {
                refuse("has 8 bits a channel", Hint::new("remove {}", [Setting::named("bits")]))
            }
            PictureOptions { transparent: true, .. } => refuse(
                "has a colour for the background",
                Hint::new("remove {}", [Setting::named("transparent")]),
            ),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Show {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
