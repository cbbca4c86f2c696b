//! Traces the window's pictures, on a thread of its own. The ids stay on the device.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::worker::{Turn, Worker};
use crate::certify::{Decided, Stage};
use crate::control::Control;
use crate::device::Device;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Pool, Undecided, Words};
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::scene::Scene;
use crate::session::Session;
use crate::trace::{Hits, Kernel, Level, Rays, StageCounts, Timing, Wants};
use crate::tracer::Tracer;

/// The CPU decides this long before the picture is shown without what is still undecided.
const BEFORE_SHOWING: Duration = Duration::from_millis(8);

/// Rays that are decided between two looks at the clock.
const DECIDE_AT_ONCE: usize = 1024;

/// The device that shows the pictures, and the one that traces them: the same, or the CPU.
#[derive(Clone)]
pub struct Backend {
    /// Pictures lie here.
    pub screen: Arc<Gpu>,
    /// Rays are traced here.
    pub device: Device,
}

/// A picture that is wanted.
#[derive(Clone)]
pub struct Order {
    /// Its number; newer ones have higher numbers.
    pub serial: u64,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Camera and size.
    pub pixels: Pixels,
    /// One kernel, or two to be shown side by side.
    pub kernels: Vec<Kernel>,
}

/// A picture on the device.
pub struct DevicePicture {
    /// The order that it answers.
    pub order: Order,
    /// The ids, one a pixel, of each kernel.
    pub ids: Vec<Arc<Words>>,
    /// Time that tracing took, and deciding until the picture was first shown; without compiling.
    pub time: Duration,
    progress: Mutex<Progress>,
}

/// How far the CPU is with what the device left undecided.
#[derive(Clone, Copy, Debug, Default)]
pub struct Progress {
    /// Rays that the device left undecided.
    pub undecided: u64,
    /// How many of them are not decided yet.
    pub left: u64,
    /// How many rays each stage decided so far.
    pub counts: StageCounts,
}

impl DevicePicture {
    /// How far the CPU is.
    pub fn progress(&self) -> Progress {
        *self.lock()
    }

