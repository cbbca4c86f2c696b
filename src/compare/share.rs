//! How much may differ.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};

/// How many of some things may be wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Share {
    /// So many.
    Count(u64),
    /// So many of each one.
    Part(f64),
}

impl Share {
    /// Whether `wrong` of `all` are too many.
    pub fn is_exceeded(self, wrong: u64, all: u64) -> bool {
        match self {
            Share::Count(most) => wrong > most,
            Share::Part(most) => wrong as f64 > most * all as f64,
        }
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Share::Count(most) => write!(f, "{most}"),
            Share::Part(1.0) => f.write_str("any"),
            Share::Part(most) => write!(f, "{}%", most * 100.0),
        }
    }
}

impl FromStr for Share {
    type Err = Error;

    /// Reads `3`, `0.01%`, or `any`.
    fn from_str(text: &str) -> Result<Share> {
        if text == "any" {
            return Ok(Share::Part(1.0));
        }
        let share = match text.strip_suffix('%') {
            Some(percent) => percent.trim().parse().ok().map(|p: f64| Share::Part(p / 100.0)),
            None => text.parse().ok().map(Share::Count),
        };
        let is_share = |share: &Share| match share {
            Share::Count(_) => true,
            Share::Part(part) => (0.0..=1.0).contains(part),
        };
        share.filter(is_share).ok_or_else(|| {
            Error::Usage(format!("“{text}” is no share; give a number of pixels, 0.01%, or any"))
        })
    }
}
