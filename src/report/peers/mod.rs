//! Other renderers on the same scene, where they are installed: POV-Ray and Tachyon.
//!
//! Each gets the scene as [`export`] writes it, in colours that name the objects, so that
//! its picture says which object it sees in each pixel.

mod codes;
mod plain;
mod process;
mod talk;

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::camera::View;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::export::{self, Language};
use crate::scene::Scene;

use super::Spread;

pub use codes::{MAX_OBJECTS, NO_OBJECT};
use process::{Ended, Failure};

/// A renderer of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Peer {
    /// POV-Ray 3.7, the Persistence of Vision Raytracer. It calculates in f64, but the boxes by
    /// which it passes over objects are in f32; it has them where there are more than a few objects.
    PovRay,
    /// Tachyon 0.99. It calculates in f64, but reads the numbers of a scene as f32.
    Tachyon,
}

impl Peer {
    /// All of them.
    pub const ALL: [Peer; 2] = [Peer::PovRay, Peer::Tachyon];

    /// Its name.
    pub fn name(self) -> &'static str {
        self.language().renderer()
    }

    /// Its program, which is also its package in Debian.
    pub fn package(self) -> &'static str {
        match self {
            Peer::PovRay => "povray",
            Peer::Tachyon => "tachyon",
        }
    }

    fn language(self) -> Language {
        match self {
            Peer::PovRay => Language::Pov,
            Peer::Tachyon => Language::Tachyon,
        }
    }

    /// What makes it draw the scene as exactly as it can: one ray a pixel, no window, and whatever
    /// the user's own settings may change set to what it is without them.
    fn arguments(self, [width, height]: [u32; 2], n_threads: usize) -> Vec<String> {
        let text = match self {
            Peer::PovRay => format!(
                "Input_File_Name={SCENE} Output_File_Name={PICTURE} Output_File_Type=N8 \
                 Width={width} Height={height} Work_Threads={n_threads} Antialias=off Display=off \
                 Pause_When_Done=off Output_Alpha=off Dither=off Grayscale_Output=off \
                 File_Gamma=sRGB Quality=9"
            ),
            Peer::Tachyon => {
                format!("{SCENE} -numthreads {n_threads} -format PNG -o {PICTURE}")
            }
        };
        text.split(' ').map(str::to_owned).collect()
    }
}

/// The files of a run, in a folder of its own.
const SCENE: &str = "scene";
const PICTURE: &str = "picture.png";
const TALK: &str = "talk.txt";

/// Where this environment variable is set, POV-Ray takes further settings from the file it names.
const POV_SETTINGS: &str = "POVINI";

/// Why there is no result of a peer.
#[derive(Debug, thiserror::Error)]
pub enum Missing {
    /// It is not there, or it did not do what it should: a reason and a next step for the reader.
    #[error("{0}")]
    Because(String),
    /// The work was stopped, or this machine failed; nothing that the peer can help.
    #[error(transparent)]
    Stopped(#[from] Error),
}

impl Missing {
    fn because(reason: impl Into<String>) -> Missing {
        Missing::Because(reason.into())
    }
}

/// How often and how long a peer may run.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Times that it draws the picture; at least one.
    pub n_runs: usize,
    /// Threads that it is given.
    pub n_threads: usize,
    /// Time after which one run is ended.
    pub limit: Duration,
}

impl Default for Effort {
    /// Five runs on all threads of the machine, each of at most two minutes.
    fn default() -> Effort {
        let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
        Effort { n_runs: 5, n_threads, limit: Duration::from_secs(120) }
    }
}

/// What a peer made of a scene.
#[derive(Clone, Debug)]
pub struct PeerRun {
    /// Its name.
    pub peer: &'static str,
    /// The version that it says it has.
    pub version: Option<String>,
    /// Threads that it was given.
    pub n_threads: usize,
    /// Wall time of the whole process: start, reading the scene, tracing, writing the picture.
    pub wall_ms: Spread,
    /// Time of tracing as it reports it itself; `None` where a run did not. POV-Ray rounds it to
    /// whole milliseconds, Tachyon to tenths.
    pub trace_ms: Option<Spread>,
    /// What it sees in each pixel of the last run, row by row; [`NO_OBJECT`] where the colour is
    /// that of no object.
    pub ids: Vec<u32>,
}

/// A peer that is installed and draws a plain scene as it should.
#[derive(Clone, Debug)]
pub struct Program {
    peer: Peer,
    path: PathBuf,
}

impl Program {
    /// Looks for the peer's program where the system looks for programs, and has it draw a plain
    /// scene, since versions differ in where they think the centre of a pixel is.
    ///
    /// # Errors
    /// [`Missing::Because`] of what must be installed, or of what it does wrong.
    pub fn open(peer: Peer, effort: &Effort, control: &Control) -> Result<Program, Missing> {
        Program::open_at(peer, peer.package(), effort, control)
    }

