//! How a report is shown: the figures on the terminal, in the page and in the plots are those of
//! the report, whatever it holds.

use base64::Engine;
use kugelblitz::report::{
    Baseline, Class, CloudResult, Distribution, Earlier, ErrorPicture, Errors, Fault, LightFault,
    LightPicture, LightResult, Missing, Noise, Report, Spread, Verdict, page, plot, text,
};
use kugelblitz_tests::made_report;
use kugelblitz_tests::made_report::{DEVICES, KERNELS, classes, report};
use roxmltree::{Document, Node};

/// The number that a cell begins with: `12.3 (11.9–14.0)`, `1.2e-6 %`, `1.2 × 10⁻⁶`, `10⁶`, `∞`.
fn number(cell: &str) -> f64 {
    let cell = cell.replace('\u{202f}', "");
    let mut words = cell.split(' ');
    let power = |word: &str| {
        let raised = |c: char| match "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|digit| digit == c)
        {
            Some(digit) => digit.to_string(),
            None => "-".to_string(),
        };
        let exponent: String = word["10".len()..].chars().map(raised).collect();
        10f64.powi(exponent.parse().unwrap_or_else(|_| panic!("`{cell}`")))
    };
    match (words.next().unwrap_or_default(), words.next(), words.next()) {
        ("∞", ..) => f64::INFINITY,
        (factor, Some("×"), Some(ten)) => factor.parse::<f64>().expect("a factor") * power(ten),
        (first, ..) if first.starts_with("10") && !first.is_ascii() => power(first),
        (first, ..) => first.parse().unwrap_or_else(|_| panic!("no number: `{cell}`")),
    }
}

/// Both side by side; panics where one has more.
#[track_caller]
fn pairs<A, B>(a: impl IntoIterator<Item = A>, b: impl IntoIterator<Item = B>) -> Vec<(A, B)> {
    let (a, b): (Vec<A>, Vec<B>) = (a.into_iter().collect(), b.into_iter().collect());
    assert_eq!(a.len(), b.len(), "the figures and what shows them");
    a.into_iter().zip(b).collect()
}

/// True where a cell shows `x` to two digits and more.
fn shows(cell: &str, x: f64) -> bool {
    let shown = number(cell);
    shown == x || (shown - x).abs() <= 0.05 * x.abs()
}

fn shows_wrong(cell: &str, errors: &Errors) -> bool {
    match errors.wrong_ids() {
        0 => cell.replace('\u{202f}', "") == format!("0 of {}", errors.rays),
        wrong => cell.ends_with('%') && shows(cell, 100.0 * wrong as f64 / errors.rays as f64),
    }
}

fn counts(errors: &Errors) -> [f64; 3] {
    [errors.false_hits, errors.false_misses, errors.wrong_object].map(|n| n as f64)
}

fn quantiles(of: &Option<Distribution>) -> [f64; 3] {
    of.map(|d| [d.median, d.p999, d.max]).expect("a distribution")
}

fn short(device: &str) -> &str {
    if device == DEVICES[0] { "llvmpipe" } else { device }
}

fn shown_text(node: Node) -> String {
    node.descendants().filter(Node::is_text).filter_map(|text| text.text()).collect()
}

/// The page's tables, each as rows of cells; heads are left out.
fn tables(page: &str) -> Vec<Vec<Vec<String>>> {
    let parts = page.split("<table>").skip(1).map(|part| part.split("</table>").next().unwrap());
    parts
        .map(|part| {
            let xml = format!("<table>{part}</table>");
            let table = Document::parse(&xml).unwrap_or_else(|error| panic!("{error}: {xml}"));
            let rows = table.descendants().filter(|node| node.has_tag_name("tr"));
            rows.map(|row| {
                row.children().filter(|cell| cell.has_tag_name("td")).map(shown_text).collect()
            })
            .filter(|row: &Vec<String>| !row.is_empty())
            .collect()
        })
        .collect()
}

/// Cells of a line on the terminal: two blanks and more stand between them.
fn cells(line: &str) -> Vec<String> {
    line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(str::to_string).collect()
}

/// Panics with the row where a class's row shows other figures than `result` has.
fn assert_class_errors(row: &[String], result: &kugelblitz::report::ClassResult) {
    let errors = &result.errors;
    assert_eq!(row[0], result.contestant.kernel, "{row:?}");
    assert_eq!(row[1], short(&result.contestant.device), "{row:?}");
    assert!(shows_wrong(&row[2], errors), "{row:?}");
    let [.., normal] = quantiles(&errors.normal_degrees);
    let expected = [&counts(errors)[..], &quantiles(&errors.t_ulp), &[normal]].concat();
    for (cell, x) in pairs(&row[3..], expected) {
        assert!(shows(cell, x), "`{cell}` is not {x}: {row:?}");
    }
}

/// Panics with the row where it shows other figures than `cloud` has.
fn assert_cloud(row: &[impl AsRef<str>], cloud: &CloudResult) {
    let row: Vec<&str> = row.iter().map(AsRef::as_ref).collect();
    assert_eq!(row.len(), 7, "{row:?}");
    assert!(shows(row[0], cloud.n_spheres as f64), "{row:?}");
    assert_eq!(row[1], short(&cloud.contestant.device), "{row:?}");
    assert!(shows(row[2], cloud.picture_ms.median), "{row:?}");
    assert!(shows(row[3], cloud.build_ms.median), "{row:?}");
    let stages = cloud.errors.stages;
    let shares = [stages.f64, stages.exact].map(|n| 100.0 * n as f64 / stages.total() as f64);
    for (cell, share) in pairs(&row[4..6], shares) {
        assert!(shows(cell, share), "{row:?}");
    }
    assert!(shows_wrong(row[6], &cloud.errors), "{row:?}");
}

