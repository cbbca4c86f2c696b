//! `kugelblitz render` of several frames.

use std::fs;
use std::path::Path;
use std::time::Instant;

use clap::{Args, value_parser};
use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::frames::{MAX_FRAMES, check_reach, file_of_frame, pattern_of_files, turntable};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::Format;
use kugelblitz::plain::Shown;
use kugelblitz::query::Rays;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::words::{count, duration};
use kugelblitz_judge::cost::ObjectCounts;
use serde::Serialize;

use crate::args::RenderArgs;
use crate::head::{Done, Drawn, Millis, WorkSummary};
use crate::output::{is_stdout, shell_quoted};
use crate::progress::Progress;
use crate::render::{Begun, size};
use crate::{Run, wrong_usage};

/// Frames of a film instead of one picture.
#[derive(Args)]
#[command(next_help_heading = "Film (OUT-0001.png, OUT-0002.png, …)")]
pub struct FilmArgs {
    /// N frames, once around the point the camera looks at
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    pub turntable: Option<u32>,
    /// Only these frames, from 1: 10-20, 10-, or 10
    #[arg(long, value_name = "A-B", value_parser = parse_frames, requires = "turntable", hide_short_help = true)]
    pub frames: Option<[u32; 2]>,
    /// Skip frames whose file exists, whatever it shows
    #[arg(long, requires = "turntable", hide_short_help = true)]
    pub resume: bool,
}

impl FilmArgs {
    /// True where they ask for a film.
    pub fn is_film(&self) -> bool {
        self.turntable.is_some()
    }

    /// Pictures around the scene, all of which are to see everything.
    pub fn n_turns(&self) -> u32 {
        self.turntable.unwrap_or(0)
    }
}

/// Reads `A-B`, `A-` or `A`.
fn parse_frames(text: &str) -> Result<[u32; 2], String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let last = if last.trim().is_empty() { Some(u32::MAX) } else { last.trim().parse().ok() };
    match (first.trim().parse().ok(), last) {
        (Some(first), Some(last)) if 1 <= first && first <= last => Ok([first, last]),
        _ => Err("give the first and the last frame, counted from 1, e.g. 10-20".into()),
    }
}

/// `render` with `--turntable`.
#[derive(Serialize)]
pub struct FilmSummary {
    #[serde(flatten)]
    work: WorkSummary,
    /// Number of frames of the whole film.
    n_frames: u32,
    /// Frames of this run.
    frames: Vec<FilmFrame>,
    /// Memory on the device, bytes.
    bytes_device: u64,
    /// Times of the whole run, milliseconds.
    ms: FilmTimes,
    /// Command that makes a film of all frames; absent if ffmpeg cannot read their format.
    #[serde(skip_serializing_if = "Option::is_none")]
    ffmpeg: Option<String>,
}

/// Times of a film, milliseconds.
#[derive(Serialize)]
struct FilmTimes {
    /// Reading the input.
    read: Millis,
    /// Total time since the start of the program.
    total: Millis,
}

/// A frame of a film.
#[derive(Serialize)]
struct FilmFrame {
    /// Number of the frame, from 1.
    frame: u32,
    /// Path of the picture.
    file: String,
    /// Whether `--resume` found the file and skipped the frame.
    skipped: bool,
    #[serde(flatten)]
    drawn: Option<Drawn>,
}

