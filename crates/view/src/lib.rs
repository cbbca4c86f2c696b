//! The window: a scene to move through, and a pixel to be asked why.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `app` | what comes in and what goes out |
//! | `state` | what is wanted, what is there, what the user is told |
//! | `turns` | the input of a long frame, in turns |
//! | `controls` | mouse and keys → camera and state |
//! | `rig` | the camera under the hand: pure arithmetic |
//! | `panels` | lines, legend, help; `bar` and `explanation` beside them |
//! | `overlay` | marks of pixels; pivot and axes while the camera moves |
//! | `present` | pictures → pixels of the window |
//! | `worker` | a thread that does the newest of its jobs |
//! | `picture`, `ask`, `save` | such jobs, each with a [`Session`](kugelblitz::Session) |
//! | `reload` | watching the scene file |
//! | `notice` | what the program is told |
//!
//! The event loop never waits for tracing. Every picture comes from a `Session` on a thread of its own: first the colours
//! of the ids, at each movement, and when the camera rests what takes longer, light, samples and numbers, as `render`
//! draws them.

mod app;
mod ask;
mod bar;
mod controls;
mod explanation;
mod notice;
mod overlay;
mod panels;
mod picture;
mod present;
mod reload;
mod rig;
mod save;
mod state;
mod turns;
mod worker;

pub use app::{Options, Reread, run};
pub use notice::Notice;
