//! The certified kernel asks whether the processor calculates as its proof assumes.
#![allow(unsafe_code)] // MXCSR

use std::arch::asm;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, WorldRay};
use kugelblitz::scene::Scene;
use kugelblitz::support::fpu_check;
use kugelblitz::tracer::Tracer;
use kugelblitz::{Error, Result};
use kugelblitz_tests::{plane, sphere};

const DEFAULT: u32 = 0x1f80;
const FTZ: u32 = 1 << 15;
const DAZ: u32 = 1 << 6;
const DOWN: u32 = 1 << 13;
const UP: u32 = 1 << 14;

fn set_mxcsr(value: u32) {
    // SAFETY: only the rounding mode and the treatment of subnormals change, for this thread; all
    // exceptions stay masked.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &value, options(nostack, readonly)) };
}

/// Runs `work` on a thread of its own with this MXCSR.
fn with<T: Send>(mxcsr: u32, work: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let run = || {
            set_mxcsr(mxcsr);
            let done = work();
            set_mxcsr(DEFAULT);
            done
        };
        scope.spawn(run).join().expect("the thread")
    })
}

fn scene() -> Arc<Scene> {
    let (ball, floor) = (sphere(DVec3::NEG_Z * 5.0, 1.0), plane(DVec3::NEG_Y, DVec3::Y));
    Arc::new(kugelblitz_tests::scene(vec![ball], vec![floor]))
}

/// Undecided in f32: it touches the sphere.
fn rays() -> Rays {
    Rays::List(vec![WorldRay { origin: DVec3::X, direction: DVec3::NEG_Z }; 3])
}

fn prepare(kernel: Kernel) -> Result<Arc<Prepared>> {
    Prepared::new(scene(), kernel, &rays()).map(Arc::new)
}

fn trace(prepared: Arc<Prepared>) -> Result<Hits> {
    let mut hits = Hits::default();
    Tracer::on_cpu(prepared, Outputs::default()).trace(&rays(), &Control::default(), &mut hits)?;
    Ok(hits)
}

fn assert_refused<T: std::fmt::Debug>(result: Result<T>, word: &str) {
    match result {
        Err(Error::Host(message)) => {
            assert!(message.contains(word) && message.contains("MXCSR"), "{word}: {message}");
        }
        other => panic!("{word}: {other:?}"),
    }
}

const DEFECTS: [(u32, &str); 6] = [
    (FTZ, "FTZ"),
    (DAZ, "DAZ"),
    (FTZ | DAZ, "FTZ"),
    (DOWN, "nearest"),
    (UP, "nearest"),
    (DOWN | UP, "nearest"),
];

#[test]
fn the_default_environment_suits() {
    assert!(fpu_check::check().is_ok() && fpu_check::check_all().is_ok());
    assert_eq!(trace(prepare(Kernel::Certified).unwrap()).unwrap().id, [1; 3]);
}

#[test]
fn another_environment_of_the_caller_is_refused() {
    for (bits, word) in DEFECTS {
        let (checked, prepared) =
            with(DEFAULT | bits, || (fpu_check::check(), prepare(Kernel::Certified).map(|_| ())));
        assert_refused(checked, word);
        assert_refused(prepared, word);
        let plain = with(DEFAULT | bits, || prepare(Kernel::Stable).map(|_| ()));
        assert!(plain.is_ok(), "the plain kernels promise nothing: {plain:?}");
    }
    let error = Error::Host(String::new());
    assert_eq!(error.exit_code(), 1);
}

/// A thread inherits the environment of the one that starts it, so that a pool may have another one
/// than its user.
#[test]
fn another_environment_of_the_workers_is_refused() {
    let pool = || rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for (bits, word) in DEFECTS {
        let pool = with(DEFAULT | bits, pool);
        let prepared = prepare(Kernel::Certified).unwrap();
        assert_refused(pool.install(|| prepare(Kernel::Certified).map(|_| ())), word);
        assert_refused(pool.install(|| trace(prepared)), word);
    }
    let pool = pool();
    assert!(pool.install(|| prepare(Kernel::Certified).and_then(trace)).is_ok());
}

/// A worker that waited for all others would take up their work meanwhile, ever deeper.
#[test]
fn many_scenes_are_prepared_side_by_side() {
    use rayon::prelude::*;

    let scene = scene();
    let rays = Rays::List(vec![WorldRay { origin: DVec3::ZERO, direction: DVec3::Z }]);
    let prepare = |_| Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).is_ok();
    assert!((0..200_000).into_par_iter().all(prepare));
}
