//! Errors, with the next step as data that each front end words for itself.

use crate::plain::Shown;
use crate::words::cut;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every failure of the library. [`Error::exit_code`] is the program's exit code for it.
///
/// `Display` writes the problem. The next step, if there is one, is [`Error::hint`].
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene file, or a data file, is invalid.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// An argument cannot be used as given.
    #[error("{0}")]
    Usage(Message),
    /// An input file has unexpected content.
    #[error("{path}: {message}", path = path.shown())]
    Input {
        /// The file.
        path: PathBuf,
        /// Expected and found content.
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
    NoAdapter(Message),
    /// The device was lost, failed, or did not finish in time.
    #[error("{0}")]
    Device(Message),
    /// A shader part was refused; names the `.wgsl` file and line.
    #[error("{0}")]
    Shader(String),
    /// Two results that must agree do not.
    #[error("{0}")]
    Comparison(String),
    /// Does not fit the device's limits or this machine's memory.
    #[error("{0}")]
    TooLarge(Message),
    /// This processor does not compute as the proofs require.
    #[error("{0}")]
    Host(String),
    /// The user interrupted the work.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Returns the exit code that the contract gives this failure.
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

    /// Returns the next step; it is empty if the problem already contains it.
    pub fn hint(&self) -> &Hint {
        match self {
            Error::Scene(error) => &error.hint,
            Error::Usage(message)
            | Error::NoAdapter(message)
            | Error::Device(message)
            | Error::TooLarge(message) => &message.hint,
            _ => const { &Hint::NONE },
        }
    }

    /// Returns an [`Error::Io`] for `path`, to be used with `map_err`.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::Io { path, source }
    }
}

/// Refuses an argument that cannot be used as given.
///
/// # Errors
/// [`Error::Usage`]
pub fn wrong_usage<T>(message: impl Into<Message>) -> Result<T> {
    Err(Error::Usage(message.into()))
}

/// A sentence, and the next step.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The problem or the fact.
    pub text: String,
    /// The next step; may be empty.
    pub hint: Hint,
}

impl Message {
    /// Creates a message with a next step.
    pub fn new(text: impl Into<String>, hint: impl Into<Hint>) -> Message {
        Message { text: text.into(), hint: hint.into() }
    }

    /// Returns both in one line, with each setting as `word` writes it.
    pub fn worded(&self, word: impl Fn(&Setting) -> String) -> String {
        match self.hint.is_empty() {
            true => self.text.clone(),
            false => format!("{}; {}", self.text, self.hint.worded(word)),
        }
    }
}

impl<T: Into<String>> From<T> for Message {
    fn from(text: T) -> Message {
        Message { text: text.into(), hint: Hint::NONE }
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The next step after an error or a note: text with settings in it.
///
/// A setting is data, because each front end writes it differently: an option on the command line, a key in a scene file, an
/// argument in Python. `Display` writes keys of a scene file.
///
/// ```
/// use kugelblitz::error::{Hint, Setting};
///
/// let hint = Hint::new("give {} for the last frame", [Setting::number("frame", -1.0)]);
/// assert_eq!(hint.to_string(), "give `frame = -1` for the last frame");
/// assert_eq!(hint.worded(|setting| format!("--{}", setting.key)), "give --frame for the last frame");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hint(Vec<HintPart>);

/// A part of a [`Hint`].
#[derive(Clone, Debug, PartialEq)]
pub enum HintPart {
    /// Text that is the same in all front ends.
    Text(String),
    /// A setting.
    Setting(Setting),
}

impl From<Setting> for HintPart {
    fn from(setting: Setting) -> HintPart {
        HintPart::Setting(setting)
    }
}

impl<T: Into<String>> From<T> for Hint {
    fn from(text: T) -> Hint {
        let text = text.into();
        if text.is_empty() { Hint::NONE } else { Hint(vec![HintPart::Text(text)]) }
    }
}

impl Hint {
    /// No next step.
    pub const NONE: Hint = Hint(Vec::new());

    /// Creates a hint from a text with a `{}` for each setting, in their order.
    pub fn new<const N: usize>(template: &str, settings: [Setting; N]) -> Hint {
        let mut settings = settings.into_iter();
        let mut parts = Vec::new();
        for text in template.split("{}") {
            parts.extend((!text.is_empty()).then(|| HintPart::Text(text.into())));
            parts.extend(settings.next().map(HintPart::Setting));
        }
        Hint(parts)
    }

    /// Returns the hint with text before it.
    pub fn after(mut self, text: impl Into<String>) -> Hint {
        self.0.insert(0, HintPart::Text(text.into()));
        self
    }

    /// Returns the hint with another one after it.
    pub fn then(mut self, other: impl Into<Hint>) -> Hint {
        self.0.extend(other.into().0);
        self
    }

    /// Whether there is no next step.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the text, with each setting as `word` writes it.
    pub fn worded(&self, word: impl Fn(&Setting) -> String) -> String {
        let part = |part: &HintPart| match part {
            HintPart::Text(text) => text.clone(),
            HintPart::Setting(setting) => word(setting),
        };
        self.0.iter().map(part).collect()
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.worded(Setting::to_string))
    }
}

/// A setting that a user can make: a key of a scene file, an option on the command line, an argument in Python.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name, as scene files have it: `color_by`.
    pub key: &'static str,
    /// Value; `None` names the setting alone.
    pub value: Option<SettingValue>,
}

