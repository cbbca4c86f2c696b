//! The report's measuring: it repeats itself, and it sees a kernel that is wrong.

use std::sync::Arc;
use std::time::Instant;

use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::device::{Device, Made};
use kugelblitz::num::V3;
use kugelblitz::prepare::Prepared;
use kugelblitz::report::{
    CLOUD_SIZE, Case, Class, Contestant, Effort, Errors, Evidence, Fault, LightErrors, LightFault,
    LightPicture, LightRow, Report, Subject, default_cases, page, plot, text,
};
use kugelblitz::trace::{Hits, Kernel, Rays, Timing, Wants};
use kugelblitz::tracer::{Backend, Tracer};

const EFFORT: Effort = Effort {
    size: [96, 54],
    samples: 4000,
    seed: 7,
    rounds: 2,
    runs: 2,
    picture_size: [32, 18],
    sweeps: false,
    clouds: Vec::new(),
};

fn cases(names: &[&str]) -> Vec<Case> {
    let all = default_cases().unwrap();
    let named: Vec<_> =
        all.into_iter().filter(|case| names.contains(&case.name.as_str())).collect();
    assert_eq!(named.len(), names.len());
    named
}

fn measure(cases: &[Case], subjects: &[Subject], effort: Effort) -> (Report, Control) {
    let evidence = Evidence::collect("kugelblitz report".into(), None, Vec::new());
    let control = Control::default();
    let report = Report::measure(evidence, cases, subjects, effort, &control).unwrap();
    (report, control)
}

const KERNELS: [Kernel; 3] = [Kernel::Lecture, Kernel::Stable, Kernel::Certified];

/// Every error figure of a report, in order.
fn all_errors(report: &Report) -> Vec<&Errors> {
    let rows = report.scenes.iter().flat_map(|scene| &scene.rows).map(|row| &row.errors);
    let classes = report.classes.iter().map(|class| &class.errors);
    let points = report.sweeps.iter().flat_map(|sweep| &sweep.series);
    let points = points.flat_map(|series| &series.points).filter_map(|point| point.errors.as_ref());
    let clouds = report.clouds.iter().map(|cloud| &cloud.errors);
    rows.chain(classes).chain(points).chain(clouds).collect()
}

#[test]
fn errors_repeat_exactly_and_times_have_their_range() {
    let gpu = Device::Gpu(kugelblitz_tests::gpu());
    let devices = [gpu, Device::Cpu];
    let subjects: Vec<_> = devices
        .iter()
        .flat_map(|device| KERNELS.map(|kernel| Subject::new(kernel, device)))
        .collect();
    let cases = cases(&["figure2", "far_1e8"]);
    let effort = Effort { sweeps: true, rounds: 1, clouds: vec![3000], ..EFFORT };
    let (first, control) = measure(&cases, &subjects, effort.clone());
    let (second, _) = measure(&cases, &subjects, effort.clone());
    assert_eq!(all_errors(&first), all_errors(&second));

    // Of the worst scenes: here the one in which a kernel is wrong.
    let pictured = (subjects.len() as u64 / 2 + 1) * 32 * 18;
    assert_eq!(control.rays_done(), Report::n_rays(&cases, &subjects, &effort) + pictured);
    assert_eq!(first.scenes.len(), 2);
    for scene in &first.scenes {
        assert_eq!(scene.rows.len(), subjects.len());
        for row in &scene.rows {
            assert_eq!(row.errors.rays, 4000);
            assert_eq!(row.errors.stages.total(), 96 * 54);
            let time = row.cost.trace_ns_per_ray;
            assert!(time.n == 2 && 0.0 < time.min && time.min <= time.median, "{time:?}");
            assert!(time.median <= time.max, "{time:?}");
            assert!(row.cost.bytes_device > 0);
            if row.contestant.kernel == "certified" {
                assert_eq!(row.errors.wrong_ids(), 0);
                assert!(row.errors.t_ulp.unwrap().max <= 0.5);
            }
        }
    }
    // Far from the origin, the plain formulas must fail, or nothing was compared.
    let lecture = &first.scenes.iter().find(|scene| scene.name == "far_1e8").unwrap().rows[0];
    assert!(lecture.errors.wrong_share() > 0.05, "{:?}", lecture.errors);
    assert_eq!(first.classes.len(), 2 * subjects.len());
    // With certified alone, on each device.
    assert_eq!(first.clouds.len(), 2);
    for cloud in &first.clouds {
        let [width, height] = CLOUD_SIZE.map(u64::from);
        let errors = &cloud.errors;
        assert_eq!((cloud.n_spheres, cloud.contestant.kernel.as_str()), (3000, "certified"));
        assert_eq!((errors.rays, errors.wrong_ids()), (1024, 0), "{errors:?}");
        assert!(errors.t_ulp.is_some_and(|t| t.n > 100 && t.max <= 0.5), "{errors:?}");
        assert_eq!(errors.stages.total(), width * height);
        assert!(errors.stages.f64 + errors.stages.exact > 0, "{errors:?}");
        assert!(cloud.build_ms.n == 1 && cloud.build_ms.min > 0.0, "{cloud:?}");
        assert!(cloud.picture_ms.n == 2 && cloud.picture_ms.min > 0.0, "{cloud:?}");
    }
    assert_eq!(first.sweeps.len(), 3);
    for (sweep, n_points) in first.sweeps.iter().zip([12, 11, 5]) {
        assert_eq!(sweep.series.len(), subjects.len(), "{}", sweep.name);
        for series in &sweep.series {
            // Clouds with certified alone.
            let has_clouds = sweep.name == "objects" && series.contestant.kernel == "certified";
            let n_clouds = if has_clouds { effort.clouds.len() } else { 0 };
            assert_eq!(series.points.len(), n_points + n_clouds, "{}", sweep.name);
            assert!(series.points.is_sorted_by(|a, b| a.x < b.x));
        }
    }
}

