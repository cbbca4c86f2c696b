//! How a report is shown: the figures on the terminal, in the page and in the plots are those of
//! the report, whatever it holds.

use base64::Engine;
use kugelblitz::scene::hex;
use kugelblitz_judge::compare::{FALSE_HIT, FALSE_MISS, RAMP, WRONG_OBJECT};
use kugelblitz_report::{
    Class, Count, Earlier, Metric, Missing, Noise, Of, Report, Row, SWEEPS, Settings, Spread, page,
    plot, text,
};
use kugelblitz_tests::assert_kept;
use kugelblitz_tests::made_report::{DEVICES, KERNELS, picture, report, row, since, with_classes};
use roxmltree::{Document, Node};

fn shown_text(node: Node) -> String {
    node.descendants().filter(Node::is_text).filter_map(|text| text.text()).collect()
}

/// The words of a page, a line for each block and each row of a table; plots and pictures are left out.
fn words_of(page: &str) -> String {
    let (_, body) = page.split_once("<body").expect("a body");
    let mut body = body.to_owned();
    for (start, end) in [("<style", "</style>"), ("<svg", "</svg>")] {
        while let Some(at) = body.find(start) {
            let end = at + body[at..].find(end).expect("an end") + end.len();
            body.replace_range(at..end, "");
        }
    }
    let cells = body.replace("</td>", " | ").replace("</th>", " | ").replace("</dt>", ": ");
    let blocks = "tr p h1 h2 h3 h4 li caption div dd summary figcaption";
    let lines = blocks.split(' ').fold(cells, |text, tag| text.replace(&format!("</{tag}>"), "\n"));
    let plain: String = lines.split('<').filter_map(|part| Some(part.split_once('>')?.1)).collect();
    let lines = plain.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    lines.filter(|line| !line.is_empty()).map(|line| line + "\n").collect()
}

/// On the terminal, in the page and in Markdown: a report, and what has changed since an earlier one.
#[test]
fn reports_are_shown_as_they_are_kept() {
    let noise = Noise { times: 160, wide: 90, typical_range: 0.41 };
    // Of one run each nobody can tell.
    let few =
        since(3.0, |earlier| earlier["rows"][0]["numbers"]["trace_ns_per_ray"]["n"] = 1.into());
    // Another machine, other pixels, a row of another scene.
    let other = since(3.0, |earlier| {
        earlier["environment"]["n_cores"] = 64.into();
        earlier["environment"]["adapters"][0]["driver"] = "another".into();
        earlier["settings"]["seed"] = 2.into();
        earlier["rows"][0]["scene"] = "renamed".into();
    });
    let shown = |report: &Report| {
        let terminal = text::terminal(report);
        assert!(terminal.lines().all(|line| line.chars().count() <= 110), "{terminal}");
        [&terminal, "\n", &text::markdown(report), "\n", &words_of(&page::html(report))].concat()
    };
    let whole = shown(&report());
    assert_kept("tests/shown/report.txt", &whole);
    for (name, report) in [
        ("noisy", Report { noise, ..report() }),
        ("faster", since(3.0, |_| {})),
        ("slower", since(1.0 / 3.0, |_| {})),
        ("few", few),
        ("other", other),
    ] {
        // The lines that the other does not have.
        let shown = shown(&report);
        let lines = shown.lines().filter(|line| !whole.lines().any(|other| other == *line));
        assert_kept(
            &format!("tests/shown/{name}.txt"),
            &(lines.collect::<Vec<_>>().join("\n") + "\n"),
        );
    }
    // As it is measured: a range of a fifth of each median, then of a half in most of them.
    let mut report = report();
    let mut times = |n_wide: usize| {
        for (i, row) in report.rows.iter_mut().enumerate() {
            let max = if i < n_wide { 15.0 } else { 12.0 };
            let time = Spread { median: 10.0, p999: max, min: 10.0, max, n: 9 };
            row.numbers.insert(Metric::TraceNsPerRay, time);
        }
        Noise::of(&report.rows)
    };
    let noise = times(10);
    assert_eq!(noise, Noise { times: 64, wide: 10, typical_range: 0.2 });
    assert!(noise.warning().is_none() && times(40).warning().is_some());
}

