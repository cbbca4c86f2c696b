//! The report's measuring: it repeats itself, and it sees a kernel that is wrong.

use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::scene::parse_scene;
use kugelblitz::trace::Kernel;
use kugelblitz_judge::compare::{FALSE_HIT, FALSE_MISS, RAMP, WRONG_OBJECT};
use kugelblitz_report::{
    Benchmark, CLOUD_SIZE, Class, Count, Environment, Metric, Of, Report, ReportScene, Row, RowKey,
    SWEEPS, Settings, Work, default_cases,
};

const SETTINGS: Settings = Settings {
    size: [96, 54],
    samples: 4000,
    seed: 7,
    rounds: 2,
    runs: 2,
    picture_size: [32, 18],
    sweeps: false,
    clouds: Vec::new(),
};

fn cases(names: &[&str]) -> Vec<ReportScene> {
    let all = default_cases().unwrap();
    let named: Vec<_> =
        all.into_iter().filter(|case| names.contains(&case.name.as_str())).collect();
    assert_eq!(named.len(), names.len());
    named
}

/// The report, and how many rays were announced and how many traced, lit or compared.
fn measure(
    cases: &[ReportScene],
    benchmarks: &[Benchmark],
    settings: &Settings,
) -> (Report, [u64; 2]) {
    let environment = Environment::collect("kugelblitz report".into(), None, Vec::new());
    let control = Control::default();
    let work = Work { cases, benchmarks, settings, control: &control };
    let report = work.measure(environment).unwrap();
    (report, [work.n_rays(), control.rays_done()])
}

const KERNELS: [Kernel; 3] = [Kernel::Lecture, Kernel::Stable, Kernel::Certified];

/// What was counted in each row, and its errors.
fn all_errors(report: &Report) -> Vec<Row> {
    let is_error =
        |metric: &Metric| [Metric::TUlp, Metric::TRelative, Metric::NormalDegrees].contains(metric);
    let mut rows = report.rows.clone();
    rows.iter_mut().for_each(|row| row.numbers.retain(|metric, _| is_error(metric)));
    rows
}

fn all_rays(row: &Row) -> u64 {
    [Count::F32, Count::F64, Count::Exact].map(|stage| row.count(stage)).iter().sum()
}

#[test]
fn errors_repeat_exactly_and_times_have_their_range() {
    let gpu = Device::Gpu(kugelblitz_tests::gpu());
    let devices = [gpu, Device::Cpu];
    let benchmarks: Vec<_> = devices
        .iter()
        .flat_map(|device| KERNELS.map(|kernel| Benchmark { kernel, device: device.clone() }))
        .collect();
    let cases = cases(&["figure2", "far_1e8"]);
    let settings = Settings { sweeps: true, rounds: 1, clouds: vec![3000], ..SETTINGS };
    let (first, [announced, done]) = measure(&cases, &benchmarks, &settings);
    let (second, _) = measure(&cases, &benchmarks, &settings);
    assert_eq!(all_errors(&first), all_errors(&second));
    for (i, row) in first.rows.iter().enumerate() {
        assert!(first.rows[..i].iter().all(|other| other.key != row.key), "{row:?}");
    }

    // Of the worst scenes: here the one in which a kernel is wrong.
    let n = benchmarks.len();
    let pictured = (n as u64 / 2 + 1) * 32 * 18;
    assert_eq!(done, announced + pictured);
    let of = |is: fn(&Of) -> bool| -> Vec<&Row> {
        first.rows.iter().filter(|row| is(&row.key.of)).collect()
    };
    let scenes = of(|of| matches!(of, Of::Scene { .. }));
    assert_eq!((first.scenes.len(), scenes.len()), (2, 2 * n));
    for row in &scenes {
        assert_eq!((row.count(Count::Rays), all_rays(row)), (4000, 96 * 54));
        let time = row.number(Metric::TraceNsPerRay).expect("a time");
        assert!(time.n == 2 && 0.0 < time.min && time.min <= time.median, "{time:?}");
        assert!(time.median <= time.max, "{time:?}");
        assert!(row.count(Count::BytesDevice) > 0);
        if row.key.kernel == "certified" {
            assert_eq!(row.wrong_ids(), 0);
            assert!(row.number(Metric::TUlp).is_some_and(|t| t.max <= 0.5));
        }
    }
    // Far from the origin, the plain formulas must fail, or nothing was compared.
    let is_far = |row: &&&Row| matches!(&row.key.of, Of::Scene { scene, .. } if scene == "far_1e8");
    let lecture = scenes.iter().find(is_far).expect("a row");
    assert!(lecture.wrong_share() > 0.05, "{lecture:?}");
    let [false_hits, false_misses] =
        [Count::FalseHits, Count::FalseMisses].map(|of| lecture.count(of));
    assert!(false_hits > 0 && false_misses > 0, "{lecture:?}");
    let picture =
        first.pictures.iter().find(|picture| picture.key == lecture.key).expect("a picture");
    for color in [FALSE_HIT, FALSE_MISS, WRONG_OBJECT] {
        assert!(picture.errors.contains(&color), "{color:?}");
    }
    assert_eq!(of(|of| matches!(of, Of::Class { .. })).len(), 2 * n);
    // With certified alone, on each device.
    let clouds = of(|of| matches!(of, Of::Cloud { spheres: 3000 }));
    assert_eq!(clouds.len(), 2);
    for cloud in clouds {
        assert_eq!(cloud.key.kernel, "certified");
        assert_eq!((cloud.count(Count::Rays), cloud.wrong_ids()), (1024, 0), "{cloud:?}");
        assert!(cloud.number(Metric::TUlp).is_some_and(|t| t.n > 100 && t.max <= 0.5), "{cloud:?}");
        let [width, height] = CLOUD_SIZE.map(u64::from);
        assert_eq!(all_rays(cloud), width * height);
        assert!(cloud.count(Count::F64) + cloud.count(Count::Exact) > 0, "{cloud:?}");
        let [build, picture] =
            [Metric::BuildMs, Metric::PictureMs].map(|m| cloud.number(m).unwrap());
        assert!(
            build.n == 1 && build.min > 0.0 && picture.n == 2 && picture.min > 0.0,
            "{cloud:?}"
        );
    }
    for (swept, n_points) in SWEEPS.iter().zip([12, 11, 5]) {
        for benchmark in &benchmarks {
            let is_own = |row: &&Row| {
                matches!(&row.key.of, Of::Sweep { sweep, .. } if sweep == swept.name)
                    && row.key == benchmark.key(row.key.of.clone())
            };
            // Clouds with certified alone.
            let has_clouds = swept.name == "objects" && benchmark.kernel == Kernel::Certified;
            let n_rows = first.rows.iter().filter(is_own).count();
            assert_eq!(n_rows, n_points + usize::from(has_clouds), "{}", swept.name);
        }
    }
}

