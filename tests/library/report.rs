//! The measurements of a report: errors are reproducible, and a kernel that is wrong has errors.

use kugelblitz::Control;
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::scene::parse_scene;
use kugelblitz_report::{
    Benchmark, Environment, Report, ReportScene, SceneClass, Settings, ShadowRow, Work,
    default_cases,
};

fn settings() -> Settings {
    Settings {
        size: [96, 54],
        samples: 4000,
        seed: 7,
        rounds: 2,
        runs: 2,
        distances: Vec::new(),
        spheres: Vec::new(),
    }
}

fn cases(names: &[&str]) -> Vec<ReportScene> {
    let mut cases = default_cases().unwrap();
    cases.retain(|case| names.contains(&case.name.as_str()));
    assert_eq!(cases.len(), names.len());
    cases
}

/// Measures a report, and checks that all announced rays were traced or compared.
fn measure(cases: &[ReportScene], benchmarks: &[Benchmark], settings: &Settings) -> Report {
    let environment = Environment::collect("kugelblitz report".into(), None, Vec::new());
    let control = Control::default();
    let work = Work { cases, benchmarks, settings, control: &control };
    let report = work.measure(environment).unwrap();
    assert_eq!(work.n_rays(), control.rays_done());
    report
}

#[test]
fn errors_repeat_exactly_and_times_have_their_range() {
    let kernels = [Kernel::Lecture, Kernel::Stable, Kernel::Certified];
    let devices = [Device::Gpu(kugelblitz_tests::gpu()), Device::Cpu];
    let benchmarks: Vec<Benchmark> = devices
        .iter()
        .flat_map(|device| kernels.map(|kernel| Benchmark { kernel, device: device.clone() }))
        .collect();
    let cases = cases(&["figure2", "far_1e8"]);
    let settings = Settings { distances: vec![10.0, 1e4], spheres: vec![4, 3000], ..settings() };
    let [first, second] = [0, 1].map(|_| measure(&cases, &benchmarks, &settings));
    let errors = |report: &Report| {
        let rays = report.rays.iter().map(|row| (row.of.clone(), row.errors, row.decided));
        let distance = report.distance.iter().map(|row| (row.of.clone(), row.errors));
        (rays.collect::<Vec<_>>(), distance.collect::<Vec<_>>())
    };
    assert_eq!(errors(&first), errors(&second));

    let n = benchmarks.len();
    assert_eq!([first.scenes.len(), first.classes.len(), first.rays.len()], [2, 2 * n, 2 * n]);
    for row in &first.rays {
        assert_eq!((row.errors.compared, row.decided.total()), (4000, 96 * 54), "{row:?}");
        let time = row.ns_per_ray;
        assert!(time.n == 4 && 0.0 < time.min && time.min <= time.median, "{row:?}");
        assert!(time.median <= time.max, "{row:?}");
        if row.of.kernel == "certified" {
            assert_eq!(row.errors.wrong(), 0, "{row:?}");
            assert!(row.errors.t_ulp.is_some_and(|t| t.max <= 0.5), "{row:?}");
        }
    }
    // Far from the origin, the plain formulas must fail, or nothing was compared.
    for row in
        first.rays.iter().filter(|row| (&*row.scene, row.of.kernel) == ("far_1e8", "lecture"))
    {
        assert!(row.errors.false_hits > 0 && row.errors.false_misses > 0, "{row:?}");
        assert!(row.errors.wrong() > row.errors.compared / 20, "{row:?}");
    }
    for class in &first.classes {
        let own = first.rays.iter().find(|row| (row.class, &row.of) == (class.class, &class.of));
        assert_eq!((class.scenes, class.errors), (1, own.unwrap().errors));
    }
    assert_eq!(first.distance.len(), 2 * n);
    for row in &first.distance {
        assert_eq!(row.errors.wrong() == 0, row.of.kernel == "certified", "{row:?}");
    }
    // Only certified takes part with many spheres.
    let of_many = first.spheres.iter().filter(|row| row.spheres == 3000);
    assert!(of_many.clone().all(|row| row.of.kernel == "certified" && row.build_ms.min > 0.0));
    assert_eq!((of_many.count(), first.spheres.len()), (2, n + 2));
}

/// Returns the false shadows, leaks and wrong pixels of a kernel with an epsilon.
fn shadows(report: &Report, kernel: &str, epsilon: Option<f64>) -> [u64; 3] {
    let is_own = |row: &&ShadowRow| (row.kernel, row.epsilon) == (kernel, epsilon);
    let row = report.shadows.iter().find(is_own);
    let row = row.unwrap_or_else(|| panic!("{kernel}, {epsilon:?}"));
    assert_eq!([row.pixels, row.shadow_rays], [4000; 2]);
    [row.false_shadows, row.leaks, row.wrong_pixels]
}

/// A missing or small epsilon causes acne, a large one light leaks. A kernel with a proof has neither.
#[test]
fn acne_and_leaks_are_counted() {
    let benchmarks = Kernel::ALL.map(|kernel| Benchmark { kernel, device: Device::Cpu });
    let report = measure(&cases(&["contacts_1e-6"]), &benchmarks, &settings());
    // Only the shadows of a lit scene are measured.
    assert_eq!((report.rays.len(), report.shadows.len()), (0, 10));
    for kernel in ["lecture", "stable", "double"] {
        let [none, small, large] = [0.0, 1e-4, 1e-3].map(|e| shadows(&report, kernel, Some(e)));
        assert!(none[0] > 400 && none[2] > 400, "{none:?}");
        // The scene is smaller than either: there are no shadows.
        assert!(small[1] > 120 && small[1] == large[1], "{small:?}");
    }
    assert_eq!(shadows(&report, "certified", None), [0; 3]);
}

#[test]
fn rays_and_shadows_of_a_given_scene_with_lights_are_measured() {
    let path = "scenes/lit/hard/terminator.toml";
    let text = kugelblitz_tests::text_of(path);
    let scene = parse_scene(&text, path.as_ref()).unwrap().into();
    let case = ReportScene::new(scene, &text, path.as_ref(), SceneClass::Given).unwrap();
    let benchmarks = [Benchmark { kernel: Kernel::Certified, device: Device::Cpu }];
    let report = measure(&[case], &benchmarks, &settings());
    assert_eq!([report.classes.len(), report.rays.len(), report.shadows.len()], [1; 3]);
    assert_eq!(shadows(&report, "certified", None), [0; 3]);
}
