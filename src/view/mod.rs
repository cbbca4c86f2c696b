//! The window: a scene to move through, and a pixel to be asked why.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `app` | the event loop: what comes in, in which order it is done; `frame`, what goes out |
//! | `state` | what is wanted, what is there, what the user is told |
//! | `controls` | mouse and keys → camera and state |
//! | `rig` | the camera under the hand: pure arithmetic |
//! | `history` | where the camera was |
//! | `panels` | lines, legend, help; `bar` and `explanation` beside them |
//! | `overlay`, `guides` | marks of pixels; pivot and axes while the camera moves |
//! | `screen` | surface and drawing |
//! | `worker` | a thread that does the newest of its jobs |
//! | `tracing`, `painter`, `ask`, `save` | such jobs |
//! | `look` | how a picture is looked at; the colours are those of [`crate::show`] |
//! | `reload`, `recent` | watching the scene file, and the files of before |
//! | `display` | the display that isn't there |
//! | `notice` | what the program is told |
//!
//! The event loop never waits for tracing. A picture's ids stay on the device, where one draw
//! turns them into colours. What the certified kernel left undecided goes to the CPU as a list of
//! pixels, and their ids come back; until then they are grey. Light and samples are those that `render`
//! draws, all other numbers those that it writes to an EXR file, computed when the camera rests.

mod app;
mod ask;
mod bar;
mod controls;
mod display;
mod explanation;
mod guides;
mod history;
mod look;
mod notice;
mod overlay;
mod painter;
mod panels;
mod recent;
mod reload;
mod rig;
mod save;
mod screen;
mod state;
mod tracing;
mod worker;

pub use app::{Options, Reread, run};
pub use notice::Notice;
