//! Painting numbers into a resting picture, on a thread of its own.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::paint;
use super::show::Show;
use super::tracing::{Backend, DevicePicture, hits_of};
use super::worker::{Turn, Worker};
use crate::error::Result;
use crate::gpu::{Pool, Words};
use crate::prepare::Prepared;
use crate::session::Session;
use crate::trace::{Hits, Kernel, Rays};
use crate::verify::Truth;

/// How long the camera must rest before painting begins: else numbers and colours would flicker.
const REST: Duration = Duration::from_millis(60);

/// Time between two looks at what is painted so far.
const BETWEEN_LOOKS: Duration = Duration::from_millis(250);

/// Side of the blocks that stand for their first pixel, pass by pass.
const BLOCKS: [usize; 4] = [8, 4, 2, 1];

/// Rays that exact arithmetic takes at a time.
const RAYS_AT_ONCE: usize = 1 << 12;

/// Something to paint.
pub struct Painting {
    /// The picture that it belongs to.
    pub picture: Arc<DevicePicture>,
    /// The mode of showing.
    pub show: Show,
}

/// Paint for one kernel's picture.
pub struct Painted {
    /// Number of the picture.
    pub serial: u64,
    /// The mode of showing.
    pub show: Show,
    /// Place of the kernel in the picture.
    pub place: usize,
    /// Part that is done, 0 to 1.
    pub share: f32,
    /// The colours.
    pub words: Arc<Words>,
}

/// Starts the thread.
///
/// # Errors
/// Those of [`Worker::start`].
pub fn start(
    backend: Backend,
    say: impl Fn(Result<Painted>) + Send + 'static,
) -> Result<Worker<Painting>> {
    let mut painter = Painter { backend, pool: Pool::default() };
    Worker::start("painting", say, move |job, turn, say| painter.work(&job, turn, say))
}

struct Painter {
    backend: Backend,
    pool: Pool,
}

impl Painter {
    fn work(&mut self, job: &Painting, turn: &Turn<Painting>, say: &dyn Fn(Painted)) -> Result<()> {
        if !turn.rest(REST) {
            return Ok(());
        }
        let order = &job.picture.order;
        // Gone with the job: its room for results is larger than the picture, and painting is rare.
        let device = self.backend.device.clone();
        let mut session = Session::new(Arc::clone(&order.scene), device, Kernel::Certified);
        for (place, &kernel) in order.kernels.iter().enumerate() {
            let hits = hits_of(&mut session, &order.scene, kernel, order.pixels, &turn.control)?;
            let words = self.pool.take(&self.backend.screen, order.pixels.len());
            let show = |colors: &[u32], share| {
                words.write(0, colors);
                let (serial, show, words) = (order.serial, job.show, Arc::clone(&words));
                say(Painted { serial, show, place, share, words });
            };
            match job.show {
                Show::Color | Show::Id | Show::Side => {}
                Show::Depth => show(&paint::depth(&hits), 1.0),
                Show::Normal => show(&paint::normal(&hits), 1.0),
                Show::Stage => show(&paint::stage(&hits), 1.0),
                Show::Discriminant => show(&discriminants(job, kernel, &hits)?, 1.0),
                Show::Error => errors(job, &hits, turn, &show)?,
            }
        }
        Ok(())
    }
}

fn discriminants(job: &Painting, kernel: Kernel, hits: &Hits) -> Result<Vec<u32>> {
    let order = &job.picture.order;
    let rays = Rays::Pixels(order.pixels);
    let prepared = Prepared::new(Arc::clone(&order.scene), kernel, &rays)?;
    let discriminants = paint::Discriminants::new(&prepared, &order.pixels);
    let color = |(index, &id): (usize, &u32)| discriminants.color(index, id);
    Ok(hits.id.par_iter().enumerate().map(color).collect())
}

/// Exact arithmetic takes microseconds a ray and object: first coarse, then fine.
fn errors(
    job: &Painting,
    hits: &Hits,
    turn: &Turn<Painting>,
    show: &impl Fn(&[u32], f32),
) -> Result<()> {
    let order = &job.picture.order;
    let (width, height) = (order.pixels.width as usize, order.pixels.height as usize);
    let mut colors = vec![0; hits.id.len()];
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
            let truth =
                Truth::of_pixels(&order.scene, &order.pixels, some.to_vec(), &turn.control)?;
            for (k, &index) in some.iter().enumerate() {
                let color = paint::error(hits, &truth, k);
                let (x, y) = (index % width, index / width);
                for row in y..(y + block).min(height) {
                    colors[row * width + x..row * width + (x + block).min(width)].fill(color);
                }
            }
            n_done += some.len();
            if n_done == colors.len() || last_look.elapsed() > BETWEEN_LOOKS {
                show(&colors, n_done as f32 / colors.len() as f32);
                last_look = Instant::now();
            }
        }
        coarser = block;
    }
    Ok(())
}
