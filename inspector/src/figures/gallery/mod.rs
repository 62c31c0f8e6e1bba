//! Draws sample figures of every kind and checks what a reader would: nothing overlaps, nothing is
//! cut, everything can be read, every number is in the files.
//!
//! To look at them: `GALLERY_FOLDER=gallery cargo test -p inspector gallery`.

mod boxes;
mod samples;

use std::fs;
use std::path::Path;

use resvg::{tiny_skia, usvg};

use super::layout::Layout;
use super::model::{Content, Figure, Point};
use super::style::Width;
use super::{csv, draw, files, pgfplots, raster, series};

const WIDTHS: [(Width, &str); 2] = [(Width::OneColumn, "one-column"), (Width::TwoColumn, "two-column")];

/// What is still read at column width, points.
const SMALLEST_TEXT: f32 = 8.0;

/// Rounding of coordinates and of font metrics, pixels.
const TOLERANCE: f32 = 0.5;

fn drawn() -> Vec<(String, Figure, Width, usvg::Tree)> {
    let mut drawn = Vec::new();
    for figure in samples::all() {
        for (width, word) in WIDTHS {
            let drawing = draw::draw(&figure, width, &figure.name).unwrap();
            drawn.push((
                format!("{} {word}", figure.name),
                figure.clone(),
                width,
                raster::tree(&drawing).unwrap(),
            ));
        }
    }
    drawn
}

#[test]
fn gallery_text_is_inside_the_page_apart_and_large_enough() {
    for (name, figure, width, tree) in drawn() {
        let texts = boxes::texts(&tree);
        let wanted = (width.points() * 96.0 / 72.0) as f32;
        assert!((tree.size().width() - wanted).abs() < 0.01, "{name}: {} wide", tree.size().width());
        assert!(texts.len() >= 2 || figure.name == "photograph", "{name}: no text");
        for text in &texts {
            for (x, y) in text.corners {
                let inside = x >= -TOLERANCE
                    && y >= -TOLERANCE
                    && x <= tree.size().width() + TOLERANCE
                    && y <= tree.size().height() + TOLERANCE;
                assert!(inside, "{name}: {:?} is cut at {x}, {y}", text.words);
            }
            // Pixels of CSS are 3/4 of a point.
            assert!(text.size * 0.75 >= SMALLEST_TEXT - 0.01, "{name}: {:?} is small", text.words);
        }
        for (at, text) in texts.iter().enumerate() {
            for other in &texts[..at] {
                assert!(
                    !boxes::overlap(text, other, TOLERANCE),
                    "{name}: {:?} on {:?}",
                    text.words,
                    other.words
                );
            }
        }
    }
}