/// Renders the frames one after the other: the scene is read, and its tree built, once for all.
pub fn run(args: &RenderArgs, output: &Path, begun: Begun, run: &Run) -> Result<Done<FilmSummary>> {
    if is_stdout(output) {
        return wrong_usage(
            "a film is several files, and can't go to standard output; name them with -o, e.g. \
             -o out.png for out-0001.png and so on",
        );
    }
    let camera = begun.scene.require_camera(&args.scene)?;
    let n_frames = args.film.n_turns();
    let cameras = turntable(camera, n_frames);
    check_reach(&cameras, &begun.scene)?;
    let [first, last] = args.film.frames.unwrap_or([1, n_frames]);
    if first > n_frames {
        return wrong_usage(format!(
            "--frames {first}…: the film has {}",
            count(cameras.len(), "frame")
        ));
    }
    let path_of = |frame: u32| file_of_frame(output, frame, n_frames);
    let mut frames: Vec<FilmFrame> = Vec::new();
    for frame in first..=last.min(n_frames) {
        let path = path_of(frame);
        begun.refuse_overwriting(args, &path)?;
        let skipped = args.film.resume && fs::metadata(&path).is_ok_and(|found| found.is_file());
        frames.push(FilmFrame { frame, file: path.display().to_string(), skipped, drawn: None });
    }
    let n_skipped = frames.iter().filter(|frame| frame.skipped).count();
    let n_left = frames.len() - n_skipped;
    // So that a folder that isn't there is told before the work and not after it.
    let created = |frame| OutputFile::create(path_of(frame), begun.format.needs_seek());
    if let Some(first) = frames.iter().find(|frame| !frame.skipped) {
        drop(created(first.frame)?);
    }

    let mut session = begun.session(args, run)?;
    let plan = begun.plan()?;
    let progress = Progress::of_frames(run, begun.n_steps, n_left as u64);
    let is_lit = begun.scene.is_lit();
    let draw = |frame: &mut FilmFrame| -> Result<()> {
        let (start, camera) = (Instant::now(), &cameras[frame.frame as usize - 1]);
        session.set_camera(camera.clone());
        let pixels = Pixels { view: View::new(camera), ..begun.pixels };
        let file = created(frame.frame)?;
        let making = session.make_ready(&Rays::Pixels(pixels), plan.wants, &run.control)?;
        let (rendered, file) = session.draw(&pixels, &plan, file, &run.control)?;
        run.control.check()?;
        // For each its own: what is put in its place is whole, and the next can still be stopped.
        output::commit([file], &Control::default())?;
        frame.drawn = Some(Drawn::new(&rendered, making, None, start.elapsed(), is_lit));
        Ok(())
    };
    let done = frames.iter_mut().filter(|frame| !frame.skipped).try_for_each(draw);
    drop(progress);
    let n_done = frames.iter().filter(|frame| frame.drawn.is_some()).count();
    if done.is_err() && n_done > 0 {
        let all = count(n_left, "frame");
        run.say(&format!("{n_done} of {all} are whole; --resume goes on with the others"));
    }
    done?;
    let shape = [begun.pixels.width, begun.pixels.height];
    let ffmpeg = ffmpeg(output, n_frames, begun.format, shape);
    let ends = frames.first().into_iter().chain(frames.last());
    let mut files: Vec<String> = ends.map(|frame| frame.file.shown()).collect();
    files.dedup();
    let skipped = match n_skipped {
        0 => String::new(),
        n => format!(", {n} of them there already"),
    };
    let total = run.start.elapsed();
    let line = format!(
        "{}: {} of {}{skipped}, {}, {} on {}, all in {}",
        files.join(" … "),
        count(frames.len(), "frame"),
        size(&begun.pixels),
        ObjectCounts::of(&begun.scene),
        session.kernel().name(),
        session.device().label(),
        duration(total)
    );
    let as_film = ffmpeg.as_ref().map(|ffmpeg| format!("as a film: {ffmpeg}"));
    let said = [line].into_iter().chain(as_film).collect();
    let summary = FilmSummary {
        work: WorkSummary::new(&session, Some((shape, begun.n_samples))),
        n_frames,
        frames,
        bytes_device: session.bytes_device(),
        ms: FilmTimes { read: Millis(begun.read), total: Millis(total) },
        ffmpeg,
    };
    Ok(Done { files: begun.beside, said, ..Done::in_words(summary, String::new()) })
}

/// The command line that makes a film of the frames; `None` for files that ffmpeg does not read.
fn ffmpeg(output: &Path, n_frames: u32, format: Format, size: [u32; 2]) -> Option<String> {
    if format == Format::Npy {
        return None;
    }
    let pattern = shell_quoted(&pattern_of_files(output, n_frames));
    let film = shell_quoted(&output.with_extension("mp4"));
    // The usual coding of colours takes even numbers of pixels.
    let even = if size.iter().any(|side| side % 2 == 1) {
        " -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2'"
    } else {
        ""
    };
    Some(format!("ffmpeg -framerate 25 -i {pattern}{even} -pix_fmt yuv420p {film}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read() {
        assert_eq!(parse_frames("10-20"), Ok([10, 20]));
        assert_eq!(parse_frames("7"), Ok([7, 7]));
        assert_eq!(parse_frames("7-"), Ok([7, u32::MAX]));
        for wrong in ["", "-", "-5", "0-3", "5-4", "a-b", "1-2-3"] {
            assert!(parse_frames(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_film_is_a_command_for_a_shell() {
        let film = |output: &str, format| ffmpeg(output.as_ref(), 36, format, [64, 48]);
        assert_eq!(
            film("a/out.png", Format::Png).unwrap(),
            "ffmpeg -framerate 25 -i a/out-%04d.png -pix_fmt yuv420p a/out.mp4"
        );
        assert!(film("it's.png", Format::Png).unwrap().contains("'it'\\''s-%04d.png'"));
        let odd = film("it's\na\u{202e}.png", Format::Png).unwrap();
        assert!(odd.contains(" $'it\\'s\\x0aa\\xe2\\x80\\xae-%04d.png' "), "{odd}");
        assert_eq!(film("out.npy", Format::Npy), None);
        let odd = ffmpeg("out.png".as_ref(), 36, Format::Png, [63, 48]).unwrap();
        assert!(odd.contains(" -vf "), "{odd}");
    }
}
