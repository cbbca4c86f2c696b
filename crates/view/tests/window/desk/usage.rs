//! Use of a window for longer, and the memory that it takes.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use super::{Desk, Seen, scene};

/// Rounds after which the memory of a window has stopped growing.
const ROUNDS: usize = 20;

/// Most growth of the memory of a window over as many rounds more, MiB: what allocators keep grows a little with each. A picture that
/// each resize left behind would be 40.
const MOST_GROWTH_OF_ROUNDS: f64 = 30.0;

/// Most memory that use takes in addition to the first picture's, MiB. What allocators keep of pictures,
/// frames and shaders fills up over some twenty rounds and then stays: 125 to 131 more than the first
/// picture, with one arena or many. A window that kept what each resize left behind took 251: the bound
/// is halfway.
const MOST_IN_USE: f64 = 190.0;

/// A window on a scene file that changes.
struct Usage {
    seen: Seen,
    path: PathBuf,
    text: String,
    _folder: TempDir,
    _desk: Desk,
}

impl Usage {
    fn begin() -> Usage {
        let desk = Desk::new();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let text = fs::read_to_string(scene("figure1")).unwrap();
        fs::write(&path, &text).unwrap();
        let seen = Seen::open(&desk, &path, &[]);
        Usage { seen, path, text, _folder: folder, _desk: desk }
    }

    /// Drags the picture to the side and so far down.
    #[track_caller]
    fn orbit(&mut self, down: u32) {
        let [middle, aside] = [[200, 150], [330, down]].map(|[x, y]| self.seen.at(x, y));
        self.seen.drag(middle, aside, 1, None);
    }

    /// Asks why a pixel is as it is.
    #[track_caller]
    fn ask(&mut self) {
        self.seen.xdotool(&["click", "1"]);
        self.seen.wait(|event| event.name() == "explained");
        self.seen.key("Escape");
    }

    /// Gives the first sphere another colour, after a file that is wrong.
    #[track_caller]
    fn recolor(&mut self, n: usize) {
        let color = format!("#{:06x}", n * 54321 % 0xff_ffff);
        let text = self.text.replace("#d62728", &color);
        for (text, event) in [("[camera\n", "scene_wrong"), (&text, "reloaded")] {
            fs::write(&self.path, text).unwrap();
            self.seen.wait(|seen| seen.name() == event);
        }
    }
}

/// Everything that takes memory, several times over, from all kernels and painted modes to resizing
/// and reloading: use takes a known amount, and more use no more.
pub fn work_through() {
    let mut usage = Usage::begin();
    let first = usage.seen.memory();
    let mut memory = Vec::new();
    for round in 0..2 * ROUNDS {
        let seen = &mut usage.seen;
        for _ in 0..4 {
            for (key, show) in [("F2", "depth"), ("F3", "normal"), ("F1", "color")] {
                seen.key(key);
                seen.wait(|event| event.is_settled() && event.show() == show);
            }
            let kernels = seen.last_shown().kernels().join(" ");
            seen.key("k");
            seen.wait(|event| event.is_settled() && event.kernels().join(" ") != kernels);
        }
        for n_kernels in [2, 1] {
            seen.key("c");
            seen.wait(|event| event.is_settled() && event.kernels().len() == n_kernels);
        }
        for (width, height) in [(700, 500), (1000, 640), (1280, 800)] {
            seen.resize(width, height);
        }
        usage.orbit(200);
        usage.ask();
        usage.recolor(round + 1);
        usage.seen.reset();
        memory.push(usage.seen.memory());
    }
    println!("memory: {first:.1}, then {memory:.1?} MiB");
    // Of the most that each half took: a single round may just have given some back.
    let most = |some: &[f64]| some.iter().copied().fold(0.0, f64::max);
    let growth = most(&memory[ROUNDS..]) - most(&memory[..ROUNDS]);
    assert!(
        growth < MOST_GROWTH_OF_ROUNDS,
        "{ROUNDS} more rounds took {growth:.1} MiB: {memory:.1?}"
    );
    let in_use = memory[2 * ROUNDS - 1] - first;
    assert!(in_use < MOST_IN_USE, "use took {in_use:.1} MiB: {first:.1}, then {memory:.1?}");
    usage.seen.quit();
}