/// The lecture's formulas with one sign flipped: `b = 2·d·(c − o)`.
struct FlippedSign {
    prepared: Arc<Prepared>,
    wants: Wants,
}

impl Backend for FlippedSign {
    fn propose(&mut self, rays: &Rays, _: &Control, hits: &mut Hits) -> Result<Option<Timing>> {
        let start = Instant::now();
        let Rays::Pixels(pixels) = rays else { unreachable!("only pictures are traced here") };
        hits.reset(rays.len(), self.wants);
        let o = V3::<f32>::near(self.prepared.reference);
        for index in 0..rays.len() {
            let (x, y) = pixels.xy(index);
            let d = V3::<f32>::near(pixels.direction(x, y));
            let mut nearest = f32::INFINITY;
            for (sphere, id) in self.prepared.scene.spheres.iter().zip(1..) {
                let c = V3::<f32>::near(sphere.center);
                let (a, b) = (d.dot(d), 2.0 * d.dot(c - o));
                let k = (o - c).dot(o - c) - (sphere.radius * sphere.radius) as f32;
                let discriminant = b * b - 4.0 * a * k;
                let t = (-b - discriminant.sqrt()) / (2.0 * a);
                if discriminant >= 0.0 && t > 0.0 && t < nearest {
                    nearest = t;
                    hits.id[index] = id;
                    if self.wants.surface {
                        (hits.t[index], hits.normal[index]) = (t, [0.0, 1.0, 0.0]);
                    }
                }
            }
        }
        hits.counts.f32 = rays.len() as u64;
        Ok(Some(Timing { trace: start.elapsed(), ..Timing::default() }))
    }

    fn retarget(&mut self, prepared: &Arc<Prepared>) -> Result<()> {
        self.prepared = Arc::clone(prepared);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        0
    }
}

/// A kernel with one flipped sign, run through the report.
fn with_a_flipped_sign() -> Report {
    let flipped = Subject {
        contestant: Contestant { kernel: "flipped".into(), device: "CPU".into() },
        kernel: Kernel::Lecture,
        make: Box::new(|prepared, wants| {
            let backend = FlippedSign { prepared: Arc::clone(prepared), wants };
            let tracer = Tracer::on(backend, Arc::clone(prepared), wants);
            Ok(Made { tracer, compile: Default::default(), upload: Default::default() })
        }),
    };
    let subjects = [flipped, Subject::new(Kernel::Lecture, &Device::Cpu)];
    measure(&cases(&["figure2"]), &subjects, EFFORT).0
}

#[test]
fn a_flipped_sign_shows() {
    let report = with_a_flipped_sign();
    let [flipped, lecture] = &report.scenes[0].rows[..] else { panic!("two rows") };
    assert_eq!(lecture.errors.wrong_ids(), 0);
    assert!(flipped.errors.wrong_share() > 0.1, "{:?}", flipped.errors);
    assert!(flipped.errors.false_misses > 0, "{:?}", flipped.errors);
    let picture = &report.pictures[0];
    assert_eq!(picture.contestant.kernel, "flipped");
    assert!(picture.faults.contains(&Fault::FalseMiss));
    let table = text::terminal(&report);
    let row = table.lines().find(|line| line.starts_with("flipped  ")).unwrap();
    assert!(row.contains('%') && !row.contains("0 of"), "{row}");
    let row = table.lines().find(|line| line.starts_with("lecture  ")).unwrap();
    assert!(row.contains("0 of"), "{row}");
    let plot = plot::plane(&report);
    let n_rays = 4000;
    assert!(
        plot.contains(&format!("lecture, CPU, lecture's scenes: 0 of {n_rays} wrong")),
        "{plot}"
    );
    assert!(plot.contains("flipped, CPU, lecture's scenes: "), "{plot}");
    assert!(!plot.contains(&format!("flipped, CPU, lecture's scenes: 0 of {n_rays}")), "{plot}");
    assert!(text::markdown(&report).contains("| flipped | CPU | "));
    assert!(page::html(&report).contains("flipped was wrong for "));
    let json = serde_json::to_value(&report).unwrap();
    let wrong = &json["scenes"][0]["rows"][0]["errors"]["false_misses"];
    assert_eq!(wrong.as_u64(), Some(flipped.errors.false_misses));
}

