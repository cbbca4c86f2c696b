//! What can go wrong, in the words that the user reads.

use crate::plain::Shown;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every failure of the library. [`Error::exit_code`] is the program's exit code for it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene file, or a file that it names, is wrong.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// An argument can't be used as given.
    #[error("{0}")]
    Usage(String),
    /// An input file is not what it should be.
    #[error("{path}: {message}", path = path.shown())]
    Input {
        /// The file.
        path: PathBuf,
        /// What was found and what was expected.
        message: String,
    },
    /// Reading or writing failed.
    #[error("{path}: {source}", path = path.shown())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// No adapter fits the request, or there is no display for a window.
    #[error("{0}")]
    NoAdapter(String),
    /// The device was lost, failed, or did not finish in time.
    #[error("{0}")]
    Device(String),
    /// A shader part was refused; names the `.wgsl` file and line.
    #[error("{0}")]
    Shader(String),
    /// Two results that must agree do not.
    #[error("{0}")]
    Comparison(String),
    /// Does not fit the device's limits or this machine's memory.
    #[error("{0}")]
    TooLarge(String),
    /// This processor does not calculate as the proofs ask for.
    #[error("{0}")]
    Host(String),
    /// The user interrupted the work.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// The exit code that the contract gives this failure.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Input { .. } | Error::Io { .. } | Error::Shader(_) | Error::Host(_) => 1,
            Error::Usage(_) => 2,
            Error::Scene(_) => 3,
            Error::NoAdapter(_) => 4,
            Error::Device(_) => 5,
            Error::Comparison(_) => 6,
            Error::TooLarge(_) => 7,
            Error::Interrupted => 130,
        }
    }

    /// An [`Error::Io`] for `path`, to be used with `map_err`.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::Io { path, source }
    }
}

/// Refuses an argument that can't be used as given.
///
/// # Errors
/// [`Error::Usage`]
pub fn wrong_usage<T>(message: impl Into<String>) -> Result<T> {
    Err(Error::Usage(message.into()))
}

/// A fault of a scene file, and its place.
#[derive(Debug)]
pub struct SceneError {
    /// The file.
    pub path: PathBuf,
    /// The whole text of the file; empty where the error is about the file as a whole. Bytes that
    /// are not UTF-8 stand in it as U+FFFD.
    pub text: String,
    /// Bytes of `text` that the error is about; both ends are character boundaries of `text`.
    pub span: Range<usize>,
    /// Line of the span's start, from 1; 0 where the error is about the file as a whole.
    pub line: usize,
    /// Column of the span's start, characters, from 1; 0 where the error is about the file as a
    /// whole.
    pub column: usize,
    /// What was found.
    pub message: String,
    /// What was expected, the nearest known key, or the next step.
    pub help: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.path.shown())?;
        if self.line > 0 {
            write!(f, "{}:{}:", self.line, self.column)?;
        }
        write!(f, " {}", self.message)
    }
}

impl std::error::Error for SceneError {}