/// Panics where the two rows of a lit scene show other figures than `result` has.
fn assert_light(rows: [&[impl AsRef<str>]; 2], result: &LightResult) {
    for (row, what) in rows.iter().zip(["shadows", "bytes"]) {
        let row: Vec<&str> = row.iter().map(AsRef::as_ref).collect();
        assert_eq!((row[0].replace('\\', "").as_str(), row[1]), (result.scene.as_str(), what));
        for (cell, of_kernel) in pairs(&row[2..], &result.rows) {
            let errors = &of_kernel.errors;
            let (wrong, of) = match what {
                "shadows" => (errors.false_shadows + errors.leaks, errors.verdicts),
                _ => (errors.wrong_bytes, errors.pixels),
            };
            let share = 100.0 * wrong as f64 / of as f64;
            assert!(shows(cell, share) && cell.ends_with('%') == (wrong > 0), "{row:?}");
        }
    }
}

#[test]
fn the_terminal_shows_the_figures() {
    let report = report();
    let text = text::terminal(&report);
    assert!(text.lines().all(|line| line.chars().count() <= 110), "{text}");
    let blocks: Vec<Vec<&str>> = text.split("\n\n").map(|b| b.lines().collect()).collect();
    let of = |title: &str| {
        let block = blocks.iter().find(|block| block[0].contains(title));
        block.unwrap_or_else(|| panic!("no block `{title}` in\n{text}"))
    };
    // Below title, two lines of head and the names of the classes.
    let errors: Vec<_> = of("How wrong")[3..].iter().filter(|line| !line.contains(':')).collect();
    for (line, result) in pairs(errors, &report.classes) {
        assert_class_errors(&cells(line), result);
    }
    let costs: Vec<_> = of("How fast")[3..].iter().filter(|line| !line.contains(':')).collect();
    for (line, result) in pairs(costs, &report.classes) {
        let row = cells(line);
        let times = [result.trace_ns_per_ray, result.surface_ns_per_ray];
        assert!(pairs(&row[2..4], times).iter().all(|(cell, t)| shows(cell, t.median)), "{line}");
        let stages = result.errors.stages;
        for (cell, n) in pairs(&row[4..], [stages.f32, stages.f64, stages.exact]) {
            assert!(shows(cell, 100.0 * n as f64 / stages.total() as f64), "{line}");
        }
    }
    for (line, cloud) in pairs(&of("Many spheres")[2..], &report.clouds) {
        assert_cloud(&cells(line), cloud);
    }
    // Two blocks, for all columns do not fit a line.
    let at = blocks.iter().position(|block| block[0].starts_with("Light: ")).expect("light");
    let (left, right) = (&blocks[at][3..], &blocks[at + 1][2..]);
    let rows = left.iter().zip(right).map(|(a, b)| [cells(a), cells(b)[2..].to_vec()].concat());
    let rows: Vec<Vec<String>> = rows.collect();
    for (rows, result) in pairs(rows.chunks(2), &report.light) {
        assert_light([&rows[0][..], &rows[1][..]], result);
    }
    let mut lines = of("Scenes: ")[3..].iter().map(|line| cells(line)).filter(|row| row.len() > 1);
    for scene in &report.scenes {
        for device in DEVICES {
            let row = lines.next().expect("a line");
            assert_eq!((row[0].as_str(), row[1].as_str()), (scene.name.as_str(), short(device)));
            let own = scene.rows.iter().filter(|row| row.contestant.device == device);
            for (pair, of_kernel) in pairs(row[2..].chunks(2), own) {
                let share = 100.0 * of_kernel.errors.wrong_share();
                assert!(shows(&pair[0], share), "{row:?}");
                assert!(shows(&pair[1], of_kernel.cost.trace_ns_per_ray.median), "{row:?}");
            }
        }
    }
    assert_eq!(lines.next(), None);
    assert!(text.contains("pbrt 4: `pbrt` is not installed"), "{text}");
}

#[test]
fn the_page_shows_the_figures() {
    let report = report();
    let tables = tables(&page::html(&report));
    for (row, result) in pairs(&tables[0], &report.classes) {
        assert_class_errors(row, result);
    }
    for (row, result) in pairs(&tables[1], &report.classes) {
        assert!(shows(&row[2], result.trace_ns_per_ray.median), "{row:?}");
        assert!(shows(&row[3], result.surface_ns_per_ray.median), "{row:?}");
    }
    for (row, cloud) in pairs(&tables[2], &report.clouds) {
        assert_cloud(row, cloud);
    }
    for (rows, result) in pairs(tables[3].chunks(2), &report.light) {
        assert_light([&rows[0][..], &rows[1][..]], result);
    }
    // Class errors, class costs, clouds, light, three sweeps, the overview; then three tables a scene.
    let sweep = &tables[4];
    assert_eq!(sweep.len(), report.sweeps[0].series[0].points.len());
    let alike = report.sweeps[0].series.iter().filter(|s| s.contestant.device == DEVICES[0]);
    let series: Vec<_> = alike.collect();
    for (row, i) in sweep.iter().zip(0..) {
        for (pair, series) in pairs(row[1..].chunks(2), &series) {
            let point = &series.points[i];
            let errors = point.errors.as_ref().expect("errors");
            assert!(shows(&row[0], point.x) && shows_wrong(&pair[0], errors), "{row:?}");
            assert!(shows(&pair[1], quantiles(&errors.t_ulp)[1]), "{row:?}");
        }
    }
    for (own, scene) in pairs(tables[8..].chunks(3), &report.scenes) {
        assert!(own.iter().all(|table| table.len() == scene.rows.len()));
        for (i, row) in scene.rows.iter().enumerate() {
            let (errors, cost) = (&row.errors, &row.cost);
            let shown = &own[0][i];
            assert!(shows_wrong(&shown[3], errors), "{shown:?}");
            let expected =
                [&[errors.rays as f64][..], &counts(errors), &quantiles(&errors.t_ulp)].concat();
            let cells = [&shown[2..3], &shown[4..]].concat();
            assert!(pairs(&cells, expected).iter().all(|(cell, x)| shows(cell, *x)), "{shown:?}");
            let shown = &own[1][i];
            let expected =
                [quantiles(&errors.t_relative), quantiles(&errors.normal_degrees)].concat();
            let shown_errors = pairs(&shown[2..8], expected);
            assert!(shown_errors.iter().all(|(cell, x)| shows(cell, *x)), "{shown:?}");
            let shown = &own[2][i];
            let times = [&cost.trace_ns_per_ray, &cost.surface_ns_per_ray];
            assert!(pairs(&shown[2..4], times).iter().all(|(cell, t)| shows(cell, t.median)));
            match &cost.device_ns_per_ray {
                Some(time) => assert!(shows(&shown[4], time.median), "{shown:?}"),
                None => assert_eq!(shown[4], "–"),
            }
            let rest = [&cost.readback_ms, &cost.compile_ms, &cost.first_picture_ms];
            assert!(pairs(&shown[5..8], rest).iter().all(|(cell, t)| shows(cell, t.median)));
            assert!(shows(&shown[8], cost.bytes_device as f64), "{shown:?}");
        }
    }
}

