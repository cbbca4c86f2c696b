//! Painting light, samples and numbers into a resting picture, on a thread of its own.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::look::{Look, word};
use super::tracing::{Backend, DevicePicture, hits_of};
use super::worker::{Turn, Worker};
use crate::control::Control;
use crate::error::Result;
use crate::gpu::{Pool, Words};
use crate::memory::Available;
use crate::picture::{Format, PictureOptions};
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::render::plan;
use crate::scene::{Samples, Scene};
use crate::session::Session;
use crate::show::{self, Show, Tally, Tint};
use crate::trace::{Hits, Kernel, Rays};
use crate::verify::Truth;

/// How long the camera must rest before painting begins: else numbers and colours would flicker.
const REST: Duration = Duration::from_millis(60);

/// Time between two looks at what is painted so far.
const BETWEEN_LOOKS: Duration = Duration::from_millis(250);

/// Side of the blocks that stand for their first pixel, pass by pass.
const BLOCKS: [usize; 4] = [8, 4, 2, 1];

/// Rows of the first band of colours with one sample a pixel.
const FIRST_ROWS: u32 = 8;

/// A band of colours takes about this long, unless a single row takes longer.
const BAND_TIME: Duration = Duration::from_millis(100);

/// Rays that exact arithmetic takes at a time.
const RAYS_AT_ONCE: usize = 1 << 12;

/// A pixel that is not painted yet.
const OPEN: Tint = Tint { color: [0; 3], entry: Tint::NO_ENTRY - 1 };

/// The colour of a pixel as a word; transparent where it is open.
fn shown_word(tint: &Tint) -> u32 {
    if *tint == OPEN { 0 } else { word(tint.color) }
}

/// Something to paint.
pub struct Painting {
    /// The picture that it belongs to.
    pub picture: Arc<DevicePicture>,
    /// Its scene, with the light that colours have.
    pub scene: Arc<Scene>,
    /// How it is looked at.
    pub look: Look,
}

/// Paint for one kernel's picture.
pub struct Painted {
    /// Number of the picture.
    pub serial: u64,
    /// How it is looked at.
    pub look: Look,
    /// Place of the kernel in the picture.
    pub place: usize,
    /// Part that is done, 0 to 1.
    pub share: f32,
    /// The colours.
    pub words: Arc<Words>,
    /// The smallest and the largest `t` of all kernels' pictures, for the depth.
    pub range: Option<[f32; 2]>,
    /// The pixels of each meaning, once all are painted.
    pub tally: Tally,
}

/// Starts the thread.
///
/// # Errors
/// Those of [`Worker::start`].
pub fn start(
    backend: Backend,
    say: impl Fn(Result<Painted>) + Send + 'static,
) -> Result<Worker<Painting>> {
    let mut painter = Painter { backend, pool: Pool::default(), easels: Vec::new() };
    Worker::start("painting", say, move |job, turn, say| painter.work(&job, turn, say))
}

struct Painter {
    backend: Backend,
    pool: Pool,
    /// One for each kernel. Colours are painted whenever the camera rests, so what makes them is
    /// kept, the tree over many spheres above all, as long as they are.
    easels: Vec<Easel>,
}

/// Colours of one kernel's pictures, and what makes them.
struct Easel {
    session: Session,
    words: Vec<u32>,
    /// The picture, and whether it is lit, whose colours all are there, with some number of samples.
    covered: Option<(u64, bool)>,
}

