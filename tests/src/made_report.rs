//! A report with made-up but likely figures, for what shows reports.

use std::sync::Arc;

use kugelblitz::gpu::{AdapterFacts, Arithmetic};
use kugelblitz_judge::compare::{FALSE_HIT, FALSE_MISS, RAMP, WRONG_OBJECT};
use kugelblitz_report::{
    AdapterArithmetic, Baseline, Class, Count, Earlier, Environment, ErrorPicture, Metric, Missing,
    Noise, Of, Report, ReportScene, Row, RowKey, Settings, Spread,
};

pub const KERNELS: [&str; 4] = ["lecture", "stable", "double", "certified"];
pub const DEVICES: [&str; 2] = ["llvmpipe (LLVM 15.0.6, 256 bits)", "CPU"];
const PICTURE: [u32; 2] = [240, 135];

const SCENES: [(&str, Class); 8] = [
    ("figure1", Class::Lecture),
    ("figure2", Class::Lecture),
    ("inside", Class::Lecture),
    ("huge_ground", Class::Hard),
    ("grazing", Class::Hard),
    ("far_away", Class::Hard),
    ("glancing_plane", Class::Hard),
    ("mirror_twins", Class::Hard),
];
const LIT_SCENES: [&str; 2] = ["contacts_on_ball", "shells"];

pub fn row(of: Of, kernel: &str, device: &str) -> Row {
    let key = RowKey { of, kernel: kernel.into(), device: device.into(), epsilon: None };
    Row { key, numbers: Default::default(), counts: Default::default() }
}

/// Times of 15 runs, of which the slowest took a fifth longer than the median.
fn times(median: f64) -> Spread {
    let max = 1.2 * median;
    Spread { median, p999: max, min: 0.95 * median, max, n: 15 }
}

/// A median with what is typical beside it.
fn errors(median: f64) -> Spread {
    Spread { median, p999: 40.0 * median, min: 0.0, max: 900.0 * median, n: 60_000 }
}

/// Puts in the errors of a row's kernel in a scene that is so hard, from 0 to 1: the same on each device.
fn add_errors(row: &mut Row, hardness: f64) {
    let (wrong, ulp, [f64, exact]) = match row.key.kernel.as_str() {
        "lecture" => (26_000.0 * hardness.powi(3), 0.6 * 10f64.powf(6.0 * hardness), [0, 0]),
        "stable" => (1300.0 * hardness.powi(6), 0.5 * 10f64.powf(hardness), [0, 0]),
        "double" => (if hardness > 0.7 { 2.0 } else { 0.0 }, 0.26, [921_600, 0]),
        _ => (0.0, 0.25, [800, 12]),
    };
    let wrong = wrong as u64;
    row.counts.extend([
        (Count::Rays, 1 << 16),
        (Count::FalseHits, wrong / 5),
        (Count::FalseMisses, wrong / 2),
        (Count::WrongObject, wrong - wrong / 5 - wrong / 2),
        (Count::F32, 921_600 - f64 - exact),
        (Count::F64, f64),
        (Count::Exact, exact),
    ]);
    row.numbers.extend([
        (Metric::TUlp, errors(ulp)),
        (Metric::TRelative, errors(6e-8 * ulp)),
        (Metric::NormalDegrees, errors(3.4e-6 * ulp)),
    ]);
}

/// The time of a row's kernel on its device among so many objects.
fn ns_per_ray(row: &Row, n_objects: usize) -> f64 {
    let kernel = KERNELS.iter().position(|kernel| *kernel == row.key.kernel).unwrap_or(0);
    let device_factor = if row.key.device == "CPU" { 2.6 } else { 1.0 };
    2.1 * [1.0, 1.22, 2.4, 1.34][kernel] * device_factor * n_objects as f64
}

/// A row of each kernel on each device.
fn each_config(of: &Of) -> impl Iterator<Item = Row> {
    DEVICES.iter().flat_map(move |device| KERNELS.map(|kernel| row(of.clone(), kernel, device)))
}

