//! The quantities that a picture can show of each pixel.

/// The ways of looking at a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Show {
    /// The objects' colours: what `render` draws.
    #[default]
    Color,
    /// `t`, which is the depth along the view axis.
    Depth,
    /// The unit normal.
    Normal,
    /// A colour for each id.
    Id,
    /// Front or back.
    Side,
    /// The sign of the discriminant: the lecture's figure 5.
    Discriminant,
    /// The kernel's result against exact arithmetic.
    Error,
    /// The stage that decided.
    Stage,
}

impl Show {
    /// In the order of the keys F1 to F8.
    pub const ALL: [Show; 8] = [
        Show::Color,
        Show::Depth,
        Show::Normal,
        Show::Id,
        Show::Side,
        Show::Discriminant,
        Show::Error,
        Show::Stage,
    ];

    /// The menu's word and one sentence.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Show::Color => ("colour", "What the command render draws, with light and samples"),
            Show::Depth => ("depth", "t, the depth along the view axis, on a logarithmic scale"),
            Show::Normal => ("normal", "The unit normal: x, y, z as red, green, blue"),
            Show::Id => ("id", "A colour for each object id"),
            Show::Side => ("side", "The side of the object that is seen"),
            Show::Discriminant => (
                "discriminant",
                "D of the visible sphere, else of the one that the line comes nearest to",
            ),
            Show::Error => ("error", "The kernel against exact arithmetic, pixel by pixel"),
            Show::Stage => ("stage", "The stage that decided which object is seen"),
        }
    }

    /// As the menu has it.
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
}

/// How a picture is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// The quantity.
    pub show: Show,
    /// Colours are those that the scene's light gives.
    pub is_lit: bool,
    /// Samples across and down a pixel.
    pub n_samples: u32,
}

impl Look {
    /// True where single pixels must be painted, which happens when the camera rests.
    pub fn is_painted(self) -> bool {
        match self.show {
            Show::Color => self.is_lit || self.n_samples > 1,
            Show::Id | Show::Side => false,
            Show::Depth | Show::Normal | Show::Discriminant | Show::Error | Show::Stage => true,
        }
    }
}
