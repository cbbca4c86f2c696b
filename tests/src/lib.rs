//! Objects, files and the device that tests share.

#![allow(missing_docs)]

pub mod adversarial;
pub mod folder;
pub mod made_report;
pub mod oracle;
pub mod printer;
pub mod rational;
pub mod spoiled;
pub mod twins;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::gpu::Gpu;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays};
use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use kugelblitz_judge::compare::compare;
use rand::{Rng, RngExt};

/// The device of the GPU tests. A missing one is a failure, never a skip: `ci/setup.sh` installs a
/// software driver. Each caller is counted in `gpu-tests.log`, which `ci/test.sh` reads.
pub fn gpu() -> Arc<Gpu> {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        Arc::new(Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one"))
    });
    let test = std::thread::current().name().unwrap_or("?").to_string();
    log_device(&format!("{test} on {} ({})", gpu.facts.name, gpu.facts.driver));
    Arc::clone(gpu)
}

/// Writes that a test ran on a device into `gpu-tests.log` of the folder of builds.
pub fn log_device(line: &str) {
    let log = build_folder().join("gpu-tests.log");
    let mut log = std::fs::OpenOptions::new().create(true).append(true).open(log).expect("log");
    // One write a line: tests run side by side.
    log.write_all(format!("{line}\n").as_bytes()).expect("log");
}

/// The repository: where the tests were built, or for a test that was carried elsewhere where it is run.
pub fn root() -> &'static Path {
    let built =
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a folder above that of the tests");
    if built.is_dir() { built } else { Path::new(".") }
}

/// The text of a file of the repository.
pub fn text_of(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Asserts that a file of the repository has this text. With `KUGELBLITZ_PRINT=1` it is written anew.
#[track_caller]
pub fn assert_kept(path: &str, text: &str) {
    let file = root().join(path);
    let is_kept = std::fs::read_to_string(&file).is_ok_and(|kept| kept == text);
    if !is_kept && std::env::var_os("KUGELBLITZ_PRINT").is_some() {
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        std::fs::write(&file, text).expect("a file that can be written");
    }
    let kept = std::fs::read_to_string(&file).unwrap_or_default();
    let differs = |n: &usize| kept.lines().nth(*n) != text.lines().nth(*n);
    if kept != text {
        let n = (0..kept.lines().count()).find(differs).unwrap_or(kept.lines().count());
        let [kept, now] = [&kept[..], text].map(|all| all.lines().nth(n).unwrap_or_default());
        panic!(
            "{path}, line {}:\n{kept}\nis now\n{now}\nRun this test with KUGELBLITZ_PRINT=1 to write the file again",
            n + 1
        );
    }
}

/// Columns and rows of the pictures of [`digests`].
pub const DIGEST_SIZE: [u32; 2] = [96, 54];

/// The digests of all scenes by their names, `figure1`, as `tests/digests.txt` has them, which `kugelblitz digest --write` made.
pub fn digests() -> BTreeMap<String, String> {
    let named = |line: &str| {
        let (digest, path) = (line.split("  ").next()?, line.split("  ").last()?);
        let name = path.strip_prefix("scenes/")?.strip_suffix(".toml")?;
        Some((name.to_owned(), digest.to_owned()))
    };
    text_of("tests/digests.txt").lines().map(|line| named(line).expect("a digest")).collect()
}

/// The folder of a profile's builds, `target/ci`: the one that holds `deps` with the running test.
pub fn build_folder() -> PathBuf {
    let test = std::env::current_exe().expect("the running test");
    test.ancestors().nth(2).expect("a folder of builds").to_owned()
}

/// Whether the device of the tests has what a kernel needs: not each has f64. `tests/device/tracers.rs` sees that
/// the kernel is refused there.
pub fn runs(kernel: Kernel) -> bool {
    gpu().facts.check_kernel(kernel).is_ok()
}

/// What is broken of the promise for these hits: the CPU's bits for `certified`, and for the others where the device's
/// arithmetic is that of IEEE 754.
pub fn broken(kernel: Kernel, on_cpu: &Hits, on_gpu: &Hits) -> Option<String> {
    if kernel != Kernel::Certified && !gpu().is_ieee(kernel).unwrap() {
        return None;
    }
    let first = compare(on_cpu, on_gpu).first?;
    let of = |hits: &Hits| {
        let (t, normal) = (hits.t.get(first), hits.normal.get(first));
        format!("{} {t:?} {normal:?}", hits.id[first])
    };
    let name = kernel.name();
    Some(format!("{name}, ray {first}\ncpu: {}\ngpu: {}", of(on_cpu), of(on_gpu)))
}

/// What a kernel sees, with surfaces and stages, on the CPU or on `gpu`.
pub fn traced(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, gpu: Option<&Arc<Gpu>>) -> Hits {
    let device = gpu.map_or(Device::Cpu, |gpu| Device::Gpu(Arc::clone(gpu)));
    let mut session = Session::new(Arc::clone(scene), device, kernel);
    let (mut hits, wants) = (Hits::default(), Outputs { surface: true, level: true });
    session.trace(rays, wants, &Control::default(), &mut hits).expect("hits");
    hits
}

/// A number whose logarithm is uniform, of either sign.
pub fn log_uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    let magnitude = (rng.random_range(low.ln()..high.ln())).exp();
    if rng.random() { magnitude } else { -magnitude }
}

