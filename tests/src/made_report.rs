//! A report with made-up but likely figures, for what shows reports.

use kugelblitz::gpu::{AdapterFacts, Arithmetic};
use kugelblitz::report::{
    AdapterEvidence, Baseline, Class, ClassResult, CloudResult, Contestant, Cost, Distribution,
    Earlier, Effort, ErrorPicture, Errors, Evidence, Fault, LightErrors, LightFault, LightPicture,
    LightResult, LightRow, Missing, Noise, Report, Row, SceneResult, Series, Spread, Sweep,
    SweepPoint,
};
use kugelblitz::trace::StageCounts;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const KERNELS: [&str; 4] = ["lecture", "stable", "double", "certified"];
pub const DEVICES: [&str; 2] = ["llvmpipe (LLVM 15.0.6, 256 bits)", "CPU"];
const SAMPLES: u64 = 1 << 16;
const PICTURE: [u32; 2] = [240, 135];

const LECTURE_SCENES: [&str; 6] = ["figure1", "figure2", "figure3", "figure4", "figure5", "inside"];
const HARD_SCENES: [&str; 14] = [
    "tiny",
    "moved",
    "huge_ground",
    "grazing",
    "tangent_row",
    "far_away",
    "thin_shell",
    "dust",
    "nested",
    "horizon",
    "coplanar",
    "glancing_plane",
    "mirror_twins",
    "deep_field",
];

fn contestant(kernel: &str, device: &str) -> Contestant {
    Contestant { kernel: kernel.into(), device: device.into() }
}

fn spread(rng: &mut ChaCha8Rng, median: f64) -> Spread {
    let min = median * rng.random_range(0.90..0.99);
    Spread { median, min, max: median * rng.random_range(1.02..1.4), n: 15 }
}

fn distribution(median: f64, n: u64) -> Option<Distribution> {
    Some(Distribution { median, p999: 40.0 * median, max: 900.0 * median, n: n as usize })
}

/// The errors of a kernel in a scene that is so hard, from 0 to 1: the same on each device.
fn errors(kernel: &str, hardness: f64, seed: u64) -> Errors {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let share = match kernel {
        "lecture" => 0.4 * hardness.powi(3) * rng.random_range(0.5..1.0),
        "stable" => 0.02 * hardness.powi(6) * rng.random_range(0.3..1.0),
        "double" if hardness > 0.7 => 2.0 / SAMPLES as f64,
        _ => 0.0,
    };
    let wrong = (share * SAMPLES as f64) as u64;
    let (false_hits, false_misses) = (wrong / 5, wrong / 2);
    let right = SAMPLES - wrong;
    let ulp = match kernel {
        "lecture" => 0.6 * 10f64.powf(6.0 * hardness),
        "stable" => 0.5 * 10f64.powf(hardness),
        "double" => 0.26,
        _ => 0.25,
    };
    let is_exact = matches!(kernel, "double" | "certified");
    let of_t = if is_exact {
        Some(Distribution { median: ulp, p999: 0.4995, max: 0.5, n: right as usize })
    } else {
        distribution(ulp, right)
    };
    let stages = match kernel {
        "certified" => StageCounts { f32: 921_600 - 812, f64: 800, exact: 12 },
        "double" => StageCounts { f32: 0, f64: 921_600, exact: 0 },
        _ => StageCounts { f32: 921_600, f64: 0, exact: 0 },
    };
    Errors {
        rays: SAMPLES,
        false_hits,
        false_misses,
        wrong_object: wrong - false_hits - false_misses,
        t_ulp: of_t,
        t_relative: distribution(6e-8 * ulp, right),
        normal_degrees: distribution(3.4e-6 * ulp, right),
        stages,
    }
}

