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
use super::model::{Content, Figure};
use super::style::Width;
use super::{csv, draw, files, legend, pgfplots, raster};

const WIDTHS: [(Width, &str); 2] = [(Width::OneColumn, "one-column"), (Width::TwoColumn, "two-column")];

/// What is still read at column width, points.
const SMALLEST_TEXT: f32 = 8.0;

/// Rounding of coordinates and of font metrics, pixels.
const TOLERANCE: f32 = 0.5;

fn drawn() -> Vec<(String, Figure, Width, usvg::Tree)> {
    let mut drawn = Vec::new();
    for figure in samples::all() {
        for (width, word) in WIDTHS {
            let drawing = draw::draw(&figure, width).unwrap();
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

#[test]
fn gallery_pictures_are_in_pairs() {
    let mut seen = 0;
    for (name, figure, width, _) in drawn().into_iter().filter(|(_, figure, ..)| figure.name == "pixel-costs")
    {
        let layout = Layout::new(&figure, width);
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
    assert_eq!(seen, 6);
}

/// The legend has what rows do not say, and no part of anything.
#[test]
fn gallery_rows_name_what_the_legend_does_not() {
    let labels = |name: &str| -> Vec<String> {
        let figure = samples::all().into_iter().find(|figure| figure.name == name).unwrap();
        legend::entries(&figure, false).into_iter().map(|entry| entry.label).collect()
    };
    assert_eq!(labels("frames"), ["unsorted"], "the line across alone");
    assert_eq!(labels("twenty-rows"), ["series 0", "series 1", "series 2", "break-even"]);
}

/// A row has the spread of the number that it is about, not those of its parts.
#[test]
fn gallery_parts_have_no_spreads() {
    let figure = samples::all().into_iter().find(|figure| figure.name == "frames").unwrap();
    let files = pgfplots::files(&figure, Width::OneColumn).unwrap();
    let tex = String::from_utf8(files[0].1.clone()).unwrap();
    let plots: Vec<bool> = tex
        .lines()
        .filter(|line| line.starts_with("\\addplot"))
        .map(|line| line.contains("error bars"))
        .collect();
    let expected: Vec<bool> =
        figure.panels[0].content.series().iter().map(|series| !series.is_part).collect();
    assert_eq!(plots, expected);
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

#[test]
fn gallery_csv_holds_every_number() {
    for figure in samples::all() {
        let bytes = csv::write(&figure).unwrap();
        let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
        let header = reader.headers().unwrap().clone();
        let at = |name: &str| header.iter().position(|column| column == name).unwrap();
        let [detail, metric, value, low, high, n] = ["detail", "metric", "value", "low", "high", "n"].map(at);
        let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let mut rest = rows.as_slice();
        for panel in &figure.panels {
            for point in panel.content.series().iter().flat_map(|series| &series.points) {
                let row;
                (row, rest) = rest.split_first().unwrap();
                let number = |at: usize| row[at].parse::<f64>().ok();
                assert_eq!((number(value), number(low).zip(number(high))), (Some(point.y), point.spread));
                assert_eq!((row[n].parse(), &row[metric]), (Ok(point.n), panel.y.label.as_str()));
                assert!(row[detail].contains(&point.of.detail), "{}: {row:?}", figure.name);
            }
            if let Some(reference) = &panel.reference {
                let row;
                (row, rest) = rest.split_first().unwrap();
                assert!(row[detail].ends_with(&reference.label) && row[value].parse() == Ok(reference.y));
            }
            if let Content::Picture(picture) = &panel.content {
                rest = &rest[picture.colour_bar.as_ref().map_or(0, |bar| bar.colours.len())..];
            }
        }
        assert!(rest.is_empty(), "{}: {rest:?}", figure.name);
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
            assert_eq!(paths.len(), 7 + figure.panels.len());
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
                let has = |start: &str| tex.contains(&format!("{start}{word}"));
                assert!(has("} ") || has("{"), "{}: no {word}", figure.name);
                assert!(tex.contains(&format!("{{{}-panel-1.csv}}", figure.name)));
            }
            let caption = String::from_utf8(read("txt")).unwrap();
            assert!(caption.contains(&figure.caption) && caption.contains(&figure.settings[1]));
            let caption = String::from_utf8(read("caption.tex")).unwrap();
            assert!(caption.lines().count() == 1 && !caption.contains('×'), "{caption}");
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