    fn lock(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A message of the thread.
pub enum Traced {
    /// A new picture.
    Picture(Arc<DevicePicture>),
    /// More of this picture is decided.
    More,
}

/// Starts the thread. `closing` stops a trace that would take long.
///
/// # Errors
/// Those of compiling and of [`Worker::start`].
pub fn start(
    backend: Backend,
    closing: Arc<Control>,
    say: impl Fn(Result<Traced>) + Send + 'static,
) -> Result<Worker<Order>> {
    let undecided = Undecided::new(&backend.screen)?;
    let mut tracing = Tracing {
        backend,
        closing,
        undecided,
        pool: Pool::default(),
        tracers: Vec::new(),
        last_prepared: None,
    };
    Worker::start("tracing", say, move |order, turn, say| tracing.work(order, turn, say))
}

struct Tracing {
    backend: Backend,
    closing: Arc<Control>,
    undecided: Undecided,
    pool: Pool,
    /// One for each place in the window.
    tracers: Vec<Tracer>,
    /// Has the tree over many spheres.
    last_prepared: Option<Arc<Prepared>>,
}

/// A layer with the rays that are not decided yet.
struct OpenLayer {
    prepared: Arc<Prepared>,
    ids: Arc<Words>,
    rays: Vec<u32>,
}

impl Tracing {
    fn work(&mut self, order: Order, turn: &Turn<Order>, say: &dyn Fn(Traced)) -> Result<()> {
        let rays = Rays::Pixels(order.pixels);
        let mut time = Duration::ZERO;
        let mut open = Vec::new();
        let mut progress = Progress::default();
        for (place, &kernel) in order.kernels.iter().enumerate() {
            let layer = self.trace(&order, place, kernel, &mut time)?;
            progress.undecided += layer.rays.len() as u64;
            progress.counts.f32 += (order.pixels.len() - layer.rays.len()) as u64;
            open.push(layer);
        }
        progress.left = progress.undecided;

        let ids = open.iter().map(|layer| Arc::clone(&layer.ids)).collect();
        let mut picture =
            DevicePicture { order, ids, time: Duration::ZERO, progress: Mutex::new(progress) };
        let decide = |some: &[u32], layer: &OpenLayer, picture: &DevicePicture| -> Result<()> {
            let stage = Stage::new(&layer.prepared, &rays);
            let decided = stage.decide(some, &turn.control, &mut Timing::default())?;
            self.undecided.decide(&layer.ids, &decided)?;
            count(&mut picture.lock(), &decided);
            Ok(())
        };
        let before = Instant::now();
        let mut parts = open
            .iter()
            .flat_map(|layer| layer.rays.chunks(DECIDE_AT_ONCE).map(move |some| (some, layer)))
            .peekable();
        // A newer order does not keep this one from being shown, or nothing would be while the
        // camera moves.
        while before.elapsed() < BEFORE_SHOWING
            && !turn.is_over()
            && let Some((some, layer)) = parts.next()
        {
            match decide(some, layer, &picture) {
                Err(Error::Interrupted) => break,
                result => result?,
            }
        }
        picture.time = time + before.elapsed();
        let picture = Arc::new(picture);
        say(Traced::Picture(Arc::clone(&picture)));
        for (some, layer) in parts {
            decide(some, layer, &picture)?;
            say(Traced::More);
        }
        Ok(())
    }

    /// The ids as a backend proposes them, and the rays among them that are still to be decided.
    fn trace(
        &mut self,
        order: &Order,
        place: usize,
        kernel: Kernel,
        time: &mut Duration,
    ) -> Result<OpenLayer> {
        let Order { scene, pixels, .. } = order;
        let rays = Rays::Pixels(*pixels);
        self.last_prepared.take_if(|old| !Arc::ptr_eq(&old.scene, scene));
        let old = self.last_prepared.as_deref();
        let prepared = Prepared::renewed(old, Arc::clone(scene), kernel, &rays, &self.closing)?;
        let prepared = Arc::new(prepared);
        if prepared.hierarchy.is_some() {
            self.last_prepared = Some(Arc::clone(&prepared));
        }
        match self.tracers.get_mut(place) {
            Some(tracer) => tracer.retarget(Arc::clone(&prepared))?,
            None => {
                let made = self.backend.device.tracer(&prepared, Wants::default())?;
                self.tracers.push(made.tracer);
            }
        }
        let ids = self.pool.take(&self.backend.screen, pixels.len());
        let start = Instant::now();
        self.tracers[place].propose_resident(&rays, &self.closing, &ids)?;
        let rays = match kernel {
            Kernel::Certified if prepared.starts_in_f64() => (0..rays.len() as u32).collect(),
            Kernel::Certified => self.undecided.find(&ids)?,
            Kernel::Lecture | Kernel::Stable | Kernel::Double => Vec::new(),
        };
        *time += start.elapsed();
        Ok(OpenLayer { prepared, ids, rays })
    }
}

fn count(progress: &mut Progress, decided: &[Decided]) {
    progress.left -= decided.len() as u64;
    for one in decided {
        match one.level {
            Level::Exact => progress.counts.exact += 1,
            Level::F32 | Level::F64 => progress.counts.f64 += 1,
        }
    }
}

/// `t`, normals and stages of `pixels`: what `render` writes to an EXR file.
///
/// # Errors
/// Those of [`Session::trace`].
pub fn hits_of(
    session: &mut Session,
    scene: &Arc<Scene>,
    kernel: Kernel,
    pixels: Pixels,
    control: &Control,
) -> Result<Hits> {
    session.set_scene(Arc::clone(scene));
    session.set_kernel(kernel);
    let (mut hits, wants) = (Hits::default(), Wants { surface: true, level: true });
    session.trace(&Rays::Pixels(pixels), wants, control, &mut hits)?;
    Ok(hits)
}