/// The scenes' rows, and those of their classes.
pub fn with_classes(scenes: Vec<Row>) -> Vec<Row> {
    let mut rows = scenes.clone();
    for class in [Class::Lecture, Class::Hard, Class::Given] {
        for mut result in each_config(&Of::Class { class }) {
            let is_own = |row: &&Row| {
                matches!(row.key.of, Of::Scene { class: own, .. } if own == class)
                    && RowKey { of: row.key.of.clone(), ..result.key.clone() } == row.key
            };
            let own: Vec<&Row> = scenes.iter().filter(is_own).collect();
            let Some(model) = own.first() else { continue };
            result.numbers = model.numbers.clone();
            for row in &own {
                for (&count, n) in &row.counts {
                    *result.counts.entry(count).or_default() += n;
                }
            }
            result.counts.insert(Count::Scenes, own.len() as u64);
            rows.push(result);
        }
    }
    rows
}

fn scene_rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (i, (scene, class)) in SCENES.into_iter().enumerate() {
        let hardness = if class == Class::Lecture { 0.1 } else { 0.2 + 0.1 * i as f64 };
        for mut row in each_config(&Of::Scene { scene: scene.into(), class }) {
            add_errors(&mut row, hardness);
            let ns = ns_per_ray(&row, i + 3);
            row.numbers.extend([
                (Metric::TraceNsPerRay, times(ns)),
                (Metric::SurfaceNsPerRay, times(1.6 * ns)),
                (Metric::ReadbackMs, times(0.7)),
                (Metric::CompileMs, times(48.0)),
                (Metric::FirstPictureMs, times(31.0)),
            ]);
            if row.key.device != "CPU" {
                row.numbers.insert(Metric::DeviceNsPerRay, times(0.9 * ns));
            }
            row.counts.insert(Count::BytesDevice, 3_686_400 + 64 * i as u64);
            rows.push(row);
        }
    }
    rows
}

fn sweep_rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (sweep, i) in
        ["distance", "offset", "objects"].into_iter().flat_map(|s| (0..9).map(move |i| (s, i)))
    {
        let is_timed = sweep == "objects";
        let x = if is_timed { f64::from(1 << i) } else { 10f64.powi(i) };
        for mut row in each_config(&Of::Sweep { sweep: sweep.into(), x }) {
            if is_timed {
                let ns = ns_per_ray(&row, (1 << i) + 2);
                row.numbers.insert(Metric::TraceNsPerRay, times(ns));
            } else {
                add_errors(&mut row, f64::from(i) / 8.0);
            }
            rows.push(row);
        }
    }
    rows
}

fn cloud_rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (spheres, device) in
        [10_000, 100_000, 1_000_000].into_iter().flat_map(|n| DEVICES.map(|d| (n, d)))
    {
        let mut row = row(Of::Cloud { spheres }, "certified", device);
        add_errors(&mut row, 0.1);
        row.counts.insert(Count::Rays, 1024);
        row.numbers.insert(Metric::BuildMs, times(5e-4 * spheres as f64));
        row.numbers.insert(Metric::PictureMs, times(0.05 * (spheres as f64).sqrt()));
        rows.push(row);
    }
    rows
}

/// A row a kernel and epsilon.
fn light_rows(scene: &str, n_lights: u64) -> Vec<Row> {
    let plain = ["lecture", "stable", "double"];
    let plain = plain.iter().flat_map(|&kernel| [0.0, 1e-4, 1e-3].map(|e| (kernel, Some(e))));
    let of = |(kernel, epsilon): (&str, Option<f64>)| {
        let mut row = row(Of::Light { scene: scene.into() }, kernel, DEVICES[0]);
        row.key.epsilon = epsilon;
        let acne = match epsilon {
            Some(0.0) => 2000,
            Some(_) => 3,
            None => 0,
        };
        row.counts.extend([
            (Count::Pixels, 8192),
            (Count::Verdicts, 8192 * n_lights),
            (Count::FalseShadows, acne),
            (Count::Leaks, 2 * u64::from(epsilon == Some(1e-3))),
            (Count::WrongBytes, acne * 9 / 8),
            (Count::FarBytes, acne / 2),
        ]);
        row
    };
    plain.chain([("certified", None)]).map(of).collect()
}