#[test]
fn the_summary_in_markdown_shows_the_figures() {
    let report = report();
    let markdown = text::markdown(&report);
    let rows: Vec<Vec<&str>> = markdown
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| ---"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let (classes, rest) = rows.split_at(1 + report.classes.len());
    let (light, clouds) = rest.split_at(1 + 2 * report.light.len());
    assert_eq!(light[0][2..5], ["lecture: no ε", "lecture: ε = 10⁻⁴", "lecture: ε = 10⁻³"]);
    assert_eq!(light[0].last(), Some(&"certified: no ε"));
    for (rows, result) in pairs(light[1..].chunks(2), &report.light) {
        assert_light([&rows[0][..], &rows[1][..]], result);
    }
    for (row, cloud) in pairs(&clouds[1..], &report.clouds) {
        assert_cloud(row, cloud);
    }
    for (row, result) in pairs(&classes[1..], &report.classes) {
        assert_eq!(row[1], result.contestant.kernel);
        assert!(shows_wrong(row[3], &result.errors), "{row:?}");
        assert!(shows(row[4], quantiles(&result.errors.t_ulp)[1]), "{row:?}");
        assert!(shows(row[5], result.trace_ns_per_ray.median), "{row:?}");
    }
    assert!(markdown.contains("22.3.6") && markdown.contains("2 cores"), "{markdown}");
}

/// A report of the CPU alone: these kernels in one lecture's scene, so often wrong, at these times.
fn small(kernels: &[(&str, u64, f64)]) -> Report {
    let mut report = report();
    report.scenes.truncate(1);
    let scene = &mut report.scenes[0];
    scene.rows.retain(|row| row.contestant.device == "CPU");
    let model = scene.rows[0].clone();
    scene.rows.clear();
    for (kernel, wrong_object, ns) in kernels {
        let mut row = model.clone();
        row.contestant.kernel = kernel.to_string();
        row.errors = Errors { rays: 100_000, wrong_object: *wrong_object, ..row.errors };
        (row.errors.false_hits, row.errors.false_misses) = (0, 0);
        row.cost.trace_ns_per_ray = Spread { median: *ns, min: *ns, max: *ns, n: 5 };
        scene.rows.push(row);
    }
    report.classes = classes(&report.scenes);
    report.evidence.adapters.clear();
    report.sweeps.clear();
    report.clouds.clear();
    report.light.clear();
    report.pictures.clear();
    report.light_pictures.clear();
    report
}

/// Where a picture's markers are: what they say, and their x and y.
fn markers(svg: &str) -> Vec<(String, f64, f64)> {
    let svg = Document::parse(svg).expect("XML");
    let titled = svg.descendants().filter(|node| node.has_tag_name("title"));
    titled
        .map(|title| {
            let group = title.parent().expect("a group");
            let circle = group.descendants().find(|node| node.has_tag_name("circle"));
            let circle = circle.expect("the marker of the first device");
            let at = |name| circle.attribute(name).unwrap().parse().unwrap();
            (shown_text(title), at("cx"), at("cy"))
        })
        .collect()
}

/// Top and bottom of the strip for what was never wrong.
fn strip(svg: &str) -> Option<(f64, f64)> {
    let svg = Document::parse(svg).expect("XML");
    let rect = svg.descendants().find(|node| node.attribute("class") == Some("band"))?;
    let at = |name| rect.attribute(name).unwrap().parse::<f64>().unwrap();
    Some((at("y"), at("y") + at("height")))
}

