//! A report with made-up but likely figures, for tests of its renderers.

use std::sync::Arc;

use kugelblitz::gpu::{AdapterFacts, Arithmetic};
use kugelblitz::query::StageCounts;
use kugelblitz_report::{
    AdapterArithmetic, ClassRow, DistanceRow, Environment, ErrorQuantiles, KernelOnDevice,
    RayErrors, Report, ReportScene, SceneClass, SceneRow, Settings, ShadowRow, SpheresRow,
    TimeSpread, Unmeasured,
};

pub const KERNELS: [&str; 4] = ["lecture", "stable", "double", "certified"];
pub const DEVICES: [&str; 2] = ["llvmpipe (LLVM 15.0.6, 256 bits)", "CPU"];

const SCENES: [(&str, SceneClass); 8] = [
    ("figure1", SceneClass::Lecture),
    ("figure2", SceneClass::Lecture),
    ("inside", SceneClass::Lecture),
    ("huge_ground", SceneClass::Hard),
    ("grazing", SceneClass::Hard),
    ("far_away", SceneClass::Hard),
    ("glancing_plane", SceneClass::Hard),
    ("mirror_twins", SceneClass::Hard),
];

/// Returns the place of a kernel among all, and all kernels on all devices.
fn each() -> impl Iterator<Item = (usize, KernelOnDevice)> {
    DEVICES.iter().flat_map(|device| {
        let of = move |(i, kernel)| (i, KernelOnDevice { kernel, device: device.to_string() });
        KERNELS.into_iter().enumerate().map(of)
    })
}

/// Returns times whose maximum is a fifth above the median.
fn times(median: f64) -> TimeSpread {
    TimeSpread { median, min: 0.95 * median, max: 1.2 * median, n: 9 }
}

/// Returns the errors of the kernel at this place for a hardness from 0 to 1.
fn errors(kernel: usize, hardness: f64) -> RayErrors {
    let wrong = [26_000.0 * hardness.powi(3), 1300.0 * hardness.powi(6), 2.0 * hardness, 0.0];
    let wrong = wrong[kernel] as u64;
    let t_ulp = [10f64.powf(6.0 * hardness), 10f64.powf(hardness), 0.6, 0.5][kernel];
    let quantiles = |p999: f64| ErrorQuantiles { median: p999 / 40.0, p999, max: 20.0 * p999 };
    RayErrors {
        compared: 1 << 16,
        false_hits: wrong / 5,
        false_misses: wrong / 2,
        wrong_object: wrong - wrong / 5 - wrong / 2,
        t_ulp: Some(quantiles(t_ulp)),
        normal_degrees: Some(quantiles(3.4e-6 * t_ulp)),
    }
}

fn ns_per_ray(kernel: usize, of: &KernelOnDevice, n_objects: f64) -> TimeSpread {
    let device = if of.device == "CPU" { 2.6 } else { 1.0 };
    times(2.1 * [1.0, 1.22, 2.4, 1.34][kernel] * device * n_objects)
}

fn environment() -> Environment {
    let arithmetic = Arithmetic {
        passthrough: true,
        no_contraction: true,
        rounded_products: true,
        fused_fma: false,
        subnormals: true,
        safe_range: true,
        faithful: true,
        comparisons: true,
        infinities: true,
        integers: true,
        texels: true,
        narrows_to_nearest: true,
        sum_ulp: 0,
        product_ulp: 0,
        quotient_ulp: 0,
        reciprocal_ulp: 0,
        root_ulp: 0,
    };
    let facts = AdapterFacts {
        name: DEVICES[0].into(),
        kind: "software",
        driver: "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)".into(),
        passthrough: true,
        f64: true,
        max_binding_bytes: 1 << 27,
        max_buffer_bytes: 1 << 31,
        max_storage_buffers: 8,
        max_workgroups: 65535,
        max_texture_side: 1 << 14,
    };
    let arithmetic_f64 = Some(arithmetic);
    Environment {
        version: "0.1.0".into(),
        commit: Some("9fc4bae1c0de".into()),
        date: "2026-11-21T07:00:00Z".into(),
        command: "kugelblitz report -o report.html".into(),
        system: "Debian GNU/Linux 12".into(),
        host_cpu: "A CPU @ 2.60GHz".into(),
        n_cores: 2,
        adapters: vec![AdapterArithmetic { facts, arithmetic_f32: arithmetic, arithmetic_f64 }],
    }
}

fn scene((name, class): (&str, SceneClass)) -> ReportScene {
    ReportScene {
        name: name.into(),
        class,
        about: format!("First comment of {name}."),
        n_spheres: 3,
        n_planes: 1,
        n_lights: usize::from(class == SceneClass::Lit),
        scene: Arc::default(),
    }
}

/// Returns the report.
pub fn report() -> Report {
    let (mut classes, mut rays) = (Vec::new(), Vec::new());
    for (class, scenes) in [(SceneClass::Lecture, 3), (SceneClass::Hard, 5)] {
        classes.extend(each().map(|(kernel, of)| {
            let hardness = if class == SceneClass::Hard { 0.9 } else { 0.1 };
            let ns_per_ray = ns_per_ray(kernel, &of, 5.0);
            ClassRow { class, scenes, errors: errors(kernel, hardness), ns_per_ray, of }
        }));
    }
    for (i, (name, class)) in SCENES.into_iter().enumerate() {
        rays.extend(each().map(|(kernel, of)| SceneRow {
            scene: name.into(),
            class,
            errors: errors(kernel, 0.1 + 0.1 * i as f64),
            decided: StageCounts { f32: 920_788, f64: 800, exact: 12 },
            ns_per_ray: ns_per_ray(kernel, &of, i as f64 + 3.0),
            of,
        }));
    }
    let distances = (0..9).map(|i| (10f64.powi(i), f64::from(i) / 8.0));
    let distance = distances.flat_map(|(distance, hardness)| {
        let row =
            move |(kernel, of)| DistanceRow { distance, of, errors: errors(kernel, hardness) };
        each().map(row)
    });
    let spheres = [1, 64, 1_000_000].into_iter().flat_map(|spheres: u64| {
        let takes_part = move |of: &(usize, KernelOnDevice)| spheres < 1000 || of.0 == 3;
        each().filter(takes_part).map(move |(kernel, of)| SpheresRow {
            spheres,
            ns_per_ray: ns_per_ray(kernel, &of, (spheres as f64).sqrt()),
            build_ms: times(if kernel == 3 { 5e-4 * spheres as f64 } else { 0.0 }),
            of,
        })
    });
    let plain = KERNELS[..3].iter().flat_map(|kernel| [0.0, 1e-3].map(|e| (*kernel, Some(e))));
    let shadow = |(kernel, epsilon): (&'static str, Option<f64>)| ShadowRow {
        scene: "contacts".into(),
        kernel,
        epsilon,
        pixels: 8192,
        shadow_rays: 8192,
        false_shadows: if epsilon == Some(0.0) { 2000 } else { 0 },
        leaks: if epsilon == Some(1e-3) { 3 } else { 0 },
        wrong_pixels: if epsilon.is_some() { 1800 } else { 0 },
    };
    Report {
        environment: environment(),
        settings: Settings::default(),
        scenes: SCENES.into_iter().chain([("contacts", SceneClass::Lit)]).map(scene).collect(),
        classes,
        rays,
        distance: distance.collect(),
        spheres: spheres.collect(),
        shadows: plain.chain([("certified", None)]).map(shadow).collect(),
        missing: vec![Unmeasured { what: "another GPU".into(), why: "no driver".into() }],
    }
}