fn cost(rng: &mut ChaCha8Rng, kernel: &str, device: &str, n_objects: usize) -> Cost {
    let kernel_factor = match kernel {
        "lecture" => 1.0,
        "stable" => 1.22,
        "double" => 2.4,
        _ => 1.34,
    };
    let device_factor = if device == "CPU" { 2.6 } else { 1.0 };
    let ns = 2.1 * kernel_factor * device_factor * n_objects as f64 * rng.random_range(0.85..1.15);
    Cost {
        n_rays: 921_600,
        trace_ns_per_ray: spread(rng, ns),
        surface_ns_per_ray: spread(rng, 1.6 * ns),
        device_ns_per_ray: (device != "CPU").then(|| spread(rng, 0.9 * ns)),
        readback_ms: spread(rng, 0.7),
        compile_ms: spread(rng, 48.0),
        first_picture_ms: spread(rng, 31.0),
        bytes_device: 3_686_400 + 64 * n_objects as u64,
    }
}

fn scene(rng: &mut ChaCha8Rng, name: &str, class: Class, seed: u64) -> SceneResult {
    let hardness = match class {
        Class::Lecture => rng.random_range(0.0..0.2),
        _ => rng.random_range(0.1..1.0),
    };
    let n_spheres = rng.random_range(3..24);
    let rows = DEVICES
        .iter()
        .flat_map(|device| KERNELS.map(|kernel| (kernel, *device)))
        .map(|(kernel, device)| Row {
            contestant: contestant(kernel, device),
            errors: errors(kernel, hardness, seed),
            cost: cost(rng, kernel, device, n_spheres + 1),
        })
        .collect();
    SceneResult {
        name: name.into(),
        class,
        about: format!("What {name} shows, in the words of its first comment."),
        n_spheres,
        n_planes: 1,
        rows,
    }
}

/// Puts the scenes of each class together.
pub fn classes(scenes: &[SceneResult]) -> Vec<ClassResult> {
    let mut results = Vec::new();
    for class in [Class::Lecture, Class::Hard, Class::Given] {
        for (kernel, device) in DEVICES.iter().flat_map(|d| KERNELS.map(|k| (k, *d))) {
            let contestant = contestant(kernel, device);
            let rows: Vec<&Row> = scenes
                .iter()
                .filter(|scene| scene.class == class)
                .flat_map(|scene| &scene.rows)
                .filter(|row| row.contestant == contestant)
                .collect();
            if rows.is_empty() {
                continue;
            }
            let mut errors = rows[0].errors.clone();
            for row in &rows[1..] {
                errors.rays += row.errors.rays;
                errors.false_hits += row.errors.false_hits;
                errors.false_misses += row.errors.false_misses;
                errors.wrong_object += row.errors.wrong_object;
                errors.stages.add(row.errors.stages);
            }
            let mean = |time: fn(&Cost) -> Spread| {
                let mean = |of: fn(&Spread) -> f64| {
                    let sum: f64 = rows.iter().map(|row| of(&time(&row.cost)).ln()).sum();
                    (sum / rows.len() as f64).exp()
                };
                Spread {
                    median: mean(|spread| spread.median),
                    min: mean(|spread| spread.min),
                    max: mean(|spread| spread.max),
                    n: 15 * rows.len(),
                }
            };
            results.push(ClassResult {
                class,
                n_scenes: rows.len(),
                contestant,
                errors,
                trace_ns_per_ray: mean(|cost| cost.trace_ns_per_ray),
                surface_ns_per_ray: mean(|cost| cost.surface_ns_per_ray),
            });
        }
    }
    results
}

fn error_sweep(name: &'static str, title: &'static str, x_label: &'static str) -> Sweep {
    let series = |kernel: &str, device: &str| Series {
        contestant: contestant(kernel, device),
        points: (0..9)
            .map(|i| SweepPoint {
                x: 10f64.powi(i),
                errors: Some(errors(kernel, f64::from(i) / 8.0, i as u64)),
                trace_ns_per_ray: None,
            })
            .collect(),
    };
    let series =
        DEVICES.iter().flat_map(|d| KERNELS.map(|k| (k, *d))).map(|(k, d)| series(k, d)).collect();
    Sweep { name, title, x_label, series }
}