/// Panels of a figure that belong together look alike.
#[test]
fn gallery_pictures_are_in_pairs_and_words_at_one_angle() {
    let mut seen = 0;
    for (name, figure, width, _) in drawn() {
        let layout = Layout::new(&figure, width);
        let turns: Vec<i32> = layout.plots.iter().map(|plot| plot.margins.turn.degrees()).collect();
        assert!(turns.iter().all(|turn| *turn == turns[0]), "{name}: labels at {turns:?} degrees");
        // Slanted words are read more easily than upright ones.
        assert!(figure.name != "speedups" || turns[0] == 45, "{name}: labels at {turns:?} degrees");
        if figure.name == "pixel-costs" {
            assert_eq!(layout.columns, 2, "{name}");
            for pair in layout.plots.chunks(2) {
                let ([left, right], aspect) = ([&pair[0], &pair[1]], 36.0 / 64.0);
                assert_eq!(left.height, right.height, "{name}: a pair is not of one height");
                for plot in pair {
                    assert!((plot.height / plot.width - aspect).abs() < 1e-6, "{name}: not as it was");
                }
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 6);
}

/// On a logarithmic axis every bar stands on its lower end, and none takes the room of one that is missing.
#[test]
fn gallery_bars_stand_on_the_axis_and_close_ranks() {
    let figure = samples::all().into_iter().find(|figure| figure.name == "bandwidths").unwrap();
    let layout = Layout::new(&figure, Width::TwoColumn);
    let Content::Bars(all) = &layout.plots[0].panel.content else { panic!("bars") };
    for plot in &layout.plots {
        let points = plot.panel.content.series().iter().flat_map(|series| &series.points);
        let places: Vec<f64> = points.filter_map(|point| plot.y.place(point.y)).collect();
        assert!(plot.y.base() == plot.y.range.0 && places.iter().all(|place| *place > 0.01), "{places:?}");
    }
    let places = |category| -> Vec<f64> {
        let with_bar = all
            .iter()
            .enumerate()
            .filter(|(_, series)| series.points.iter().any(|point| point.x == category));
        with_bar.map(|(at, _)| series::place_in_group(all, at, category)).collect()
    };
    assert_eq!(series::largest_group(all), 9);
    assert_eq!(places(3.0), [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(places(0.0), [-3.5, -2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 3.5]);
    let files = pgfplots::files(&figure, Width::TwoColumn).unwrap();
    let [(_, tex), (_, numbers), _] = &files[..] else { panic!("{} files", files.len()) };
    assert!(String::from_utf8_lossy(tex).contains("log origin y=infty"));
    // The bar of the first series at category 3 is the leftmost of nine.
    let mut rows = ::csv::Reader::from_reader(numbers.as_slice()).into_deserialize::<Vec<f64>>();
    assert!((2.5..2.8).contains(&rows.next().unwrap().unwrap()[0]));
}

#[test]
fn gallery_panels_are_not_empty() {
    for (name, figure, _, tree) in drawn() {
        let marks = boxes::count_marks(&tree);
        let least: usize = figure
            .panels
            .iter()
            .map(|panel| match &panel.content {
                Content::Picture(_) => 1,
                content => content.series().iter().map(|series| series.points.len().min(6)).sum(),
            })
            .sum();
        assert!(marks >= least, "{name}: {marks} marks, expected {least} at least");
    }
}

/// All points, each with the number of its series in the figure.
fn numbers_of(figure: &Figure) -> Vec<(usize, &Point)> {
    let series = figure.panels.iter().flat_map(|panel| panel.content.series()).enumerate();
    series.flat_map(|(curve, series)| series.points.iter().map(move |point| (curve, point))).collect()
}

#[test]
fn gallery_csv_holds_every_number() {
    for figure in samples::all() {
        let bytes = csv::write(&figure).unwrap();
        let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
        let header = reader.headers().unwrap().clone();
        let first = &figure.panels[0];
        for (at, label) in [(5, &first.x.label), (6, &first.y.label)] {
            let word = label.split([' ', ',']).next().unwrap();
            assert!(header[at].contains(word), "{}: no {label} in {header:?}", figure.name);
        }
        let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let curves: Vec<_> = rows.iter().filter(|row| !row[0].is_empty()).collect();
        let points = numbers_of(&figure);
        assert_eq!(curves.len(), points.len(), "{}", figure.name);
        for (row, (curve, point)) in curves.iter().zip(points) {
            assert_eq!(row[0].parse(), Ok(curve));
            let number = |at: usize| row[at].parse::<f64>().ok();
            let spread = number(7).zip(number(8));
            assert_eq!((number(5), number(6), spread), (Some(point.x), Some(point.y), point.spread));
            assert_eq!(row[9].parse(), Ok(point.n));
        }
        for reference in figure.panels.iter().flat_map(|panel| &panel.reference) {
            let is_it =
                |row: &::csv::StringRecord| row[2] == reference.label && row[6].parse() == Ok(reference.y);
            assert!(rows.iter().any(is_it), "{}: {}", figure.name, reference.label);
        }
    }
}

/// What pgfplots reads: each series in columns of its own.
#[test]
fn gallery_panels_have_tables_for_pgfplots() {
    for figure in samples::all() {
        let files = pgfplots::files(&figure, Width::OneColumn).unwrap();
        let plots = figure.panels.iter().zip(&files[1..]);
        for (panel, (name, table)) in plots.filter(|(panel, _)| !panel.content.series().is_empty()) {
            let rows = ::csv::Reader::from_reader(table.as_slice()).into_deserialize::<Vec<f64>>();
            let rows: Vec<Vec<f64>> = rows.map(Result::unwrap).collect();
            for (at, series) in panel.content.series().iter().enumerate() {
                for point in &series.points {
                    let (low, high) = point.spread.unwrap_or((point.y, point.y));
                    let is_it = |row: &Vec<f64>| {
                        row[4 * at + 1..4 * at + 4] == [point.y, point.y - low, high - point.y]
                    };
                    assert!(rows.iter().any(is_it), "{name}: {point:?} of series {at}");
                }
            }
        }
    }
}

#[test]
fn gallery_files_are_what_their_names_say() {
    let temporary = tempfile::tempdir().unwrap();
    let kept = std::env::var_os("GALLERY_FOLDER");
    let root = kept.as_deref().map_or(temporary.path(), Path::new);
    for figure in samples::all() {
        for (width, word) in WIDTHS {
            let folder = root.join(word);
            files::make_folder(&folder).unwrap();
            let paths = files::write(&figure, width, &folder).unwrap();
            assert_eq!(paths.len(), 6 + figure.panels.len());
            let read =
                |extension: &str| fs::read(folder.join(format!("{}.{extension}", figure.name))).unwrap();
            let png = tiny_skia::Pixmap::decode_png(&read("png")).unwrap();
            assert_eq!(f64::from(png.width()), width.points() / 72.0 * 300.0, "{}", figure.name);
            let pdf = read("pdf");
            assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
            let media_box = format!("/MediaBox[0 0 {} ", width.points());
            let has = |text: &str| pdf.windows(text.len()).any(|window| window == text.as_bytes());
            assert!(has(&media_box), "{}: the PDF is not {} points wide", figure.name, width.points());
            assert!(
                figure.name == "photograph" || has("LiberationSans"),
                "{}: no font in the PDF",
                figure.name
            );
            let tex = String::from_utf8(read("tex")).unwrap();
            for series in figure.panels.iter().flat_map(|panel| panel.content.series()) {
                let word = series.label.split(['_', ' ']).next().unwrap();
                assert!(tex.contains(&format!("}} {word}")), "{}: no {word}", figure.name);
                assert!(tex.contains(&format!("{{{}-panel-1.csv}}", figure.name)));
            }
            let caption = String::from_utf8(read("txt")).unwrap();
            assert!(caption.contains(&figure.caption) && caption.contains(&figure.settings[1]));
        }
    }
    assert!(
        !fs::read_dir(root.join("one-column"))
            .unwrap()
            .any(|file| { file.unwrap().path().extension().is_some_and(|extension| extension == "partial") })
    );
}

#[test]
fn a_folder_that_cannot_be_written_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    let error = files::make_folder(&file.join("figures")).unwrap_err().to_string();
    assert!(error.starts_with("cannot write ") && error.contains("figures: "), "{error}");
    let figure = &samples::all()[8];
    let error = files::write(figure, Width::OneColumn, &folder.path().join("none")).unwrap_err().to_string();
    assert!(error.contains(&figure.name), "{error}");
}