impl Painter {
    fn work(&mut self, job: &Painting, turn: &Turn<Painting>, say: &dyn Fn(Painted)) -> Result<()> {
        let Painting { picture, scene, look } = job;
        let order = &picture.order;
        let n_easels = match look.show {
            Show::Color if look.is_painted() => order.kernels.len(),
            _ => 0,
        };
        let device = &self.backend.device;
        let new = || Easel::new(Session::new(Arc::clone(scene), device.clone(), Kernel::Certified));
        self.easels.resize_with(n_easels, new);
        if !look.is_painted() || !turn.rest(REST) {
            return Ok(());
        }
        let words: Vec<Arc<Words>> = order
            .kernels
            .iter()
            .map(|_| self.pool.take(&self.backend.screen, order.pixels.len()))
            .collect();
        let show = |place: usize, colors: &[u32], share, range, tally| {
            words[place].write(0, colors);
            let (serial, look, words) = (order.serial, *look, Arc::clone(&words[place]));
            say(Painted { serial, look, place, share, words, range, tally });
        };
        if look.show == Show::Color {
            for (place, &kernel) in order.kernels.iter().enumerate() {
                let easel = &mut self.easels[place];
                easel.session.set_scene(Arc::clone(scene));
                easel.session.set_kernel(kernel);
                let show =
                    |colors: &[u32], share| show(place, colors, share, None, Tally::default());
                let of = (order.serial, look.is_lit);
                easel.paint(of, &order.pixels, look.n_samples, &turn.control, &show)?;
            }
            return Ok(());
        }
        // Gone with the job: its room for results is larger than the picture, and painting is rare.
        let scene = Arc::clone(&order.scene);
        let mut session = Session::new(scene, device.clone(), Kernel::Certified);
        let hits = order.kernels.iter().map(|&kernel| {
            hits_of(&mut session, &order.scene, kernel, order.pixels, &turn.control)
        });
        let hits = hits.collect::<Result<Vec<Hits>>>()?;
        // One scale for all, so that they can be compared.
        let range = hits.iter().fold(None, show::wider);
        let show_tints = |place, tints: &[Tint], share: f32| {
            let mut tally = Tally::default();
            if share >= 1.0 {
                tally.add(&order.pixels, tints);
            }
            let colors: Vec<u32> = tints.iter().map(shown_word).collect();
            show(place, &colors, share, range, tally);
        };
        if look.show == Show::Error {
            return errors(job, &hits, &turn.control, &show_tints);
        }
        for (place, (hits, &kernel)) in hits.iter().zip(&order.kernels).enumerate() {
            let rays = Rays::Pixels(order.pixels);
            let prepared = Prepared::new(Arc::clone(&order.scene), kernel, &rays)?;
            let control = &turn.control;
            let tints = show::tints(look.show, &prepared, &order.pixels, hits, range, control)?;
            show_tints(place, &tints, 1.0);
        }
        Ok(())
    }
}

impl Easel {
    fn new(session: Session) -> Easel {
        Easel { session, words: Vec::new(), covered: None }
    }

    /// Light and samples may take seconds: first one sample a pixel, then all, each time in bands from the
    /// top. Below them the same picture with other samples stays, else they are transparent, and the flat
    /// colours of the ids are seen.
    fn paint(
        &mut self,
        of: (u64, bool),
        pixels: &Pixels,
        n_samples: Samples,
        control: &Control,
        show: &impl Fn(&[u32], f32),
    ) -> Result<()> {
        let Easel { session, words, covered } = self;
        let mut passes = vec![n_samples];
        if *covered != Some(of) {
            *covered = None;
            words.clear();
            words.resize(pixels.len(), 0);
            if n_samples > Samples::ONE {
                passes.insert(0, Samples::ONE);
            }
        }
        let (width, height) = (pixels.width as usize, pixels.height);
        let work_of = |n: Samples, n_rows: u32| u64::from(n.of_pixel()) * u64::from(n_rows);
        let work: u64 = passes.iter().map(|&n| work_of(n, height)).sum();
        let (mut done, mut last_look) = (0, Instant::now());
        for n in passes {
            let (options, n_objects) = (PictureOptions::default(), session.scene().n_objects());
            let plan = plan(Format::Png, options, n, pixels, n_objects, Available::now())?;
            let (mut y, mut n_rows) = (0, (FIRST_ROWS / n.across()).max(1));
            while y < height {
                let start = Instant::now();
                let band = pixels.rows(y, n_rows.min(plan.n_band_rows).min(height - y));
                let colors = session.colors(&band, n, control)?;
                for (painted, color) in words[y as usize * width..].iter_mut().zip(colors) {
                    *painted = word(color);
                }
                y += band.height;
                done += work_of(n, band.height);
                if start.elapsed() < BAND_TIME / 2 {
                    n_rows = band.height * 2;
                } else if start.elapsed() > BAND_TIME * 2 {
                    n_rows = (band.height / 2).max(1);
                }
                if y == height || last_look.elapsed() > BETWEEN_LOOKS {
                    show(words, done as f32 / work as f32);
                    last_look = Instant::now();
                }
            }
            *covered = Some(of);
        }
        Ok(())
    }
}