/// The value of a [`Setting`].
#[derive(Clone, Debug, PartialEq)]
pub enum SettingValue {
    /// A text or a name.
    Text(String),
    /// Digits of a number.
    Number(String),
    /// `true`: an option without a value.
    Present,
    /// `false`: there is none.
    Absent,
    /// Values by name.
    Table(Vec<(&'static str, SettingValue)>),
}

impl Setting {
    /// Names a setting without a value.
    pub fn named(key: &'static str) -> Setting {
        Setting { key, value: None }
    }

    /// Returns a setting with a text or a name.
    pub fn text(key: &'static str, value: impl Into<String>) -> Setting {
        Setting { key, value: Some(SettingValue::Text(value.into())) }
    }

    /// Returns a setting with a number.
    pub fn number(key: &'static str, value: f64) -> Setting {
        Setting { key, value: Some(SettingValue::Number(value.to_string())) }
    }

    /// Returns a setting that is switched on.
    pub fn on(key: &'static str) -> Setting {
        Setting { key, value: Some(SettingValue::Present) }
    }

    /// Returns the setting `columns` with one entry.
    pub fn column(part: &'static str, value: SettingValue) -> Setting {
        Setting { key: "columns", value: Some(SettingValue::Table(vec![(part, value)])) }
    }

    /// Returns the setting for the column with this name in the file.
    pub fn column_named(part: &'static str, name: impl Into<String>) -> Setting {
        Setting::column(part, SettingValue::Text(name.into()))
    }

    /// Returns the setting for a part without a column.
    pub fn no_column(part: &'static str) -> Setting {
        Setting::column(part, SettingValue::Absent)
    }
}

/// Writes a key of a scene file, in backquotes.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            None => write!(f, "`{}`", self.key),
            Some(value) => write!(f, "`{} = {value}`", self.key),
        }
    }
}

/// Writes TOML.
impl fmt::Display for SettingValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SettingValue::Text(text) => write!(f, "\"{}\"", text.shown()),
            SettingValue::Number(number) => f.write_str(number),
            SettingValue::Present => f.write_str("true"),
            SettingValue::Absent => f.write_str("false"),
            SettingValue::Table(entries) => {
                let entries: Vec<_> =
                    entries.iter().map(|(name, value)| format!("{name} = {value}")).collect();
                write!(f, "{{ {} }}", entries.join(", "))
            }
        }
    }
}

/// Longest path in a message, characters.
const MAX_PATH: usize = 300;

/// Place in data, or key, that an error of the reader is about, with its known parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorSubject {
    /// Data file; `None` for the scene file itself.
    pub file: Option<PathBuf>,
    /// Line of a text file, from 1.
    pub line: Option<u64>,
    /// Row of an array, from 0.
    pub row: Option<u64>,
    /// Column, as the file names it.
    pub column: Option<String>,
    /// Key of the scene file, or argument.
    pub key: Option<&'static str>,
}

impl fmt::Display for ErrorSubject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ErrorSubject { file, line, row, column, .. } = self;
        let parts = [
            file.as_ref().map(|file| cut(&file.shown(), MAX_PATH).into_owned()),
            line.map(|line| format!("line {line}")),
            row.map(|row| format!("row {row} (counted from 0)")),
            column.as_ref().map(|column| format!("column \"{}\"", column.shown())),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        f.write_str(&parts.join(": "))
    }
}

/// An error in a scene file or in data: its place, the value found there, the problem and the next step.
#[derive(Debug)]
pub struct SceneError {
    /// Scene file; for data that are drawn without one, the data file.
    pub path: PathBuf,
    /// Whole text of the scene file; empty if the error is about the file as a whole. Bytes that are not UTF-8 are
    /// replaced by U+FFFD.
    pub text: String,
    /// Range of bytes of `text` that the error is about; both ends are character boundaries of `text`.
    pub span: Range<usize>,
    /// Line of the span's start, from 1; 0 if the error is about the file as a whole.
    pub line: usize,
    /// Column of the span's start, characters, from 1; 0 if the error is about the file as a whole.
    pub column: usize,
    /// The data file, line, column and key.
    pub subject: ErrorSubject,
    /// Offending value, as it was read.
    pub value: Option<String>,
    /// The problem, without its place.
    pub message: String,
    /// The next step.
    pub hint: Hint,
}

impl SceneError {
    /// Whether the error is about data that are drawn without a scene file, so that options and arguments, not keys, are the
    /// next step.
    pub fn is_about_bare_data(&self) -> bool {
        self.subject.file.as_ref() == Some(&self.path)
    }

    /// Returns the error for this line of the data file, from 1.
    pub fn at_line(mut self: Box<Self>, line: u64) -> Box<SceneError> {
        self.subject.line = Some(line);
        self
    }

    /// Returns the error for this row of the array, from 0.
    pub fn at_row(mut self: Box<Self>, row: u64) -> Box<SceneError> {
        self.subject.row = Some(row);
        self
    }

    /// Returns the error for this column of the data file.
    pub fn in_column(mut self: Box<Self>, name: impl Into<String>) -> Box<SceneError> {
        self.subject.column = Some(name.into());
        self
    }

    /// Returns the error with the value that was found.
    pub fn with_value(mut self: Box<Self>, value: impl Into<String>) -> Box<SceneError> {
        self.value = Some(value.into());
        self
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.is_about_bare_data() {
            write!(f, "{}:", self.path.shown())?;
            if self.line > 0 {
                write!(f, "{}:{}:", self.line, self.column)?;
            }
            f.write_str(" ")?;
        }
        let subject = self.subject.to_string();
        if !subject.is_empty() {
            write!(f, "{subject}: ")?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for SceneError {}