/// The light of a kernel with an epsilon in the only scene of a report: what is wrong of so many.
fn light(report: &Report, kernel: &str, epsilon: Option<f64>) -> [u64; 4] {
    let mut rows = report.rows.iter().filter(|row| matches!(row.key.of, Of::Light { .. }));
    let is_own = |row: &&Row| (row.key.kernel.as_str(), row.key.epsilon) == (kernel, epsilon);
    let row = rows.find(is_own).unwrap_or_else(|| panic!("{kernel}, {epsilon:?}"));
    assert_eq!([row.count(Count::Pixels), row.count(Count::Verdicts)], [4000; 2]);
    [Count::FalseShadows, Count::Leaks, Count::WrongBytes, Count::FarBytes].map(|of| row.count(of))
}

/// Without an epsilon, and with one that is too small, surfaces shadow themselves; with one that is too
/// large, light leaks in. What is proven needs none.
#[test]
fn acne_leaks_and_neither_of_them_show() {
    let benchmarks = Kernel::ALL.map(|kernel| Benchmark { kernel, device: Device::Cpu });
    let cases = cases(&["contacts_1e-6"]);
    let (report, [announced, done]) = measure(&cases, &benchmarks, &SETTINGS);
    // Its rays are no part of the tables of rays.
    assert_eq!(report.rows.len(), 10);
    // Of certified two pictures, of stable two for each epsilon, each of rays and their light.
    let pictured = 2 * (2 + 6) * 32 * 18;
    assert_eq!(done, announced + pictured);
    let is_much = |n: u64, share: f64| n as f64 > 4000.0 * share;
    for kernel in ["lecture", "stable", "double"] {
        let [none, small, large] = [0.0, 1e-4, 1e-3].map(|e| light(&report, kernel, Some(e)));
        assert!(is_much(none[0], 0.1) && is_much(none[2], 0.1), "{none:?}");
        // The whole scene is smaller than either: all shadows are gone.
        assert!(is_much(small[1], 0.03) && small[1] == large[1], "{small:?}");
        assert!(is_much(small[3], 0.03), "{small:?}");
    }
    assert_eq!(light(&report, "certified", None), [0; 4]);

    let n_pictured = |kernel: &str, epsilon, color| {
        let key = |key: &RowKey| (key.kernel == kernel) && key.epsilon == epsilon;
        let picture = report.pictures.iter().find(|picture| key(&picture.key)).unwrap();
        assert_eq!(picture.errors.len(), 32 * 18);
        picture.errors.iter().filter(|other| **other == color).count()
    };
    assert_eq!(n_pictured("certified", None, RAMP[0]), 32 * 18);
    assert!(n_pictured("stable", Some(0.0), FALSE_HIT) > 50);
    assert!(n_pictured("stable", Some(1e-3), WRONG_OBJECT) > 20);
    let json = serde_json::to_value(&report).unwrap();
    let row = &json["rows"][9];
    assert_eq!((&row["of"], &row["kernel"]), (&"light".into(), &"certified".into()));
    assert!(row["epsilon"].is_null() && row["counts"]["false_shadows"] == 0);
}

/// A given scene with lights is measured both ways.
#[test]
fn given_scenes_with_lights_are_lit() {
    let path = "scenes/lit/hard/terminator.toml";
    let text = kugelblitz_tests::text_of(path);
    let scene = parse_scene(&text, path.as_ref()).unwrap().into();
    let case = ReportScene::new(scene, &text, path.as_ref(), Class::Given).unwrap();
    let benchmarks = [Benchmark { kernel: Kernel::Certified, device: Device::Cpu }];
    let (report, _) = measure(&[case], &benchmarks, &SETTINGS);
    // The scene, its class, its light.
    assert_eq!(report.rows.len(), 3);
    assert_eq!(light(&report, "certified", None)[2], 0);
    // No plain kernel was asked for, so there is nothing to be shown beside it.
    assert!(report.pictures.is_empty());
}
