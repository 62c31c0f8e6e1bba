//! The report is read as people read it: in a browser, with scripts off.
//!
//! To look at it: `GALLERY_FOLDER=/tmp cargo test -p inspector --test report`.

use std::path::Path;
use std::process::Command;

use inspector::figures::catalogue::Skipped;
use inspector::figures::model::{
    Axis, ColourBar, Content, Figure, Of, Panel, Picture, Point, Reference, Scale, Series,
};
use inspector::report::table::{Cell, Table};
use inspector::report::{Report, html};

const HOSTILE: &str = "<script>document.title = 'run'</script> & \"a\" 'b'";

fn point(x: f64, y: f64) -> Point {
    Point { x, y, spread: Some((0.9 * y, 1.2 * y)), n: 10, of: Of::detail(format!("sample {x}")) }
}

fn figure(name: &str, content: Content, scale: Scale) -> Figure {
    Figure {
        name: name.into(),
        title: format!("Figure {name} {HOSTILE}"),
        caption: format!("Caption {HOSTILE}"),
        settings: vec!["Adapter: a card".into()],
        panels: vec![Panel {
            title: String::new(),
            x: Axis { label: "bounce".into(), scale },
            y: Axis { label: "time (ms)".into(), scale: Scale::Linear { from_zero: true } },
            content,
            reference: Some(Reference { label: "break-even".into(), y: 1.0 }),
        }],
    }
}

fn sample() -> Report {
    let series = |style: usize| {
        Series::new(format!("series {style} {HOSTILE}"), style, vec![point(0.0, 1.5), point(1.0, 0.7)])
    };
    let names = Scale::Categories(vec!["camera".into(), HOSTILE.into()]);
    let ramp: Vec<[u8; 3]> = (0..=255).map(|level| [level, 128, 255 - level]).collect();
    let picture = Picture {
        width: 16,
        height: 16,
        rgb: ramp.clone(),
        colour_bar: Some(ColourBar { label: "rays".into(), range: (0.0, 255.0), colours: ramp }),
    };
    Report {
        title: format!("Report {HOSTILE}"),
        facts: vec![("scene".into(), HOSTILE.into()), ("adapter".into(), "a card".into())],
        pictures: vec![Picture { colour_bar: None, ..picture.clone() }],
        findings: vec![format!("aila pays {HOSTILE}")],
        tables: vec![Table {
            title: "Speedups".into(),
            caption: HOSTILE.into(),
            header: vec!["method".into(), "net speedup".into()],
            rows: vec![vec![Cell::plain(HOSTILE), Cell { text: "1.21".into(), is_best: true }]],
        }],
        figures: vec![
            figure("stages", Content::Stacks(vec![series(1), series(2), series(3)]), names.clone()),
            figure("speedups", Content::Dots(vec![series(1), series(2)]), names),
            figure("rates", Content::Lines(vec![series(1)]), Scale::Linear { from_zero: false }),
            figure("table", Content::Picture(picture), Scale::Linear { from_zero: true }),
        ],
        left_out: vec![format!("no recording {HOSTILE}")],
        skipped: vec![Skipped { figure: "correlation".into(), reason: format!("no capsules {HOSTILE}") }],
        commands: vec!["inspector report a.raydump --out page".into(), HOSTILE.into()],
    }
}

#[test]
fn the_page_needs_nothing_else_and_runs_nothing() {
    let page = html(&sample()).unwrap();
    assert!(!page.contains("<script"), "what was given as text became a script");
    let outside = |attribute: &str| {
        page.match_indices(attribute).any(|(at, _)| {
            let value = &page[at + attribute.len()..];
            !value.starts_with("\"#") && !value.starts_with("\"data:")
        })
    };
    assert!(!outside(" href=") && !outside(" src="), "the page loads something");
    assert!(!page.contains("url(http"), "the style loads something");
    assert_eq!(page.matches("@font-face").count(), 1);
    assert!(page.contains("1.5 (1.35 to 1.8), n = 10</title>"), "dots say their numbers");
}

#[test]
fn ids_are_unique_and_all_that_is_referred_to_is_there() {
    let page = html(&sample()).unwrap();
    let ids: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    for (at, id) in ids.iter().enumerate() {
        assert!(!ids[..at].contains(id), "{id} is there twice");
    }
    let links: Vec<&str> =
        page.split(" href=\"#").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(links.len() >= 4, "figures are listed");
    for link in links {
        assert!(ids.contains(&link), "{link} is nowhere");
    }
}

/// Chromium with these arguments; fails if it is not there.
fn chromium(profile: &Path, arguments: &[&str]) -> std::process::Output {
    let run = |program: &str| {
        Command::new(program)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--no-first-run",
            ])
            // The frame is drawn by the same process, and the picture waits for it.
            .args([
                "--hide-scrollbars",
                "--disable-features=IsolateSandboxedIframes",
                "--virtual-time-budget=10000",
            ])
            .arg(format!("--user-data-dir={}", profile.display()))
            .args(arguments)
            .output()
    };
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find_map(|program| run(program).ok())
        .expect(
            "a browser is needed to test the report, and the test does not skip: install chromium \
         (on Debian: apt-get install --no-install-recommends chromium)",
        )
}

#[test]
fn the_page_is_seen_in_a_browser_without_scripts() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("report.html");
    if let Some(kept) = std::env::var_os("GALLERY_FOLDER") {
        std::fs::write(Path::new(&kept).join("report.html"), html(&sample()).unwrap()).unwrap();
    }
    std::fs::write(&page, html(&sample()).unwrap()).unwrap();
    // A frame without permissions: the browser runs no script in it.
    let frame = folder.path().join("frame.html");
    let style = "position:fixed;inset:0;width:100%;height:100%;border:0";
    std::fs::write(&frame, format!("<iframe sandbox src=\"report.html\" style=\"{style}\"></iframe>"))
        .unwrap();
    let picture = folder.path().join("seen.png");
    let output = chromium(
        &folder.path().join("profile"),
        &[
            "--window-size=1000,2600",
            &format!("--screenshot={}", picture.display()),
            &format!("file://{}", frame.display()),
        ],
    );
    let said = String::from_utf8_lossy(&output.stderr);
    let bytes = std::fs::read(&picture).unwrap_or_else(|error| panic!("no picture: {error}\n{said}"));
    let seen = resvg::tiny_skia::Pixmap::decode_png(&bytes).unwrap();
    let count = |is_it: &dyn Fn([u8; 3]) -> bool| {
        let colours = seen.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]);
        colours.filter(|colour| is_it(*colour)).count()
    };
    // The bars of styles 1, 2 and 3, then text and axes.
    for bar in [[0x00, 0x72, 0xb2], [0xd5, 0x5e, 0x00], [0x00, 0x9e, 0x73]] {
        let pixels = count(&|colour| colour == bar);
        assert!(pixels > 500, "colour {bar:?} is on {pixels} pixels alone\n{said}");
    }
    let dark = count(&|colour| colour.iter().all(|&part| part < 0x50));
    assert!(dark > 3000, "{dark} dark pixels: no text or no axes\n{said}");
}