/// A vector with components in `-1..1`.
pub fn in_cube(rng: &mut impl Rng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}

/// A sphere without a name.
pub fn sphere(center: DVec3, radius: f64) -> Sphere {
    Sphere { center, radius }
}

/// A plane without a name.
pub fn plane(point: DVec3, normal: DVec3) -> Plane {
    Plane { name: None, point, normal, color: Color([0.5; 3]) }
}

/// A scene of these objects without a camera.
pub fn scene(spheres: Vec<Sphere>, planes: Vec<Plane>) -> Scene {
    Scene { spheres: spheres.into(), planes, ..Scene::default() }
}

/// A camera looking from one point to another.
pub fn camera(position: DVec3, look_at: DVec3) -> Camera {
    Camera {
        position,
        look_at,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 45.0 },
    }
}

/// An `.npy` file of these rays: origins and directions.
pub fn npy_of_rays(rays: &[[f64; 6]]) -> Vec<u8> {
    let rows: Vec<_> = rays.iter().map(|ray| ray.to_vec()).collect();
    npy_of(6, &rows, "<f8", false)
}

/// An `.npy` file of these rows: `value` is `<f4`, `>f4`, `<f8` or `>f8`.
pub fn npy(rows: &[Vec<f64>], value: &str, fortran: bool) -> Vec<u8> {
    npy_of(rows.first().map_or(3, Vec::len), rows, value, fortran)
}

fn npy_of(n_columns: usize, rows: &[Vec<f64>], value: &str, fortran: bool) -> Vec<u8> {
    let by_columns = || (0..n_columns).flat_map(|column| rows.iter().map(move |row| row[column]));
    let numbers: Vec<f64> =
        if fortran { by_columns().collect() } else { rows.iter().flatten().copied().collect() };
    let bytes = |number: &f64| match value {
        "<f4" => (*number as f32).to_le_bytes().to_vec(),
        ">f4" => (*number as f32).to_be_bytes().to_vec(),
        "<f8" => number.to_le_bytes().to_vec(),
        ">f8" => number.to_be_bytes().to_vec(),
        other => panic!("{other}"),
    };
    let data: Vec<u8> = numbers.iter().flat_map(bytes).collect();
    npy_file(&format!("'{value}'"), fortran, &format!("({}, {n_columns})", rows.len()), &data)
}

/// An `.npy` file of version 1 with this header and these bytes behind it.
pub fn npy_file(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
    // Padded to a multiple of 64 bytes.
    let n_text = (header.len() + 11).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((n_text as u16).to_le_bytes());
    bytes.extend(format!("{header:<width$}\n", width = n_text - 1).bytes());
    bytes.extend(data);
    bytes
}