#[test]
fn never_wrong_lies_in_the_strip_and_one_wrong_ray_does_not() {
    let right = small(&[("certified", 0, 20.0)]);
    let svg = plot::plane(&right);
    let (top, bottom) = strip(&svg).expect("a strip");
    let (title, _, y) = &markers(&svg)[0];
    assert!(title.contains("0 of 100\u{202f}000") && (top..bottom).contains(y), "{title}");
    let lane = text_boxes(&svg).into_iter().find(|(words, _)| words == "certified, CPU");
    let [_, name_top, _, name_bottom] = lane.expect("a name").1;
    assert!(top <= name_top && name_bottom <= bottom, "the name is not in the strip: {svg}");
    assert!(text::terminal(&right).contains("certified showed the right object for every ray"));
    assert!(text::terminal(&right).contains("0 of 100000"));
    assert!(page::html(&right).contains("0 of 100\u{202f}000"));

    let wrong = small(&[("certified", 1, 20.0)]);
    let svg = plot::plane(&wrong);
    assert!(strip(&svg).is_none(), "{svg}");
    assert!(markers(&svg)[0].0.contains("1.0e-3 %") || markers(&svg)[0].0.contains("0.0010 %"));
    let sentence = "certified was wrong for 0.0010 % of the rays of figure1";
    assert!(text::terminal(&wrong).contains(sentence), "{}", text::terminal(&wrong));
    assert!(page::html(&wrong).contains(sentence));
    assert!(!text::terminal(&wrong).contains("0 of 100000"));
    assert!(!text::terminal(&wrong).contains("Without a wrong object"));

    // Beside another that was never wrong, it is above the strip.
    let svg = plot::plane(&small(&[("stable", 1, 10.0), ("certified", 0, 20.0)]));
    let (top, bottom) = strip(&svg).expect("a strip");
    let places: Vec<f64> = markers(&svg).into_iter().map(|(_, _, y)| y).collect();
    assert!(places[0] < top && (top..bottom).contains(&places[1]), "{places:?}");
}

#[test]
fn the_plane_is_logarithmic_both_ways() {
    let report = small(&[("lecture", 10_000, 5.0), ("stable", 1000, 50.0), ("double", 100, 500.0)]);
    let places = markers(&plot::plane(&report));
    let step = |i: usize| (places[i + 1].1 - places[i].1, places[i + 1].2 - places[i].2);
    assert!(step(0).0 > 50.0 && (step(0).0 - step(1).0).abs() < 0.3, "{places:?}");
    assert!(step(0).1 > 50.0 && (step(0).1 - step(1).1).abs() < 0.3, "{places:?}");
}

/// Corners of the Pareto front.
fn front(report: &Report) -> usize {
    let svg = plot::plane(report);
    let svg = Document::parse(&svg).expect("XML");
    let lines = svg.descendants().filter(|node| node.has_tag_name("polyline"));
    lines.map(|line| line.attribute("points").unwrap().split(' ').count()).sum()
}

#[test]
fn the_front_has_what_nothing_beats() {
    // Each faster one is more often wrong: two corners a step.
    let steps = [("lecture", 900, 5.0), ("stable", 20, 6.0), ("certified", 0, 7.0)];
    assert_eq!(front(&small(&steps)), 5);
    let stable_is_slow = [("lecture", 900, 5.0), ("stable", 20, 9.0), ("certified", 0, 7.0)];
    assert_eq!(front(&small(&stable_is_slow)), 3);
    let price = text::terminal(&small(&steps)).replace('\n', " ");
    assert!(price.contains("certified takes 1.40 times as long as the fastest."), "{price}");
}

/// All that is drawn of a report.
fn drawn(report: &Report) -> Vec<String> {
    let sweeps = report.sweeps.iter().map(|sweep| plot::sweep(report, sweep));
    std::iter::once(plot::plane(report)).chain(sweeps).collect()
}