/// A picture of what a row is of, in which these colours of errors take turns.
pub fn picture(
    key: &RowKey,
    size: [u32; 2],
    errors: &[[u8; 3]],
    verdict: [&str; 2],
) -> ErrorPicture {
    let n_pixels = (size[0] * size[1]) as usize;
    ErrorPicture {
        key: key.clone(),
        srgb: (0..n_pixels).map(|i| [i, 2 * i, 3 * i].map(|n| n as u8)).collect(),
        errors: errors.iter().copied().cycle().take(n_pixels).collect(),
        verdict: verdict.map(String::from),
    }
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
        command: "kugelblitz report --html report.html".into(),
        system: "Debian GNU/Linux 12".into(),
        host_cpu: "A CPU @ 2.60GHz".into(),
        n_cores: 2,
        adapters: vec![AdapterArithmetic { facts, arithmetic_f32: arithmetic, arithmetic_f64 }],
    }
}

/// The report.
pub fn report() -> Report {
    let mut rows = with_classes(scene_rows());
    rows.extend([sweep_rows(), cloud_rows()].concat());
    rows.extend(
        LIT_SCENES.iter().zip([1, 2]).flat_map(|(scene, n_lights)| light_rows(scene, n_lights)),
    );
    let lit = LIT_SCENES.map(|name| (name, Class::Lit));
    let scene = |(name, class): (&str, Class)| ReportScene {
        name: name.into(),
        class,
        about: format!("What {name} shows, in the words of its first comment."),
        n_spheres: 3,
        n_planes: 1,
        n_lights: usize::from(class == Class::Lit),
        scene: Arc::default(),
    };
    let of_errors = |key| {
        let colors = [RAMP[0], FALSE_HIT, FALSE_MISS, WRONG_OBJECT, RAMP[1]];
        picture(key, PICTURE, &colors, ["19440 wrong pixels (60 %)", "t up to 9.00 ulp off"])
    };
    let of_shadows = |key| {
        let colors = [RAMP[0], FALSE_HIT, WRONG_OBJECT, RAMP[1]];
        let verdict = ["16200 wrong shadows (50 %)", "8100 other wrong pixels (25 %)"];
        picture(key, PICTURE, &colors, verdict)
    };
    let of_light =
        |row: &&Row| matches!(&row.key.of, Of::Light { scene } if scene == LIT_SCENES[0]);
    let first = rows[..4].iter().map(|row| of_errors(&row.key));
    let lit_pictures = rows.iter().filter(of_light);
    let pictures = first.chain(lit_pictures.map(|row| of_shadows(&row.key))).collect();
    Report {
        environment: environment(),
        settings: Settings { picture_size: PICTURE, ..Settings::default() },
        scenes: SCENES.into_iter().chain(lit).map(scene).collect(),
        rows,
        missing: vec![Missing { what: "pbrt 4".into(), why: "`pbrt` is not installed".into() }],
        noise: Noise { times: 160, wide: 12, typical_range: 0.19 },
        baseline: None,
        pictures,
    }
}

/// The report with a baseline, which is the same before a change, and `factor` times as slow in its first row.
pub fn since(factor: f64, change: impl FnOnce(&mut serde_json::Value)) -> Report {
    let mut report = report();
    let mut earlier = serde_json::to_value(&report).unwrap();
    (earlier["schema"], earlier["command"]) = (2.into(), "report".into());
    let time = &mut earlier["rows"][0]["numbers"]["trace_ns_per_ray"];
    for part in ["median", "min", "max"] {
        time[part] = (factor * time[part].as_f64().unwrap()).into();
    }
    let wrong = &mut earlier["rows"][2]["counts"]["wrong_object"];
    *wrong = (wrong.as_u64().unwrap() + 5).into();
    change(&mut earlier);
    let earlier = Earlier::parse(&earlier.to_string(), &report.settings).unwrap();
    report.baseline = Some(Baseline::new("before.json".into(), &earlier, &report));
    report
}

/// The report with a baseline and its noise.
pub fn whole_report() -> Report {
    let mut report = since(3.0, |earlier| {
        earlier["environment"]["host_cpu"] = "Another CPU".into();
    });
    report.noise = Noise { times: 160, wide: 90, typical_range: 0.41 };
    report
}