/// Exact arithmetic takes microseconds a ray and object: first coarse, then fine, and once for all kernels.
fn errors(
    job: &Painting,
    hits: &[Hits],
    control: &Control,
    show: &impl Fn(usize, &[Tint], f32),
) -> Result<()> {
    let order = &job.picture.order;
    let (width, height) = (order.pixels.width as usize, order.pixels.height as usize);
    let mut tints = vec![vec![OPEN; order.pixels.len()]; hits.len()];
    let (mut n_done, mut last_look) = (0, Instant::now());
    let mut coarser = usize::MAX;
    for block in BLOCKS {
        let is_new = |&(x, y): &(usize, usize)| {
            coarser == usize::MAX || x % coarser != 0 || y % coarser != 0
        };
        let places: Vec<usize> = (0..height)
            .step_by(block)
            .flat_map(|y| (0..width).step_by(block).map(move |x| (x, y)))
            .filter(is_new)
            .map(|(x, y)| y * width + x)
            .collect();
        for some in places.chunks(RAYS_AT_ONCE) {
            let truth = Truth::of_pixels(&order.scene, &order.pixels, some.to_vec(), control)?;
            for (hits, tints) in hits.iter().zip(&mut tints) {
                for (k, &index) in some.iter().enumerate() {
                    let tint = show::error(hits, &truth, k);
                    let (x, y) = (index % width, index / width);
                    for row in y..(y + block).min(height) {
                        tints[row * width + x..row * width + (x + block).min(width)].fill(tint);
                    }
                }
            }
            n_done += some.len();
            let is_done = n_done == order.pixels.len();
            if is_done || last_look.elapsed() > BETWEEN_LOOKS {
                let share = n_done as f32 / order.pixels.len() as f32;
                for (place, tints) in tints.iter().enumerate() {
                    // f32 may round a share of nearly all up to 1.
                    show(place, tints, if is_done { 1.0 } else { share.min(0.999) });
                }
                last_look = Instant::now();
            }
        }
        coarser = block;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;
    use crate::device::Device;
    use crate::error::Error;
    use crate::scene::parse_scene;

    const SIZE: [u32; 2] = [96, 54];

    fn easel(change: impl FnOnce(&mut Scene)) -> Easel {
        let text = include_str!("../../scenes/lit/figure1.toml");
        let mut scene = parse_scene(text, "figure1.toml".as_ref()).unwrap();
        change(&mut scene);
        Easel::new(Session::new(scene, Device::Cpu, Kernel::Certified))
    }

    /// All that is shown on the way to a picture, with the parts that are done.
    fn shown(easel: &mut Easel, serial: u64, n_samples: u32) -> Vec<(Vec<u32>, f32)> {
        let pixels = easel.session.pixels(SIZE[0], SIZE[1]).unwrap();
        let shown = RefCell::new(Vec::new());
        let show = |words: &[u32], share| shown.borrow_mut().push((words.to_vec(), share));
        easel
            .paint((serial, true), &pixels, Samples::nearest(n_samples), &Control::default(), &show)
            .unwrap();
        shown.into_inner()
    }

    fn rendered(n_samples: u32) -> Vec<u32> {
        let mut session = easel(|scene| scene.samples = Some(Samples::nearest(n_samples))).session;
        let picture = session.render(SIZE[0], SIZE[1]).unwrap();
        picture.srgb8.into_iter().map(word).collect()
    }

    #[test]
    fn painting_ends_with_the_picture_that_is_rendered() {
        let mut easel = easel(|_| {});
        // The picture of number 4 comes twice: its first colours stay until there are better ones.
        for (serial, n_samples) in [(1, 1), (2, 2), (3, 3), (4, 1), (4, 2)] {
            let is_new = easel.covered != Some((serial, true));
            let shown = shown(&mut easel, serial, n_samples);
            let (last, before) = shown.split_last().unwrap();
            assert_eq!(*last, (rendered(n_samples), 1.0), "{n_samples}");
            assert!(before.iter().all(|(_, share)| *share < 1.0));
            assert!(before.is_sorted_by(|(_, a), (_, b)| a < b));
            if is_new && n_samples > 1 {
                assert!(before.iter().any(|(words, _)| *words == rendered(1)), "{n_samples}");
            }
            assert!(is_new || shown.iter().all(|(words, _)| !words.contains(&0)));
        }
    }

    #[test]
    fn painting_stops_when_it_is_cancelled() {
        let mut easel = easel(|_| {});
        let pixels = easel.session.pixels(SIZE[0], SIZE[1]).unwrap();
        let control = Control::default();
        let shares = RefCell::new(Vec::new());
        let show = |_: &[u32], share| {
            control.cancel();
            shares.borrow_mut().push(share);
        };
        let stopped = easel.paint((1, true), &pixels, Samples::nearest(16), &control, &show);
        assert!(matches!(stopped, Err(Error::Interrupted)));
        assert!(matches!(shares.into_inner()[..], [share] if share < 0.1));
    }
}