/// Panics where a picture is no XML, or has a number that is none or lies outside.
fn assert_drawable(svg: &str) {
    let document = Document::parse(svg).unwrap_or_else(|error| panic!("{error}: {svg}"));
    let root = document.root_element();
    let size: Vec<f64> =
        ["width", "height"].map(|side| root.attribute(side).unwrap().parse().unwrap()).to_vec();
    let names = ["x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "width", "height"];
    let mut coordinates = Vec::new();
    for node in document.descendants().filter(Node::is_element) {
        let plain = node.attributes().filter(|a| names.contains(&a.name())).map(|a| a.value());
        coordinates.extend(plain.map(str::to_string));
        let points = node.attribute("points").unwrap_or_default();
        coordinates.extend(points.split([' ', ',']).map(str::to_string));
        let text = node.text().unwrap_or_default();
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
    for coordinate in coordinates.iter().filter(|text| !text.is_empty()) {
        let px: f64 = coordinate.parse().unwrap_or_else(|_| panic!("`{coordinate}` in {svg}"));
        assert!(px >= -20.0 && px <= size[0].max(size[1]) + 20.0, "{px} in {svg}");
    }
}

/// The texts of a picture, with where they about are: left, top, right and bottom, px.
fn text_boxes(svg: &str) -> Vec<(String, [f64; 4])> {
    let document = Document::parse(svg).expect("XML");
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts
        .map(|node| {
            let at = |name| node.attribute(name).unwrap().parse::<f64>().unwrap();
            let (words, x, y) = (shown_text(node), at("x"), at("y"));
            let width = 6.5 * words.chars().count() as f64;
            let left = match node.attribute("text-anchor") {
                Some("end") => x - width,
                Some("middle") => x - width / 2.0,
                _ => x,
            };
            (words, [left, y - 9.0, left + width, y + 2.0])
        })
        .collect()
}

/// Panics where a text leaves the picture or two texts lie upon each other.
fn assert_legible(svg: &str) {
    let boxes = text_boxes(svg);
    assert!(boxes.len() > 5, "{boxes:?}");
    let document = Document::parse(svg).expect("XML");
    let width: f64 = document.root_element().attribute("width").unwrap().parse().unwrap();
    for (i, (words, [left, top, right, bottom])) in boxes.iter().enumerate() {
        assert!(*left >= 0.0 && *right <= width, "`{words}` from {left} to {right}");
        for (other_words, other) in &boxes[..i] {
            let is_apart =
                *right <= other[0] || other[2] <= *left || *bottom <= other[1] || other[3] <= *top;
            assert!(is_apart, "`{words}` upon `{other_words}`");
        }
    }
}

#[test]
fn words_are_legible_whatever_the_times_are() {
    for (shorter, longer) in [(1.0, 1.0), (0.7, 3.0), (0.1, 10.0)] {
        let mut report = report();
        for result in &mut report.classes {
            result.trace_ns_per_ray.min *= shorter;
            result.trace_ns_per_ray.max *= longer;
        }
        drawn(&report).iter().for_each(|svg| assert_legible(svg));
    }
}

/// A name, and the change.
type Change = (&'static str, fn(&mut Report));

/// Changes to the report that leave little, or odd numbers.
const CHANGES: [Change; 14] = [
    ("nothing changed", |_| {}),
    ("nothing at all", |report| {
        report.scenes.clear();
        report.classes.clear();
        report.sweeps.clear();
        report.clouds.clear();
        report.light.clear();
        report.missing.clear();
        report.pictures.clear();
        report.light_pictures.clear();
        report.evidence.adapters.clear();
    }),
    ("light of nothing", |report| {
        let rows = report.light.iter_mut().flat_map(|result| &mut result.rows);
        rows.for_each(|row| row.errors = Default::default());
    }),
    ("a kernel that lit one scene alone", |report| {
        report.light[0].rows.retain(|row| row.contestant.kernel == "certified");
    }),
    ("one scene", |report| {
        report.scenes.truncate(1);
        report.classes = classes(&report.scenes);
    }),
    ("the CPU alone", |report| {
        report.evidence.adapters.clear();
        report.classes.retain(|result| result.contestant.device == "CPU");
        for scene in &mut report.scenes {
            scene.rows.retain(|row| row.contestant.device == "CPU");
        }
        for sweep in &mut report.sweeps {
            sweep.series.retain(|series| series.contestant.device == "CPU");
        }
    }),
    ("given scenes", |report| {
        report.scenes.iter_mut().for_each(|scene| scene.class = Class::Given);
        report.classes = classes(&report.scenes);
    }),
    ("errors without bound", |report| {
        each_error(report, |errors| {
            let infinite = f64::INFINITY;
            let all = Distribution { median: 1.0, p999: infinite, max: infinite, n: 9 };
            (errors.t_ulp, errors.t_relative, errors.normal_degrees) = (Some(all), Some(all), None);
        })
    }),
    ("errors of nothing", |report| each_error(report, |errors| *errors = Errors::default())),
    ("no error", |report| {
        each_error(report, |errors| {
            let none = Distribution { median: 0.0, p999: 0.0, max: 0.0, n: 9 };
            *errors = Errors { rays: 9, t_ulp: Some(none), ..Errors::default() };
        })
    }),
    ("all wrong", |report| {
        each_error(report, |errors| {
            *errors = Errors { rays: 9, false_hits: 9, ..Errors::default() };
        })
    }),
    ("times of nothing", |report| {
        report.classes.iter_mut().for_each(|result| result.trace_ns_per_ray = Spread::default());
        let points = report.sweeps.iter_mut().flat_map(|sweep| &mut sweep.series);
        for point in points.flat_map(|series| &mut series.points) {
            point.trace_ns_per_ray = point.trace_ns_per_ray.map(|_| Spread::default());
        }
        for cloud in &mut report.clouds {
            (cloud.build_ms, cloud.picture_ms) = (Spread::default(), Spread::default());
        }
    }),
    ("sweeps of one point", |report| {
        let series = report.sweeps.iter_mut().flat_map(|sweep| &mut sweep.series);
        series.for_each(|series| series.points.truncate(1));
    }),
    ("odd places", |report| {
        let series = report.sweeps.iter_mut().flat_map(|sweep| &mut sweep.series);
        for series in series {
            series.points[0].x = 0.0;
            series.points[1].x = -1e300;
            series.points[2].x = f64::INFINITY;
        }
    }),
];

fn each_error(report: &mut Report, change: fn(&mut Errors)) {
    let in_scenes = report.scenes.iter_mut().flat_map(|scene| &mut scene.rows);
    in_scenes.for_each(|row| change(&mut row.errors));
    report.classes.iter_mut().for_each(|result| change(&mut result.errors));
    let series = report.sweeps.iter_mut().flat_map(|sweep| &mut sweep.series);
    let points = series.flat_map(|series| &mut series.points);
    points.for_each(|point| point.errors.iter_mut().for_each(change));
    report.clouds.iter_mut().for_each(|cloud| change(&mut cloud.errors));
}

#[test]
fn whatever_the_report_holds_can_be_shown() {
    for (what, change) in CHANGES {
        let mut report = report();
        change(&mut report);
        for svg in drawn(&report) {
            assert_drawable(&svg);
        }
        let (page, text) = (page::html(&report), text::terminal(&report));
        tables(&page);
        for shown in [&page, &text, &text::markdown(&report)] {
            assert!(!shown.contains("NaN"), "{what}: {shown}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= 110), "{what}: {text}");
    }
}

#[test]
fn errors_without_bound_stand_above_the_axis() {
    let mut report = report();
    let sweep = plot::sweep(&report, &report.sweeps[0]);
    assert!(!sweep.contains('∞'), "{sweep}");
    let points = &mut report.sweeps[0].series[0].points;
    let errors = points[8].errors.as_mut().expect("errors");
    errors.t_ulp = errors.t_ulp.map(|t| Distribution { p999: f64::INFINITY, ..t });
    assert!(plot::sweep(&report, &report.sweeps[0]).contains('∞'));
    assert!(text::terminal(&report).contains('∞') && page::html(&report).contains('∞'));
}

#[test]
fn a_line_has_a_gap_where_nothing_was_measured() {
    let mut report = report();
    let curves =
        |report: &Report| plot::sweep(report, &report.sweeps[0]).matches("<polyline").count();
    let whole = curves(&report);
    for series in report.sweeps[0].series.iter_mut().step_by(KERNELS.len()) {
        series.points[4].errors.as_mut().expect("errors").t_ulp = None;
    }
    assert_eq!(curves(&report), whole + 1);
}

#[test]
fn devices_share_a_line_where_they_are_alike_to_the_last_bit() {
    let mut report = report();
    let lines = |report: &Report| {
        let svg = plot::sweep(report, &report.sweeps[0]);
        let document = Document::parse(&svg).expect("XML");
        let curves = document.descendants().filter(|node| node.has_tag_name("polyline")).count();
        // Two panels.
        (curves / 2, svg.contains("the same to the last bit"))
    };
    assert_eq!(lines(&report), (KERNELS.len(), true));
    let errors = report.sweeps[0].series[0].points[3].errors.as_mut().expect("errors");
    let t_ulp = errors.t_ulp.as_mut().expect("a distribution");
    t_ulp.median = t_ulp.median.next_up();
    assert_eq!(lines(&report), (KERNELS.len() + 1, true));
    for series in report.sweeps[0].series.iter_mut().take(KERNELS.len()) {
        series.points.iter_mut().filter_map(|p| p.errors.as_mut()).for_each(|e| e.rays += 1);
    }
    assert_eq!(lines(&report), (2 * KERNELS.len(), false));
}

const HOSTILE: &str =
    "</style><script>alert(1)</script>\"'&amp;|`*_\u{1b}[31m\u{202e}\n<img src=x onerror=y>";

#[test]
fn hostile_names_stay_names() {
    let mut report = report();
    for scene in &mut report.scenes {
        scene.name = HOSTILE.into();
        scene.about = HOSTILE.into();
        for row in &mut scene.rows {
            row.contestant.kernel += HOSTILE;
            row.contestant.device += HOSTILE;
        }
    }
    for result in &mut report.classes {
        result.contestant.kernel += HOSTILE;
        result.contestant.device += HOSTILE;
    }
    for series in report.sweeps.iter_mut().flat_map(|sweep| &mut sweep.series) {
        series.contestant.kernel += HOSTILE;
        series.contestant.device += HOSTILE;
    }
    for picture in &mut report.pictures {
        picture.scene = HOSTILE.into();
        picture.contestant.kernel += HOSTILE;
    }
    for cloud in &mut report.clouds {
        cloud.contestant.device += HOSTILE;
    }
    for result in &mut report.light {
        result.scene += HOSTILE;
        result.about = HOSTILE.into();
        result.rows.iter_mut().for_each(|row| row.contestant.kernel += HOSTILE);
    }
    for picture in &mut report.light_pictures {
        picture.scene += HOSTILE;
        picture.contestant.kernel += HOSTILE;
    }
    report.missing = vec![Missing { what: HOSTILE.into(), why: HOSTILE.into() }];
    let evidence = &mut report.evidence;
    evidence.commit = Some(HOSTILE.into());
    for text in [&mut evidence.command, &mut evidence.host_cpu, &mut evidence.system] {
        *text = HOSTILE.into();
    }
    evidence.adapters[0].facts.name = HOSTILE.into();
    evidence.adapters[0].facts.driver = HOSTILE.into();

    let page = page::html(&report);
    assert!(!page.contains("<script") && !page.contains("<img src=x"), "{page}");
    assert_eq!(page.matches("</style>").count(), 1 + drawn(&report).len(), "{page}");
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    for svg in drawn(&report) {
        assert_drawable(&svg);
        assert!(!svg.contains("<script"), "{svg}");
    }
    let (table, markdown) = (text::terminal(&report), text::markdown(&report));
    for shown in [&page, &table, &markdown] {
        let unsafe_character = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!shown.contains(unsafe_character), "{shown}");
    }
    let rows: Vec<&str> = markdown.lines().filter(|line| line.starts_with('|')).collect();
    let n_bars = |row: &&str| row.replace("\\|", "").matches('|').count();
    let (classes, rest) = rows.split_at(2 + report.classes.len());
    let (light, clouds) = rest.split_at(2 + 2 * report.light.len());
    assert_eq!(clouds.len(), 2 + report.clouds.len(), "{markdown}");
    assert!(classes.iter().all(|row| n_bars(row) == 7), "{markdown}");
    assert!(light.iter().all(|row| n_bars(row) == 13), "{markdown}");
    assert!(clouds.iter().all(|row| n_bars(row) == 8), "{markdown}");
    assert!(!markdown.contains("<script"), "{markdown}");
}

#[test]
fn the_page_needs_nothing_beside_itself() {
    let page = page::html(&report());
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for other in ["http:", "https:", "<script", "@import", "url(", "srcset"] {
        assert!(!page.contains(other), "{other}");
    }
    let sources = page.match_indices(" src=\"").map(|(at, found)| &page[at + found.len()..]);
    assert!(sources.clone().count() > 0);
    for source in sources {
        assert!(source.starts_with("data:image/png;base64,"), "{}", &source[..40]);
    }
    let links = page.match_indices("href=\"").map(|(at, found)| &page[at + found.len()..]);
    let links: Vec<_> = links.collect();
    assert!(!links.is_empty());
    links.iter().for_each(|link| assert!(link.starts_with("data:,"), "{}", &link[..40]));
}

/// The pictures of a page, as red, green, blue and opacity.
fn images(page: &str) -> Vec<image::RgbaImage> {
    let sources = page.split("src=\"data:image/png;base64,").skip(1);
    sources
        .map(|source| {
            let data = source.split('"').next().expect("the end of the address");
            let png = base64::engine::general_purpose::STANDARD.decode(data).expect("base64");
            image::load_from_memory(&png).expect("a PNG").to_rgba8()
        })
        .collect()
}

#[test]
fn pictures_and_their_errors_are_shown_pixel_by_pixel() {
    let mut report = small(&[("lecture", 1, 5.0)]);
    let right = |t_ulp| Fault::Right { t_ulp };
    report.pictures = vec![ErrorPicture {
        scene: "figure1".into(),
        contestant: report.classes[0].contestant.clone(),
        width: 4,
        height: 2,
        srgb: (0..8).map(|i| [i, 2 * i, 3 * i]).collect(),
        faults: vec![
            Fault::Background,
            Fault::FalseHit,
            Fault::FalseMiss,
            Fault::WrongObject,
            right(0.1),
            right(100.0),
            right(1e9),
            right(f64::INFINITY),
        ],
    }];
    let page = page::html(&report);
    let images = images(&page);
    let pixel = |image: usize, i: u32| images[image].get_pixel(i % 4, i / 4).0;
    for i in 0..8u8 {
        assert_eq!(pixel(0, i.into()), [i, 2 * i, 3 * i, 255]);
    }
    assert_eq!(pixel(1, 0)[3], 0, "the background is transparent");
    let colors: Vec<[u8; 4]> = (1..7).map(|i| pixel(1, i)).collect();
    for (i, color) in colors.iter().enumerate() {
        assert!(!colors[..i].contains(color), "{colors:?}");
    }
    assert_eq!(pixel(1, 6), pixel(1, 7), "beyond the scale");
    assert!(pixel(1, 4)[3] < pixel(1, 5)[3] && pixel(1, 5)[3] < pixel(1, 6)[3], "{colors:?}");
    // The legend has the same colours.
    for [r, g, b, _] in &colors[..3] {
        assert!(page.contains(&format!("background:#{r:02x}{g:02x}{b:02x}")), "{colors:?}");
    }
    assert!(page.contains("3 wrong pixels (38 %)"), "{page}");
}

#[test]
fn acne_and_leaks_are_shown_pixel_by_pixel() {
    let mut report = small(&[("lecture", 1, 5.0)]);
    let bytes = |levels| LightFault::Bytes { levels };
    report.light = made_report::report().light;
    report.light_pictures = vec![LightPicture {
        scene: report.light[0].scene.clone(),
        contestant: report.light[0].rows[3].contestant.clone(),
        epsilon: Some(1e-3),
        width: 4,
        height: 2,
        srgb: (0..8).map(|i| [i, 2 * i, 3 * i]).collect(),
        faults: vec![
            LightFault::Right,
            LightFault::FalseShadow,
            LightFault::Leak,
            bytes(1),
            bytes(12),
            bytes(64),
            bytes(255),
            LightFault::Leak,
        ],
    }];
    let page = page::html(&report);
    let images = images(&page);
    let pixel = |image: usize, i: u32| images[image].get_pixel(i % 4, i / 4).0;
    for i in 0..8u8 {
        assert_eq!(pixel(0, i.into()), [i, 2 * i, 3 * i, 255]);
    }
    assert_eq!(pixel(1, 0)[3], 0, "what is right is transparent");
    let colors: Vec<[u8; 4]> = (1..6).map(|i| pixel(1, i)).collect();
    for (i, color) in colors.iter().enumerate() {
        assert!(!colors[..i].contains(color), "{colors:?}");
    }
    assert_eq!((pixel(1, 5), pixel(1, 2)), (pixel(1, 6), pixel(1, 7)));
    assert!(pixel(1, 3)[3] < pixel(1, 4)[3] && pixel(1, 4)[3] < pixel(1, 5)[3], "{colors:?}");
    for [r, g, b, _] in &colors[..2] {
        assert!(page.contains(&format!("background:#{r:02x}{g:02x}{b:02x}")), "{colors:?}");
    }
    assert!(page.contains("3 wrong shadows (38 %)"), "{page}");
    assert!(page.contains("4 other wrong pixels (50 %)"), "{page}");
    assert!(page.contains("kernel stable, ε = 10⁻³: its errors"), "{page}");
}

#[test]
fn a_panel_without_numbers_has_no_axis_and_a_section_without_data_no_place() {
    let mut report = report();
    let height = |report: &Report| {
        let svg = plot::sweep(report, &report.sweeps[0]);
        let document = Document::parse(&svg).expect("XML");
        document.root_element().attribute("height").unwrap().parse::<f64>().unwrap()
    };
    let whole = height(&report);
    each_error(&mut report, |errors| {
        let none = Distribution { median: 0.0, p999: 0.0, max: 0.0, n: 9 };
        *errors = Errors { rays: 9, t_ulp: Some(none), ..Errors::default() };
    });
    // Both panels are strips of zeros.
    assert!(height(&report) < whole - 300.0, "{whole} {}", height(&report));
    let svg = plot::sweep(&report, &report.sweeps[0]);
    assert!(svg.contains("class=\"band\"") && !svg.contains("10⁻"), "{svg}");
    each_error(&mut report, |errors| *errors = Errors::default());
    let page = page::html(&report);
    assert!(!page.contains("Sweep: distance") && page.contains("Sweep: objects"));

    let lit_alone = {
        let mut report = made_report::report();
        report.scenes.clear();
        report.classes.clear();
        report.sweeps.clear();
        page::html(&report)
    };
    for title in ["Time and error of each kernel", "Classes of scenes", "Sweep:", "<h2>Scenes</h2>"]
    {
        assert!(!lit_alone.contains(title), "{title}");
    }
    assert!(lit_alone.contains("<h2>Light</h2>") && !lit_alone.contains("<svg"));
}

#[test]
fn a_noisy_machine_is_told_of() {
    let mut report = report();
    let shown = |report: &Report| {
        [text::terminal(report).replace('\n', " "), text::markdown(report), page::html(report)]
    };
    assert!(shown(&report).iter().all(|text| !text.contains("The machine was noisy")));
    report.noise = Noise { times: 160, wide: 90, typical_range: 0.41 };
    for text in shown(&report) {
        assert!(text.contains("The machine was noisy"), "{text}");
        assert!(text.contains("typically 41 % of their median") && text.contains("90 of 160"));
    }
    // As it is measured: a range of a fifth of each median, then of a half in most of them.
    let times = |report: &mut Report, n_wide: usize| {
        let rows = report.scenes.iter_mut().flat_map(|scene| &mut scene.rows);
        for (i, row) in rows.enumerate() {
            let max = if i < n_wide { 15.0 } else { 12.0 };
            row.cost.trace_ns_per_ray = Spread { median: 10.0, min: 10.0, max, n: 9 };
        }
        Noise::of(&report.scenes)
    };
    let noise = times(&mut report, 10);
    assert_eq!(noise, Noise { times: 160, wide: 10, typical_range: 0.2 });
    assert!(noise.warning().is_none() && times(&mut report, 90).warning().is_some());
}

/// The report, and one before it in which the first kernel was three times slower in the first scene, the
/// second three times faster, and the third wrong five times more.
fn since_before(change: fn(&mut serde_json::Value)) -> Report {
    let mut report = report();
    let mut earlier = serde_json::to_value(&report).unwrap();
    (earlier["schema"], earlier["command"]) = (1.into(), "report".into());
    let rows = &mut earlier["scenes"][0]["rows"];
    for (i, factor) in [(0, 3.0), (1, 1.0 / 3.0)] {
        let time = &mut rows[i]["cost"]["trace_ns_per_ray"];
        for part in ["median", "min", "max"] {
            time[part] = (factor * time[part].as_f64().unwrap()).into();
        }
    }
    let wrong = &mut rows[2]["errors"]["wrong_object"];
    *wrong = (wrong.as_u64().unwrap() + 5).into();
    change(&mut earlier);
    let earlier = Earlier::parse(&earlier.to_string()).unwrap();
    earlier.check(&report.effort).unwrap();
    report.baseline = Some(Baseline::new("before.json".into(), &earlier, &report));
    report
}

#[test]
fn what_changed_since_a_baseline_is_marked() {
    let report = since_before(|_| {});
    let baseline = report.baseline.as_ref().unwrap();
    // Ids and surfaces of 20 scenes, 8 contestants, and the clouds.
    assert_eq!(baseline.times.len(), 20 * 8 * 2 + 6);
    assert_eq!((baseline.count(Verdict::Faster), baseline.count(Verdict::Slower)), (1, 1));
    assert_eq!(baseline.count(Verdict::TooFewRuns), 0);
    assert!(baseline.different.is_empty(), "{:?}", baseline.different);
    let wrong = &baseline.wrong_ids[..];
    assert!(wrong.len() == 1 && wrong[0].before == wrong[0].now + 5, "{wrong:?}");
    let terminal = text::terminal(&report);
    let row =
        |mark: &str| terminal.lines().find(|line| line.contains(mark)).expect(mark).to_string();
    assert!(row("▼ faster").starts_with("figure1  lecture") && row("▼ faster").contains("× 0.33"));
    assert!(row("▲ slower").starts_with("figure1  stable") && row("▲ slower").contains("× 3.0"));
    for shown in [terminal.replace('\n', " "), text::markdown(&report), page::html(&report)] {
        assert!(shown.contains("1 got faster and 1 slower by more than noise"), "{shown}");
        assert!(shown.contains("▲ slower") && shown.contains("wrong before"), "{shown}");
        assert!(shown.contains("Against before.json"), "{shown}");
    }
    assert!(!text::terminal(&made_report::report()).contains("Against"));

    // Of one run each nobody can tell.
    let few = since_before(|earlier| {
        earlier["scenes"][0]["rows"][0]["cost"]["trace_ns_per_ray"]["n"] = 1.into();
    });
    let count = |verdict| few.baseline.as_ref().unwrap().count(verdict);
    assert_eq!((count(Verdict::Faster), count(Verdict::TooFewRuns)), (0, 1));
    assert!(text::markdown(&few).contains("give more --rounds"));
    // Another machine, other pixels, another scene.
    let other = since_before(|earlier| {
        earlier["evidence"]["n_cores"] = 64.into();
        earlier["evidence"]["adapters"][0]["driver"] = "another".into();
        earlier["effort"]["seed"] = 2.into();
        earlier["scenes"][1]["name"] = "renamed".into();
    });
    let baseline = other.baseline.as_ref().unwrap();
    assert_eq!((baseline.times.len(), baseline.wrong_ids.len()), (19 * 8 * 2 + 6, 0));
    assert_eq!(baseline.different.len(), 2, "{:?}", baseline.different);
    assert!(page::html(&other).contains("Times tell of more than the program"));
    let earlier = serde_json::to_value(made_report::report()).unwrap().to_string();
    let earlier = earlier.replacen('{', "{\"schema\":1,\"command\":\"report\",", 1);
    let why = Earlier::parse(&earlier).unwrap().check(&Default::default());
    assert!(why.is_ok(), "the same size");
    let effort = kugelblitz::report::Effort { size: [320, 180], ..Default::default() };
    let why = Earlier::parse(&earlier).unwrap().check(&effort).unwrap_err();
    assert!(why.contains("give --size 1280x720"), "{why}");
}
