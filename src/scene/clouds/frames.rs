//! Which of several steps of a simulation in one file is read.

use super::Reading;
use crate::plain::Shown;
use crate::scene::places::{Fault, Stop};

impl Reading<'_> {
    /// The frame that the scene asks for, the first one by itself.
    pub(super) fn frame(&self) -> u32 {
        self.source.table.frame.as_ref().map_or(0, |frame| frame.value)
    }

    /// The error where the file has no more frames than `n_frames`.
    pub(super) fn no_such_frame(&self, n_frames: u32) -> Stop {
        let span = match &self.source.table.frame {
            Some(frame) => frame.span.clone(),
            None => self.source.table.file.span.clone(),
        };
        let frames = if n_frames == 1 { "1 frame".into() } else { format!("{n_frames} frames") };
        let path = self.source.path.shown();
        Fault::new(
            span,
            format!("{path}: the file has {frames}, so no frame {}", self.frame()),
            format!("frames are counted from 0: the last one is {}", n_frames.saturating_sub(1)),
        )
        .into()
    }

    /// Refuses `frame` of a file that has none.
    pub(super) fn refuse_frame(&self) -> Result<(), Stop> {
        match &self.source.table.frame {
            None => Ok(()),
            Some(frame) => Err(Fault::new(
                frame.span.clone(),
                format!("`frame` is given, but {} has no frames", self.source.path.shown()),
                "remove `frame`; it is for .xyz files and LAMMPS dumps of several steps",
            )
            .into()),
        }
    }
}