    /// As [`Program::open`], with the program at `path`.
    ///
    /// # Errors
    /// As [`Program::open`].
    pub fn open_at(
        peer: Peer,
        path: impl Into<PathBuf>,
        effort: &Effort,
        control: &Control,
    ) -> Result<Program, Missing> {
        let program = Program { peer, path: path.into() };
        let (scene, view) = (plain::scene(), plain::view());
        let once = Effort { n_runs: 1, ..*effort };
        let run = program.run(&scene, &view, plain::SIZE, &once, control)?;
        let n_wrong = plain::wrong_pixels(&run.ids, control)?;
        if n_wrong > plain::MAX_WRONG {
            return Err(Missing::because(format!(
                "{n_wrong} of {} pixels of a plain scene are wrong: its version ({}) draws other \
                 pictures than the ones that the export was made for",
                run.ids.len(),
                run.version.as_deref().unwrap_or("unknown"),
            )));
        }
        Ok(program)
    }

    /// Draws what `view` sees of `scene` in a picture of `size` pixels, width and height.
    ///
    /// # Errors
    /// [`Missing::Because`] when it gave no picture in time, [`Missing::Stopped`] with
    /// [`Error::Interrupted`] when `control` was cancelled. In both cases it runs no longer.
    pub fn run(
        &self,
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        effort: &Effort,
        control: &Control,
    ) -> Result<PeerRun, Missing> {
        if scene.n_objects() > MAX_OBJECTS {
            return Err(Missing::because(format!(
                "the scene has {} objects, but only {MAX_OBJECTS} can have a colour of their own",
                scene.n_objects()
            )));
        }
        // Named is the folder that TMPDIR says, not what would have been in it.
        let folder = tempfile::tempdir().map_err(|error| Error::Io {
            path: std::env::temp_dir(),
            source: std::io::Error::other(format!(
                "no temporary folder can be made here: {}; set TMPDIR to another one",
                error.kind()
            )),
        })?;
        self.write_scene(folder.path(), scene, view, size)?;
        let (mut wall_ms, mut trace_ms) = (Vec::new(), Vec::new());
        let (mut version, mut ids) = (None, Vec::new());
        for _ in 0..effort.n_runs.max(1) {
            let Ended { wall, talk } = self.draw(folder.path(), size, effort, control)?;
            wall_ms.push(wall.as_micros() as f64 / 1e3);
            trace_ms.extend(talk::trace_ms(self.peer, &talk));
            version = talk::version(&talk);
            ids = self.take_picture(folder.path(), size, scene.n_objects())?;
        }
        let all_traces = trace_ms.len() == wall_ms.len();
        let wall_ms = Spread::of(wall_ms).ok_or_else(|| Missing::because("it was not run"))?;
        Ok(PeerRun {
            peer: self.peer.name(),
            version,
            n_threads: effort.n_threads,
            wall_ms,
            trace_ms: Spread::of(trace_ms).filter(|_| all_traces),
            ids,
        })
    }

    fn write_scene(&self, folder: &Path, scene: &Scene, view: &View, size: [u32; 2]) -> Result<()> {
        let path = folder.join(SCENE);
        let write = || {
            let mut file = BufWriter::new(File::create(&path)?);
            let language = self.peer.language();
            export::write(language, scene, view, size, codes::color, &mut file)?;
            file.flush()
        };
        write().map_err(Error::io(&path))
    }

    fn draw(
        &self,
        folder: &Path,
        size: [u32; 2],
        effort: &Effort,
        control: &Control,
    ) -> Result<Ended, Missing> {
        let mut command = Command::new(&self.path);
        command
            .args(self.peer.arguments(size, effort.n_threads))
            .current_dir(folder)
            .env_remove(POV_SETTINGS);
        process::run(command, &folder.join(TALK), effort.limit, control).map_err(|failure| {
            let name = self.path.display();
            match failure {
                Failure::NotFound => Missing::because(format!(
                    "not installed: install the package {}",
                    self.peer.package()
                )),
                Failure::Start(error) => Missing::because(format!("{name}: {error}")),
                Failure::TooSlow => Missing::because(format!(
                    "{name} was ended after {} s without a picture",
                    effort.limit.as_secs_f64()
                )),
                Failure::Status(status, talk) => {
                    Missing::because(format!("{name}: {status}: {}", talk::last_words(&talk)))
                }
                Failure::Stopped(error) => Missing::Stopped(error),
            }
        })
    }

    /// The ids of the picture, which is removed: the next run must make its own.
    fn take_picture(
        &self,
        folder: &Path,
        size: [u32; 2],
        n_objects: usize,
    ) -> Result<Vec<u32>, Missing> {
        let path = folder.join(PICTURE);
        let wrong = |what: String| Missing::because(format!("its picture can't be used: {what}"));
        let bytes = fs::read(&path).map_err(|error| wrong(error.to_string()))?;
        fs::remove_file(&path).map_err(Error::io(&path))?;
        codes::ids(&bytes, size, n_objects).map_err(wrong)
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests;