/// The light of a kernel with an epsilon in the only scene of a report.
fn light(report: &Report, kernel: &str, epsilon: Option<f64>) -> LightErrors {
    let rows = &report.light[0].rows;
    let of = |row: &&LightRow| (row.contestant.kernel.as_str(), row.epsilon) == (kernel, epsilon);
    rows.iter().find(of).unwrap_or_else(|| panic!("{kernel}, {epsilon:?}")).errors
}

/// Without an epsilon, and with one that is too small, surfaces shadow themselves; with one that is too
/// large, light leaks in. What is proven needs none.
#[test]
fn acne_leaks_and_neither_of_them_show() {
    let subjects = Kernel::ALL.map(|kernel| Subject::new(kernel, &Device::Cpu));
    let cases = cases(&["contacts_1e-6"]);
    let (report, control) = measure(&cases, &subjects, EFFORT);
    // Its rays are no part of the tables of rays.
    assert!(report.scenes.is_empty() && report.classes.is_empty());
    assert_eq!((report.light.len(), report.light[0].rows.len()), (1, 10));
    // Of certified one trace and two pictures, of stable one trace and two for each epsilon.
    let pictured = (3 + 7) * 32 * 18;
    assert_eq!(control.rays_done(), Report::n_rays(&cases, &subjects, &EFFORT) + pictured);
    for row in &report.light[0].rows {
        assert_eq!((row.errors.pixels, row.errors.verdicts), (4000, 4000), "{row:?}");
    }
    let share = |n: u64| n as f64 / 4000.0;
    for kernel in ["lecture", "stable", "double"] {
        let [none, small, large] = [0.0, 1e-4, 1e-3].map(|e| light(&report, kernel, Some(e)));
        assert!(share(none.false_shadows) > 0.1 && share(none.wrong_bytes) > 0.1, "{none:?}");
        // The whole scene is smaller than either: all shadows are gone.
        assert!(share(small.leaks) > 0.03 && small.leaks == large.leaks, "{small:?}");
        assert!(share(small.far_bytes) > 0.03, "{small:?}");
    }
    let clean = LightErrors { pixels: 4000, verdicts: 4000, ..LightErrors::default() };
    assert_eq!(light(&report, "certified", None), clean);

    let of_picture = |kernel: &str, epsilon| {
        let of = |picture: &&LightPicture| {
            (picture.contestant.kernel.as_str(), picture.epsilon) == (kernel, epsilon)
        };
        let picture = report.light_pictures.iter().find(of).unwrap();
        let n = |fault| picture.faults.iter().filter(|other| **other == fault).count();
        assert_eq!(picture.faults.len(), 32 * 18);
        [LightFault::Right, LightFault::FalseShadow, LightFault::Leak].map(n)
    };
    assert_eq!(of_picture("certified", None), [32 * 18, 0, 0]);
    assert!(of_picture("stable", Some(0.0))[1] > 50);
    assert!(of_picture("stable", Some(1e-3))[2] > 20);
    let json = serde_json::to_value(&report).unwrap();
    let row = &json["light"][0]["rows"][9];
    assert_eq!((&row["kernel"], &row["epsilon"]), (&"certified".into(), &serde_json::Value::Null));
    assert_eq!(row["errors"]["false_shadows"], 0);
}

/// A given scene with lights is measured both ways.
#[test]
fn given_scenes_with_lights_are_lit() {
    let path = "scenes/lit/hard/terminator.toml";
    let text = kugelblitz_tests::text_of(path);
    let case = Case::new(&text, path.as_ref(), Class::Given, &Control::default()).unwrap();
    let subjects = [Subject::new(Kernel::Certified, &Device::Cpu)];
    let (report, _) = measure(&[case], &subjects, EFFORT);
    assert_eq!((report.scenes.len(), report.light.len()), (1, 1));
    assert_eq!(light(&report, "certified", None).wrong_bytes, 0);
    // No plain kernel was asked for, so there is nothing to be shown beside it.
    assert!(report.light_pictures.is_empty());
}
