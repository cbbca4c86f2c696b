//! How a report is shown: the figures on the terminal, in the page and in the plots are those of
//! the report, whatever it holds.

use base64::Engine;
use kugelblitz_report::{
    Class, Count, Earlier, Fault, Metric, Missing, Noise, Of, Report, Row, SWEEPS, Settings,
    Spread, page, plot, text,
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
    let sweeps = SWEEPS.iter().map(|sweep| plot::sweep(report, sweep));
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

fn distance(report: &Report) -> String {
    plot::sweep(report, &SWEEPS[0])
}

#[test]
fn a_line_has_a_gap_and_what_has_no_bound_stands_above_the_axis() {
    let mut report = report();
    let curves = |report: &Report| distance(report).matches("<polyline").count();
    let (whole, n_alike) = (curves(&report), 2 * KERNELS.len());
    assert!(!distance(&report).contains('∞'));
    for row in along_distance(&mut report).skip(8 * n_alike) {
        row.numbers.get_mut(&Metric::TUlp).expect("errors").p999 = f64::INFINITY;
    }
    assert!(distance(&report).contains('∞'));
    assert!(text::terminal(&report).contains('∞') && page::html(&report).contains('∞'));
    // Of the first kernel, on both devices.
    for row in along_distance(&mut report).skip(4 * n_alike).step_by(KERNELS.len()).take(2) {
        row.numbers.remove(&Metric::TUlp);
    }
    assert_eq!(curves(&report), whole + 1);
}

#[test]
fn devices_share_a_line_where_they_are_alike_to_the_last_bit() {
    let mut report = report();
    let lines = |report: &Report| {
        let svg = distance(report);
        // Two panels.
        (svg.matches("<polyline").count() / 2, svg.contains("the same to the last bit"))
    };
    assert_eq!(lines(&report), (KERNELS.len(), true));
    let row = along_distance(&mut report).nth(3 * 8).expect("a row");
    let t_ulp = row.numbers.get_mut(&Metric::TUlp).expect("errors");
    t_ulp.median = t_ulp.median.next_up();
    assert_eq!(lines(&report), (KERNELS.len() + 1, true));
    for row in along_distance(&mut report).filter(|row| row.key.device == DEVICES[0]) {
        *row.counts.get_mut(&Count::Rays).expect("rays") += 1;
    }
    assert_eq!(lines(&report), (2 * KERNELS.len(), false));
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
    let ray = Fault::TUlp;
    let of_rays = [
        Fault::Right,
        Fault::FalseHit,
        Fault::FalseMiss,
        Fault::WrongObject,
        ray(0.1),
        ray(100.0),
        ray(1e9),
        ray(f64::INFINITY),
    ];
    let byte = Fault::Levels;
    let of_light = [
        Fault::Right,
        Fault::FalseShadow,
        Fault::Leak,
        Fault::Leak,
        byte(1),
        byte(12),
        byte(64),
        byte(255),
    ];
    let made = report();
    let of_kernel = |row: &&Row| row.key.kernel == "stable" && row.key.epsilon == Some(1e-3);
    let lit = made.rows.iter().find(of_kernel).expect("a row of light");
    for (key, faults, words) in [
        (&made.rows[1].key, of_rays, &["3 wrong pixels (38 %)", "kernel stable: its errors"][..]),
        (
            &lit.key,
            of_light,
            &[
                "3 wrong shadows (38 %)",
                "4 other wrong pixels (50 %)",
                "kernel stable, ε = 10⁻³: its errors",
            ][..],
        ),
    ] {
        let mut report = report();
        report.pictures = vec![picture(key, [4, 2], &faults)];
        let page = page::html(&report);
        let images = images(&page);
        let pixel = |image: usize, i: u32| images[image].get_pixel(i % 4, i / 4).0;
        for i in 0..8u8 {
            assert_eq!(pixel(0, i.into()), [i, 2 * i, 3 * i, 255]);
        }
        assert_eq!(pixel(1, 0)[3], 0, "what is right is transparent");
        assert_eq!(pixel(1, 6), pixel(1, 7), "beyond the scale");
        for i in 1..7 {
            let alike = (i + 1..7).filter(|j| pixel(1, i) == pixel(1, *j)).count() as u32;
            assert_eq!(alike, u32::from(i < 4 && faults[i as usize] == faults[i as usize + 1]));
        }
        assert!([4, 5, 6].map(|i| pixel(1, i)[3]).is_sorted_by(|a, b| a < b));
        // The legend has the same colours.
        for [r, g, b, _] in [1, 2, 3].map(|i| pixel(1, i)) {
            assert!(page.contains(&format!("background:#{r:02x}{g:02x}{b:02x}")));
        }
        for words in words {
            assert!(page.contains(words), "{words}");
        }
    }
}

#[test]
fn a_panel_without_numbers_has_no_axis_and_a_section_without_data_no_place() {
    let mut report = report();
    let height = |report: &Report| {
        let svg = distance(report);
        let document = Document::parse(&svg).expect("XML");
        document.root_element().attribute("height").unwrap().parse::<f64>().unwrap()
    };
    let whole = height(&report);
    no_error(&mut report);
    // Both panels are strips of zeros.
    assert!(height(&report) < whole - 300.0, "{whole} {}", height(&report));
    let svg = distance(&report);
    assert!(svg.contains("class=\"band\"") && !svg.contains("10⁻"), "{svg}");
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
    let earlier = Earlier::parse(&earlier.to_string()).unwrap();
    assert!(earlier.check(&Settings::default()).is_ok(), "the same size");
    let why = earlier.check(&Settings { size: [320, 180], ..Settings::default() }).unwrap_err();
    assert!(why.contains("give --size 1280x720"), "{why}");
}
