//! The renderers of a report: tables, Markdown, plots and page have its figures, with any names.

use kugelblitz::words::digits;
use kugelblitz_report::{Report, SceneClass, html, markdown, plots, text};
use kugelblitz_tests::made_report::{DEVICES, KERNELS, report};
use roxmltree::{Document, Node};
use serde_json::Value;

/// Maximum size of a page, bytes.
const MOST_BYTES: usize = 200_000;

/// Returns the cells of each row of the tables in Markdown, by the titles of the sections.
fn sections(markdown: &str) -> Vec<(String, Vec<Vec<String>>)> {
    let sections = markdown.split("### ").skip(1);
    let cells = |line: &str| -> Vec<String> {
        let cells = line.trim_matches(['|', ' ']).split(" | ");
        cells.map(|cell| cell.replace('\\', "")).collect()
    };
    let rows =
        |section: &str| section.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    sections.map(|section| (section.lines().next().unwrap().into(), rows(section))).collect()
}

#[test]
fn every_kernel_and_device_has_a_row_in_every_form() {
    let report = report();
    let page = html::html(&report);
    let forms = [text::terminal(&report), markdown::markdown(&report), page];
    for form in forms {
        let rows = form.lines().flat_map(|line| line.split("<tr>"));
        let rows = rows.filter_map(|row| row.split("</tr>").next());
        let rows: Vec<&str> = rows.filter(|row| !row.contains("<svg")).collect();
        for class in ["lecture's scenes", "hard scenes"] {
            let of_class =
                rows.iter().filter_map(|row| row.split_once(class)).map(|(_, rest)| rest);
            for kernel in KERNELS {
                for device in ["llvmpipe", "CPU"] {
                    let is_own = |row: &&str| row.contains(kernel) && row.contains(device);
                    let n_rows = of_class.clone().filter(is_own).count();
                    assert_eq!(n_rows, 1, "{class}, {kernel}, {device}");
                }
            }
        }
        for scene in &report.scenes {
            assert!(form.replace('\\', "").contains(&scene.name), "{}", scene.name);
        }
        assert!(form.contains("another GPU"));
    }
    let lines = text::terminal(&report);
    assert!(lines.lines().all(|line| line.chars().count() <= 120), "{lines}");
}

/// Returns a time with its range.
fn time(value: &Value) -> String {
    let [median, min, max] =
        ["median", "min", "max"].map(|part| digits(value[part].as_f64().unwrap(), 3));
    format!("{median} ({min}–{max})")
}