/// A report of the CPU alone: these kernels in one lecture's scene, so often wrong, at these times.
fn small(kernels: &[(&str, u64, f64)]) -> Report {
    let mut report = report();
    let own = |(kernel, wrong, ns): &(&str, u64, f64)| {
        let of = Of::Scene { scene: "figure1".into(), class: Class::Lecture };
        let mut row = row(of, kernel, "CPU");
        row.counts.extend([(Count::Rays, 100_000), (Count::WrongObject, *wrong)]);
        let time = Spread { median: *ns, p999: *ns, min: *ns, max: *ns, n: 5 };
        row.numbers.insert(Metric::TraceNsPerRay, time);
        row
    };
    report.rows = with_classes(kernels.iter().map(own).collect());
    report.environment.adapters.clear();
    report.pictures.clear();
    report
}

/// What a plot shows and where: texts, marks, lines, and the strip for what was never wrong.
fn outline(svg: &str) -> String {
    let svg = Document::parse(svg).expect("XML");
    let said = svg.descendants().filter_map(|node| {
        let at = |node: Node, names: [&str; 2]| {
            names.map(|name| node.attribute(name).unwrap_or_default().to_string()).join(" ")
        };
        match node.tag_name().name() {
            "text" => Some(format!("{}: {}", at(node, ["x", "y"]), shown_text(node))),
            "title" => {
                let mark = node.parent()?.descendants().find(|node| node.has_tag_name("circle"))?;
                Some(format!("mark at {}: {}", at(mark, ["cx", "cy"]), shown_text(node)))
            }
            "polyline" => Some(format!("line through {}", node.attribute("points")?)),
            "rect" if node.attribute("class") == Some("band") => {
                Some(format!("strip, top and height: {}", at(node, ["y", "height"])))
            }
            _ => None,
        }
    });
    said.map(|line| line + "\n").collect()
}

/// What was never wrong lies in the strip, one wrong ray above it; both scales are logarithmic; a front has what nothing beats.
#[test]
fn planes_are_shown_as_they_are_kept() {
    let mut text = String::new();
    for (name, kernels) in [
        ("never wrong", &[("certified", 0, 20.0)][..]),
        ("one wrong ray", &[("certified", 1, 20.0)]),
        ("beside another that was never wrong", &[("stable", 1, 10.0), ("certified", 0, 20.0)]),
        (
            "steps of ten",
            &[("lecture", 10_000, 5.0), ("stable", 1000, 50.0), ("double", 100, 500.0)],
        ),
        (
            "each faster one more often wrong",
            &[("lecture", 900, 5.0), ("stable", 20, 6.0), ("certified", 0, 7.0)],
        ),
        ("stable is slow", &[("lecture", 900, 5.0), ("stable", 20, 9.0), ("certified", 0, 7.0)]),
    ] {
        let report = small(kernels);
        // The words that the ones before don't have.
        let terminal = text::terminal(&report);
        let words: Vec<&str> = terminal.lines().filter(|line| !text.contains(line)).collect();
        let plane = outline(&plot::plane(&report).svg());
        text += &format!("== {name}\n{}\n\n{plane}\n", words.join("\n"));
    }
    assert_kept("tests/shown/planes.txt", &text);
}

/// All that is drawn of a report.
fn drawn(report: &Report) -> Vec<String> {
    let sweeps = SWEEPS.iter().map(|sweep| plot::sweep(report, sweep).svg());
    std::iter::once(plot::plane(report).svg()).chain(sweeps).collect()
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
        for time in
            report.rows.iter_mut().filter_map(|row| row.numbers.get_mut(&Metric::TraceNsPerRay))
        {
            time.min *= shorter;
            time.max *= longer;
        }
        drawn(&report).iter().for_each(|svg| assert_legible(svg));
    }
}