fn time_sweep(rng: &mut ChaCha8Rng) -> Sweep {
    let mut series = Vec::new();
    for (kernel, device) in DEVICES.iter().flat_map(|d| KERNELS.map(|k| (k, *d))) {
        let points = (0..9)
            .map(|i| SweepPoint {
                x: f64::from(1 << i),
                errors: None,
                trace_ns_per_ray: Some(cost(rng, kernel, device, (1 << i) + 2).trace_ns_per_ray),
            })
            .collect();
        series.push(Series { contestant: contestant(kernel, device), points });
    }
    Sweep {
        name: "objects",
        title: "The time of a ray grows with the number of spheres.",
        x_label: "spheres in the scene",
        series,
    }
}

fn picture(scene: &str, kernel: &str, device: &str) -> ErrorPicture {
    let [width, height] = PICTURE;
    let mut srgb = Vec::new();
    let mut faults = Vec::new();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for i in 0..width * height {
        let (x, y) = (f64::from(i % width) - 110.0, f64::from(i / width) - 60.0);
        let r = (x * x + y * y).sqrt() / 48.0;
        let is_ground = y > 30.0;
        let edge = if kernel == "lecture" { 0.12 } else { 0.02 };
        let bad = rng.random_bool(0.5) && !matches!(kernel, "certified" | "double");
        srgb.push(if r < 1.0 {
            [0xd6, 0x27, 0x28]
        } else if is_ground {
            [0x8c, 0x8c, 0x8c]
        } else {
            [0x20, 0x24, 0x2c]
        });
        faults.push(if (r - 1.0).abs() < edge && bad {
            match (r < 1.0, is_ground) {
                (_, true) => Fault::WrongObject,
                (true, _) => Fault::FalseMiss,
                (false, _) => Fault::FalseHit,
            }
        } else if r < 1.0 || is_ground {
            let grow = if kernel == "lecture" { 5.0 } else { 1.0 };
            match kernel {
                "certified" | "double" => Fault::Right { t_ulp: 0.5 * rng.random::<f64>() },
                _ => Fault::Right { t_ulp: 0.5 * 10f64.powf(grow * r.min(1.2)) },
            }
        } else {
            Fault::Background
        });
    }
    ErrorPicture {
        scene: scene.into(),
        contestant: contestant(kernel, device),
        width,
        height,
        srgb,
        faults,
    }
}

fn evidence() -> Evidence {
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
    Evidence {
        version: "0.1.0".into(),
        commit: Some("9fc4bae1c0de".into()),
        date: "2026-11-21T07:00:00Z".into(),
        command: "kugelblitz report --html report.html".into(),
        system: "Debian GNU/Linux 12".into(),
        host_cpu: "A CPU @ 2.60GHz".into(),
        n_cores: 2,
        adapters: vec![AdapterEvidence {
            facts,
            arithmetic_f32: arithmetic,
            arithmetic_f64: Some(arithmetic),
        }],
    }
}

fn cloud(rng: &mut ChaCha8Rng, n_spheres: u64, device: &str) -> CloudResult {
    let ms = 0.05 * (n_spheres as f64).sqrt() * if device == "CPU" { 1.0 } else { 4.0 };
    let stages = StageCounts { f32: 2_073_600 - 3000, f64: 2990, exact: 10 };
    CloudResult {
        n_spheres,
        contestant: contestant("certified", device),
        errors: Errors { rays: 1024, stages, ..errors("certified", 0.1, n_spheres) },
        build_ms: spread(rng, 5e-4 * n_spheres as f64),
        picture_ms: spread(rng, ms),
    }
}

/// One row of light a kernel and epsilon.
fn light(scene: &str, n_lights: usize) -> LightResult {
    let row = |(kernel, epsilon): (&str, Option<f64>)| {
        let acne = match epsilon {
            Some(0.0) => 2000,
            Some(_) => 3,
            None => 0,
        };
        let errors = LightErrors {
            pixels: 8192,
            verdicts: 8192 * n_lights as u64,
            false_shadows: acne,
            leaks: 2 * u64::from(epsilon == Some(1e-3)),
            wrong_bytes: acne * 9 / 8,
            far_bytes: acne / 2,
        };
        LightRow { contestant: contestant(kernel, DEVICES[0]), epsilon, errors }
    };
    let plain = ["lecture", "stable", "double"];
    let plain = plain.iter().flat_map(|&kernel| [0.0, 1e-4, 1e-3].map(|e| (kernel, Some(e))));
    LightResult {
        scene: scene.into(),
        about: format!("What {scene} shows, in the words of its first comment."),
        n_lights,
        rows: plain.chain([("certified", None)]).map(row).collect(),
    }
}