#[test]
fn numbers_in_markdown_are_those_in_json() {
    let report = report();
    let json = serde_json::to_value(&report).unwrap();
    let sections = sections(&markdown::markdown(&report));
    let rows = |title: &str| {
        let section = sections.iter().find(|(own, _)| own == title);
        section.unwrap_or_else(|| panic!("no {title}")).1.as_slice()
    };
    let ratio = |row: &Value, wrong: &[&str], of: &str| {
        let wrong: u64 = wrong.iter().map(|count| row[count].as_u64().unwrap()).sum();
        match 100.0 * wrong as f64 / row[of].as_f64().unwrap() {
            0.0 => "0".to_string(),
            percent => format!("{} %", digits(percent, 2)),
        }
    };
    let wrong =
        |row: &Value| ratio(row, &["false_hits", "false_misses", "wrong_object"], "compared");
    let t = |row: &Value| digits(row["t_ulp"]["p999"].as_f64().unwrap(), 3);

    let summary = &rows("Speed against error")[2..];
    let classes = json["classes"].as_array().unwrap();
    assert_eq!(summary.len(), classes.len());
    for (row, json) in summary.iter().zip(classes) {
        assert_eq!(row[2], json["kernel"].as_str().unwrap());
        assert_eq!(row[3..], [wrong(json), t(json), time(&json["ns_per_ray"])]);
    }

    // A column for each kernel and figure; devices with equal figures share a row.
    type Figures<'a> = &'a dyn Fn(&Value) -> Vec<String>;
    let errors: Figures = &|row| vec![wrong(row), t(row)];
    let times: Figures = &|row| vec![time(&row["ns_per_ray"])];
    let shares: Figures =
        &|row| ["false_shadows", "leaks"].map(|n| ratio(row, &[n], "shadow_rays")).to_vec();
    for (title, list, key, figures) in [
        ("Error by scene", "rays", "scene", errors),
        ("Time by scene", "rays", "scene", times),
        ("Error against distance", "distance", "distance", errors),
        ("Time against number of spheres", "spheres", "spheres", times),
        ("Shadows with and without an epsilon", "shadows", "scene", shares),
    ] {
        let rows = rows(title);
        for json in json[list].as_array().unwrap() {
            let name = match &json[key] {
                Value::String(name) => name.clone(),
                number => [1.0, 1e6, 1e7, 1e8]
                    .iter()
                    .find(|x| Some(**x) == number.as_f64())
                    .map_or(number.as_f64().unwrap().to_string(), |x| {
                        if *x == 1.0 || list == "spheres" {
                            x.to_string()
                        } else {
                            format!("{x:e}")
                        }
                    }),
            };
            let second = match (list, json["epsilon"].as_f64()) {
                ("shadows", Some(epsilon)) if epsilon > 0.0 => epsilon.to_string(),
                ("shadows", _) => "none".into(),
                _ => json["device"].as_str().unwrap().split(" (").next().unwrap().into(),
            };
            let row = rows.iter().find(|row| row[0] == name && row[1].contains(&second));
            let row = row.unwrap_or_else(|| panic!("{title}: no {name}, {second}"));
            let figures = figures(json);
            let kernel = format!("{}:", json["kernel"].as_str().unwrap());
            let at = rows[0].iter().position(|head| head.starts_with(&kernel)).unwrap();
            assert_eq!(row[at..at + figures.len()], figures, "{title}: {json}");
        }
    }
}

/// Returns the plots of the page and the SVG file, parsed.
fn assert_drawable(report: &Report) -> usize {
    let svg = plots::svg(report);
    let page = html::html(report);
    let parts = page.split("<svg").skip(1).map(|part| part.split_once("</svg>").expect("an end").0);
    let parts = parts.map(|part| format!("<svg{part}</svg>"));
    let all: Vec<String> = parts.chain([svg]).collect();
    for svg in &all {
        let document = Document::parse(svg).unwrap_or_else(|error| panic!("{error}: {svg}"));
        for node in document.descendants() {
            for name in ["d", "x", "y"] {
                let value = node.attribute(name).unwrap_or_default();
                assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
            }
        }
    }
    all.len() - 1
}

#[test]
fn plots_are_xml_with_a_mark_for_each_figure() {
    let report = report();
    // Two for each class and for the distance, then spheres and shadows.
    assert_eq!(assert_drawable(&report), 8);
    let svg = plots::svg(&report);
    let svg = Document::parse(&svg).unwrap();
    let titles = svg.descendants().filter(|node| node.has_tag_name("title"));
    let titles: Vec<&str> = titles.filter_map(|title| title.text()).collect();
    let n_marks = |names: &[&str]| {
        titles.iter().filter(|title| names.iter().all(|n| title.contains(n))).count()
    };
    // In the classes, errors are the same on both devices, but times are not.
    for (kernel, device) in KERNELS.iter().flat_map(|k| ["llvmpipe: ", "CPU: "].map(|d| (k, d))) {
        assert!(n_marks(&[kernel, device]) >= 4, "{kernel}, {device}");
    }
    for kernel in KERNELS {
        assert_eq!(n_marks(&[kernel, "llvmpipe and CPU: "]), 2 * 9, "{kernel}");
        assert_eq!(n_marks(&[&format!("{kernel}: ")]), if kernel == "certified" { 1 } else { 2 });
    }
    let is_curve = |node: &Node| node.attribute("stroke-dasharray").is_some();
    assert_eq!(svg.descendants().filter(is_curve).count(), 4 * 8 + 2 * 4 + 8 + 4);
}