/// A name, and the change.
type Change = (&'static str, fn(&mut Report));

/// Changes to the report that leave little, or odd numbers.
const CHANGES: [Change; 13] = [
    ("nothing changed", |_| {}),
    ("nothing at all", |report| {
        report.rows.clear();
        report.scenes.clear();
        report.missing.clear();
        report.pictures.clear();
        report.environment.adapters.clear();
    }),
    ("rows of nothing", |report| {
        for row in &mut report.rows {
            row.numbers.clear();
            row.counts.clear();
        }
    }),
    ("a kernel that lit one scene alone", |report| {
        report.rows.retain(|row| {
            !matches!(&row.key.of, Of::Light { scene } if scene == "shells")
                || row.key.kernel == "certified"
        });
    }),
    ("one scene", |report| report.rows.truncate(8)),
    ("the CPU alone", |report| {
        report.environment.adapters.clear();
        report.rows.retain(|row| row.key.device == "CPU");
    }),
    ("given scenes", |report| {
        for row in &mut report.rows {
            if let Of::Scene { class, .. } | Of::Class { class } = &mut row.key.of {
                *class = Class::Given;
            }
        }
    }),
    ("errors without bound", |report| {
        each_error(report, |t| (t.p999, t.max) = (f64::INFINITY, f64::INFINITY));
    }),
    ("no error", no_error),
    ("all wrong", |report| {
        for row in &mut report.rows {
            row.counts.extend([(Count::Rays, 9), (Count::FalseHits, 9), (Count::FalseMisses, 0)]);
            row.counts.insert(Count::WrongObject, 0);
        }
    }),
    ("times of nothing", |report| {
        let numbers = report.rows.iter_mut().flat_map(|row| row.numbers.values_mut());
        numbers.for_each(|time| *time = Spread { n: time.n, ..Spread::default() });
    }),
    ("sweeps of one point", |report| {
        report.rows.retain(|row| !matches!(row.key.of, Of::Sweep { x, .. } if x > 1.0));
    }),
    ("odd places", |report| {
        for row in &mut report.rows {
            if let Of::Sweep { x, .. } = &mut row.key.of {
                *x = match *x {
                    1.0 => 0.0,
                    10.0 => -1e300,
                    100.0 => f64::INFINITY,
                    x => x,
                };
            }
        }
    }),
];

fn each_error(report: &mut Report, change: fn(&mut Spread)) {
    let errors = [Metric::TUlp, Metric::TRelative, Metric::NormalDegrees];
    for (metric, spread) in report.rows.iter_mut().flat_map(|row| &mut row.numbers) {
        if errors.contains(metric) {
            change(spread);
        }
    }
}

fn no_error(report: &mut Report) {
    each_error(report, |errors| *errors = Spread { n: 9, ..Spread::default() });
    for row in &mut report.rows {
        row.counts.retain(|count, _| {
            ![Count::FalseHits, Count::FalseMisses, Count::WrongObject].contains(count)
        });
    }
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
        for shown in [&page, &text, &text::markdown(&report)] {
            assert!(!shown.contains("NaN"), "{what}: {shown}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= 110), "{what}: {text}");
    }
}

/// Changes of the rows of the sweep over distance.
fn along_distance(report: &mut Report) -> impl Iterator<Item = &mut Row> {
    let is_own =
        |row: &&mut Row| matches!(&row.key.of, Of::Sweep { sweep, .. } if sweep == "distance");
    report.rows.iter_mut().filter(is_own)
}

/// What the sweep over distance shows in its two panels: lines, how high it is, and what is said beside them.
fn distance(report: &Report) -> (usize, f64, Vec<&'static str>) {
    let svg = plot::sweep(report, &SWEEPS[0]).svg();
    let document = Document::parse(&svg).expect("XML");
    let height = document.root_element().attribute("height").expect("a height");
    let words = ["∞", "the same to the last bit", "class=\"band\""];
    let said = words.into_iter().filter(|words| svg.contains(words)).collect();
    (svg.matches("<polyline").count(), height.parse().expect("a number"), said)
}

/// Devices share a line where they are alike to the last bit, it has a gap where a row lacks, and what has no bound stands above
/// the axis. A panel without numbers has no axis.
#[test]
fn lines_are_what_the_rows_are() {
    let n = KERNELS.len();
    let errors = |row: &mut Row, change: fn(&mut Spread)| {
        row.numbers.get_mut(&Metric::TUlp).map(change).expect("errors");
    };
    let shown = |change: &dyn Fn(&mut Report)| {
        let mut report = report();
        change(&mut report);
        distance(&report)
    };
    let (n_lines, height, said) = shown(&|_| {});
    assert_eq!((n_lines, said.len()), (2 * n, 2));
    let one_differs = shown(&|report| {
        let row = along_distance(report).nth(3 * 8).expect("a row");
        errors(row, |t_ulp| t_ulp.median = t_ulp.median.next_up());
    });
    assert_eq!((one_differs.0, &one_differs.2), (2 * n + 2, &said));
    let all_differ = shown(&|report| {
        for row in along_distance(report).filter(|row| row.key.device == DEVICES[0]) {
            *row.counts.get_mut(&Count::Rays).expect("rays") += 1;
        }
    });
    assert_eq!((all_differ.0, &all_differ.2[..]), (4 * n, &said[1..]));
    let no_bound = |report: &mut Report| {
        along_distance(report)
            .skip(8 * 2 * n)
            .for_each(|row| errors(row, |t| t.p999 = f64::INFINITY));
    };
    let unbound = shown(&no_bound);
    assert_eq!((unbound.0, unbound.2[0]), (2 * n, "∞"));
    // Of the first kernel, on both devices.
    let gap = shown(&|report| {
        no_bound(report);
        for row in along_distance(report).skip(4 * 2 * n).step_by(n).take(2) {
            row.numbers.remove(&Metric::TUlp);
        }
    });
    assert_eq!(gap.0, 2 * n + 1);
    let strips = shown(&no_error);
    assert!(strips.1 < height - 300.0 && strips.2 == said, "{strips:?}");
}

const HOSTILE: &str =
    "</style><script>alert(1)</script>\"'&amp;|`*_\u{1b}[31m\u{202e}\n<img src=x onerror=y>";

#[test]
fn hostile_names_stay_names() {
    let mut report = report();
    let spoil = |key: &mut kugelblitz_report::RowKey| {
        key.kernel += HOSTILE;
        key.device += HOSTILE;
        if let Of::Scene { scene, .. } | Of::Light { scene } = &mut key.of {
            *scene += HOSTILE;
        }
    };
    report.rows.iter_mut().for_each(|row| spoil(&mut row.key));
    report.pictures.iter_mut().for_each(|picture| spoil(&mut picture.key));
    for scene in &mut report.scenes {
        scene.name += HOSTILE;
        scene.about = HOSTILE.into();
    }
    report.missing = vec![Missing { what: HOSTILE.into(), why: HOSTILE.into() }];
    let environment = &mut report.environment;
    environment.commit = Some(HOSTILE.into());
    for text in [&mut environment.command, &mut environment.host_cpu, &mut environment.system] {
        *text = HOSTILE.into();
    }
    environment.adapters[0].facts.name = HOSTILE.into();
    environment.adapters[0].facts.driver = HOSTILE.into();

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
    assert!(!markdown.contains("<script"), "{markdown}");
    // Summary, light and clouds: as many cells as columns.
    let rows = markdown.lines().filter(|line| line.starts_with('|'));
    let mut n_bars: Vec<usize> =
        rows.map(|row| row.replace("\\|", "").matches('|').count()).collect();
    n_bars.dedup();
    assert_eq!(n_bars, [7, 11, 8], "{markdown}");
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

/// The pictures of a page.
fn images(page: &str) -> Vec<image::RgbImage> {
    let sources = page.split("src=\"data:image/png;base64,").skip(1);
    sources
        .map(|source| {
            let data = source.split('"').next().expect("the end of the address");
            let png = base64::engine::general_purpose::STANDARD.decode(data).expect("base64");
            image::load_from_memory(&png).expect("a PNG").to_rgb8()
        })
        .collect()
}

#[test]
fn pictures_and_their_errors_are_shown_pixel_by_pixel() {
    let made = report();
    let of_kernel = |row: &&Row| row.key.kernel == "stable" && row.key.epsilon == Some(1e-3);
    let lit = made.rows.iter().find(of_kernel).expect("a row of light");
    let [right, large] = RAMP;
    for (key, name, colors) in [
        (&made.rows[1].key, "kernel stable", [FALSE_HIT, FALSE_MISS, WRONG_OBJECT, right, large]),
        (&lit.key, "kernel stable, ε = 10⁻³", [FALSE_HIT, WRONG_OBJECT, FALSE_HIT, right, large]),
    ] {
        let mut report = report();
        let words = ["3 wrong pixels (60 %)", "1 other"];
        report.settings.picture_size = [5, 1];
        report.pictures = vec![picture(key, [5, 1], &colors, words)];
        let page = page::html(&report);
        let images = images(&page);
        for i in 0..5u8 {
            let pixel = |image: usize| images[image].get_pixel(i.into(), 0).0;
            assert_eq!(pixel(0), [i, 2 * i, 3 * i]);
            assert_eq!(pixel(1), colors[usize::from(i)]);
        }
        // The legend has the same colours.
        for color in &colors[..3] {
            assert!(page.contains(&format!("background:{}", hex(*color))));
        }
        assert!(page.contains(&format!("linear-gradient(to right,{},{})", hex(right), hex(large))));
        for words in [words[0], words[1], &format!("{name}: its errors")] {
            assert!(page.contains(words), "{words}");
        }
    }
}

#[test]
fn a_section_without_data_has_no_place() {
    let mut report = report();
    for row in along_distance(&mut report) {
        row.numbers.clear();
        row.counts.clear();
    }
    let page = page::html(&report);
    assert!(!page.contains("Sweep: distance") && page.contains("Sweep: objects"));
    report.rows.retain(|row| matches!(row.key.of, Of::Light { .. }));
    let lit_alone = page::html(&report);
    for title in ["Time and error of each kernel", "Classes of scenes", "Sweep:", "<h2>Scenes</h2>"]
    {
        assert!(!lit_alone.contains(title), "{title}");
    }
    assert!(lit_alone.contains("<h2>Light</h2>") && !lit_alone.contains("<svg"));
}

#[test]
fn an_earlier_report_is_read_back_and_another_size_is_refused() {
    let mut made = report();
    // JSON has no infinity.
    each_error(&mut made, |errors| errors.max = f64::INFINITY);
    let mut earlier = serde_json::to_value(&made).unwrap();
    assert!(earlier["rows"][0]["numbers"]["t_ulp"]["max"].is_null());
    let rows: Vec<Row> = serde_json::from_value(earlier["rows"].clone()).unwrap();
    assert_eq!(rows, made.rows);
    (earlier["schema"], earlier["command"]) = (2.into(), "report".into());
    let parsed = |settings| Earlier::parse(&earlier.to_string(), &settings);
    assert!(parsed(Settings::default()).is_ok(), "the same size");
    let why = parsed(Settings { size: [320, 180], ..Settings::default() }).unwrap_err();
    assert!(why.contains("give --size 1280x720"), "{why}");
}