fn light_picture(scene: &str, kernel: &str, epsilon: Option<f64>) -> LightPicture {
    let [width, height] = PICTURE;
    let n_pixels = (width * height) as usize;
    let fault = |i: usize| match (epsilon, i % 7) {
        (Some(_), 0) => LightFault::FalseShadow,
        (Some(_), 1) => LightFault::Leak,
        (Some(_), 2) => LightFault::Bytes { levels: (i % 256) as u8 },
        _ => LightFault::Right,
    };
    LightPicture {
        scene: scene.into(),
        contestant: contestant(kernel, DEVICES[0]),
        epsilon,
        width,
        height,
        srgb: vec![[0x8c, 0x30, 0x20]; n_pixels],
        faults: (0..n_pixels).map(fault).collect(),
    }
}

/// The report.
pub fn report() -> Report {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let sorted = LECTURE_SCENES.map(|name| (name, Class::Lecture));
    let hard = HARD_SCENES.map(|name| (name, Class::Hard));
    let scenes: Vec<SceneResult> = sorted
        .into_iter()
        .chain(hard)
        .enumerate()
        .map(|(i, (name, class))| scene(&mut rng, name, class, i as u64))
        .collect();
    let sweeps = vec![
        error_sweep("distance", "Figure 2, moved away from the origin.", "distance, units"),
        error_sweep("offset", "Rays that pass ever closer by a silhouette.", "closeness"),
        time_sweep(&mut rng),
    ];
    let clouds = [10_000, 100_000, 1_000_000];
    let clouds = clouds.into_iter().flat_map(|n| DEVICES.map(|device| (n, device)));
    let clouds = clouds.map(|(n, device)| cloud(&mut rng, n, device)).collect();
    let pictures = [("figure2", DEVICES[1]), ("moved", DEVICES[0]), ("moved", DEVICES[1])];
    let pictures = pictures
        .into_iter()
        .flat_map(|(scene, device)| KERNELS.map(|kernel| picture(scene, kernel, device)))
        .collect();
    Report {
        evidence: evidence(),
        effort: Effort {
            size: [1280, 720],
            samples: SAMPLES as usize,
            seed: 1,
            rounds: 3,
            runs: 5,
            picture_size: PICTURE,
            sweeps: true,
            clouds: vec![10_000, 100_000, 1_000_000],
        },
        classes: classes(&scenes),
        scenes,
        sweeps,
        clouds,
        light: vec![light("contacts_on_ball", 1), light("shells", 2)],
        missing: vec![Missing { what: "pbrt 4".into(), why: "`pbrt` is not installed".into() }],
        noise: Noise { times: 160, wide: 12, typical_range: 0.19 },
        baseline: None,
        pictures,
        light_pictures: vec![
            light_picture("contacts_on_ball", "certified", None),
            light_picture("contacts_on_ball", "stable", Some(1e-3)),
        ],
    }
}

/// The report with a baseline and its noise.
pub fn whole_report() -> Report {
    let mut report = report();
    let mut earlier = serde_json::to_value(&report).unwrap();
    (earlier["schema"], earlier["command"]) = (1.into(), "report".into());
    let errors = &mut earlier["scenes"][0]["rows"][0]["errors"];
    errors["wrong_object"] = (errors["wrong_object"].as_u64().unwrap() + 5).into();
    let cost = &mut earlier["scenes"][0]["rows"][0]["cost"]["trace_ns_per_ray"];
    for part in ["median", "min", "max"] {
        cost[part] = (3.0 * cost[part].as_f64().unwrap()).into();
    }
    earlier["evidence"]["host_cpu"] = "Another CPU".into();
    let earlier = Earlier::parse(&earlier.to_string()).unwrap();
    report.baseline = Some(Baseline::new("before.json".into(), &earlier, &report));
    report.noise = Noise { times: 160, wide: 90, typical_range: 0.41 };
    report
}