#[test]
fn plots_are_drawable_with_any_figures() {
    let changes: [fn(&mut Report); 4] = [
        |report| report.distance.iter_mut().for_each(|row| row.errors.t_ulp = None),
        |report| {
            let t = report.distance.iter_mut().filter_map(|row| row.errors.t_ulp.as_mut());
            t.for_each(|t| (t.p999, t.max) = (f64::INFINITY, f64::INFINITY));
        },
        |report| {
            report.classes.truncate(1);
            report.classes[0].class = SceneClass::Given;
            report.classes[0].ns_per_ray.min = 0.0;
        },
        |report| {
            let names = |i| format!("GPU {i}");
            let many = (0..20).map(|i| (names(i), report.spheres[0].clone()));
            let many: Vec<_> = many.collect();
            report.spheres.extend(many.into_iter().map(|(name, mut row)| {
                row.of.device = name;
                row
            }));
        },
    ];
    for (change, n_plots) in changes.iter().zip([7, 8, 6, 8]) {
        let mut report = report();
        change(&mut report);
        assert_eq!(assert_drawable(&report), n_plots);
    }
    let mut nothing = report();
    (nothing.classes, nothing.rays, nothing.distance) = Default::default();
    (nothing.spheres, nothing.shadows) = Default::default();
    assert_eq!(assert_drawable(&nothing), 0);
    assert!(!html::html(&nothing).contains("<table"));
}

const HOSTILE: &str =
    "</style><script>alert(1)</script>\"'&amp;|`*_\u{1b}[31m\u{202e}\n<img src=x onerror=y>";

#[test]
fn hostile_names_stay_names() {
    let mut report = report();
    report.rays.iter_mut().for_each(|row| row.scene += HOSTILE);
    report.rays.iter_mut().for_each(|row| row.of.device += HOSTILE);
    report.classes.iter_mut().for_each(|row| row.of.device += HOSTILE);
    report.shadows.iter_mut().for_each(|row| row.scene += HOSTILE);
    report.missing[0].what = HOSTILE.into();
    let environment = &mut report.environment;
    environment.commit = Some(HOSTILE.into());
    for text in [&mut environment.command, &mut environment.host_cpu, &mut environment.system] {
        *text = HOSTILE.into();
    }
    environment.adapters[0].facts.name = DEVICES[0].to_string() + HOSTILE;

    let n_plots = assert_drawable(&report);
    let page = html::html(&report);
    assert!(!page.contains("<script") && !page.contains("<img src=x"), "{page}");
    assert_eq!(page.matches("</style>").count(), 1 + n_plots, "{page}");
    let (table, markdown) = (text::terminal(&report), markdown::markdown(&report));
    for shown in [&page, &table, &markdown] {
        let is_unsafe = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!shown.contains(is_unsafe), "{shown}");
    }
    assert!(!markdown.contains("<script"), "{markdown}");
    for (title, rows) in sections(&markdown) {
        assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{title}: {rows:?}");
    }
}

#[test]
fn the_page_is_small_and_needs_no_other_file() {
    let mut report = report();
    let page = html::html(&report);
    let markup = page.replace("http://www.w3.org/2000/svg", "");
    for other in ["http:", "https:", "<script", "@import", "url(", "src=", "srcset"] {
        assert!(!markup.contains(other), "{other}");
    }
    // As many scenes as the program has.
    let rows = report.rays.clone();
    for i in 0..2 {
        report.rays.extend(rows.iter().cloned().map(|mut row| {
            row.scene += &format!("_{i}");
            row
        }));
    }
    let shadows = report.shadows.clone();
    for i in 0..25 {
        report.shadows.extend(shadows.iter().cloned().map(|mut row| {
            row.scene += &format!("_{i}");
            row
        }));
    }
    let page = html::html(&report);
    assert!(page.len() < MOST_BYTES, "{} bytes", page.len());
}
