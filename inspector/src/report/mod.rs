//! One HTML page that says everything about some recordings, and needs nothing beside it; its tables for other
//! documents.
//!
//! - [`table`]: a table, and how it is written
//! - [`tables`]: which ones there are

pub mod table;
pub mod tables;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::figures::catalogue::Skipped;
use crate::figures::model::{Content, Figure, Picture};
use crate::figures::style::{FONT, FONT_FAMILY, Width};
use crate::figures::svg::escape;
use crate::figures::{FigureError, draw, raster};
use table::Table;

/// What a report says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Heading of the page.
    pub title: String,
    /// Pictures of the scenes, the photographs of figure `pixel-cost`.
    pub pictures: Vec<Picture>,
    /// What all of it says, a sentence each.
    pub findings: Vec<String>,
    /// The numbers.
    pub tables: Vec<Table>,
    /// The figures; the first of [`LEADS`] that is there comes before the tables.
    pub figures: Vec<Figure>,
    /// Why other recordings are not in it, a sentence each.
    pub left_out: Vec<String>,
    /// What was recorded, where and how: names and values.
    pub facts: Vec<(String, String)>,
    /// Figures that could not be made.
    pub skipped: Vec<Skipped>,
    /// Command lines that make all of this again.
    pub commands: Vec<String>,
}

/// The figures that a reader sees first, where they are there.
pub const LEADS: [&str; 2] = ["study-speedup", "net-speedup"];

/// What the browser lets the page do: show what is in it. Nothing is run, nothing is loaded.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:";

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1a1a1a; --page: #ffffff; --soft: #f3f4f6; --line: #d4d7dc; --faint: #5a6270; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e8eb; --page: #15181d; --soft: #20252c; --line: #3a414b; --faint: #a4acb8; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 1.5rem; font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--page); }
h1 { font-size: 1.7rem; margin: 0 0 1rem; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 .7rem; border-bottom: 1px solid var(--line); padding-bottom: .2rem; }
h3 { font-size: 1.05rem; margin: 0 0 .5rem; }
nav ul { columns: 18rem; padding-left: 1.2rem; }
a { color: inherit; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th { color: var(--faint); font-weight: 600; white-space: normal; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; }
.facts th, .facts td { text-align: left; }
.facts td { white-space: normal; overflow-wrap: anywhere; }
.facts th { vertical-align: top; white-space: normal; }
@media (max-width: 40rem) {
  body { padding: .8rem; }
  .facts tr, .facts th, .facts td { display: block; }
  .facts th { border: 0; padding-bottom: 0; }
  .paper:not(.lead) svg { min-width: 40rem; }
}
.note { color: var(--faint); font-size: .88rem; margin: 0 0 .4rem; }
.findings { font-size: 1.05rem; padding-left: 1.2rem; }
.scenes { display: flex; flex-wrap: wrap; gap: .5rem; }
.scenes img { width: 15rem; max-width: 48%; height: auto; border-radius: 4px; }
figure { margin: 1.5rem 0 2.5rem; break-inside: avoid; }
.paper { background: #ffffff; border: 1px solid var(--line); border-radius: 4px; padding: .6rem; overflow-x: auto; }
.paper svg { display: block; width: 100%; height: auto; max-width: 60rem; margin: 0 auto; }
.lead svg { max-width: 34rem; }
@media (prefers-color-scheme: dark) {
  .paper { filter: invert(1) hue-rotate(180deg); mix-blend-mode: screen; border-color: #c5c8cd; }
  .paper image { filter: invert(1) hue-rotate(180deg); }
}
figcaption { margin-top: .6rem; }
pre { background: var(--soft); border: 1px solid var(--line); padding: .8rem; overflow-x: auto; white-space: pre-wrap; overflow-wrap: anywhere; }
@media print {
  :root { --ink: #000; --page: #fff; --soft: #fff; --line: #999; --faint: #333; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  nav { display: none; }
  .paper { border: none; padding: 0; }
  .paper svg { max-height: 22cm; }
  .wide { overflow-x: visible; }
  .wide table { font-size: 6.5pt; }
  .wide th, .wide td { padding: .1rem .2rem; white-space: normal; overflow-wrap: anywhere; }
}
";

/// The page. It has no scripts, loads nothing, and follows the reader's light or dark colours; in print everything is
/// on white. Numbers are shown where a bar or a point is pointed at. What was recorded and how stands once, at the end.
///
/// # Errors
/// If a figure cannot be drawn.
pub fn html(report: &Report) -> Result<String, FigureError> {
    let title = escape(&report.title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n@font-face {{ font-family: \"{FONT_FAMILY}\"; src: url(data:font/ttf;base64,{}); }}\n{STYLE}</style>\n\
         </head>\n<body>\n<h1>{title}</h1>\n",
        STANDARD.encode(FONT)
    );
    let mut pictures = Vec::new();
    for picture in &report.pictures {
        let png = STANDARD.encode(raster::picture_png(&shrunk(picture))?);
        pictures.push(format!("<img alt=\"the scene\" src=\"data:image/png;base64,{png}\">\n"));
    }
    section(&mut page, "<div class=\"scenes\">\n", pictures.into_iter(), "</div>\n");
    let findings = report.findings.iter().map(|finding| format!("<li>{}</li>\n", escape(finding)));
    section(&mut page, "<ul class=\"findings\">\n", findings, "</ul>\n");
    let lead = LEADS.iter().find(|name| report.figures.iter().any(|figure| figure.name == **name));
    let is_lead = |(_, figure): &(usize, &Figure)| lead.is_some_and(|lead| figure.name == *lead);
    let (lead, others): (Vec<_>, Vec<_>) = report.figures.iter().enumerate().partition(is_lead);
    for (at, figure) in lead {
        page.push_str(&figure_section(at, figure, Width::OneColumn)?);
    }
    section(&mut page, "<h2>Numbers</h2>\n", report.tables.iter().map(table::html), "");
    let entries = others.iter().map(|(at, figure)| {
        format!("<li><a href=\"#figure-{}\">{}</a></li>\n", at + 1, escape(&figure.title))
    });
    let start = "<h2 id=\"figures\">Figures</h2>\n<nav aria-label=\"Figures\"><ul>\n";
    section(&mut page, start, entries, "</ul></nav>\n");
    for (at, figure) in others {
        page.push_str(&figure_section(at, figure, Width::TwoColumn)?);
    }
    let rows = report.facts.iter().map(|(name, value)| {
        format!("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape(name), escape(value))
    });
    section(&mut page, "<h2>What was recorded</h2>\n<table class=\"facts\">\n", rows, "</table>\n");
    let items = report.left_out.iter().map(|why| format!("<li>{}</li>\n", escape(why)));
    section(&mut page, "<h2>Recordings left out</h2>\n<ul>\n", items, "</ul>\n");
    let items = report.skipped.iter().map(|Skipped { figure, reason }| {
        format!("<li><b>{}</b>: {}</li>\n", escape(figure), escape(reason))
    });
    section(&mut page, "<h2>Figures left out</h2>\n<ul>\n", items, "</ul>\n");
    let commands: Vec<String> = report.commands.iter().map(|line| escape(line)).collect();
    let lines = (!commands.is_empty()).then(|| commands.join("\n"));
    section(&mut page, "<h2>How to repeat it</h2>\n<pre><code>", lines.into_iter(), "</code></pre>\n");
    page.push_str("</body>\n</html>\n");
    Ok(page)
}

/// Most pixels across a picture of the page: a dozen at full size would make it one of a hundred megabytes.
const MOST_PIXELS: u32 = 640;

/// A picture no wider than the page needs: means of squares of pixels.
fn shrunk(picture: &Picture) -> Picture {
    let side = picture.width.div_ceil(MOST_PIXELS).max(1);
    if side == 1 || picture.rgb.len() != picture.width as usize * picture.height as usize {
        return picture.clone();
    }
    let (width, height) = (picture.width / side, (picture.height / side).max(1));
    let mean = |at: u32| {
        let (left, top) = (at % width * side, at / width * side);
        let mut sums = [0u32; 3];
        let mut count = 0;
        for y in top..(top + side).min(picture.height) {
            for pixel in &picture.rgb[(y * picture.width + left) as usize..][..side as usize] {
                sums.iter_mut().zip(pixel).for_each(|(sum, part)| *sum += u32::from(*part));
                count += 1;
            }
        }
        sums.map(|sum| (sum / count) as u8)
    };
    Picture { width, height, rgb: (0..width * height).map(mean).collect(), ..picture.clone() }
}

/// A figure whose pictures are no larger than the page needs.
fn lightened(figure: &Figure) -> Figure {
    let mut figure = figure.clone();
    for panel in &mut figure.panels {
        if let Content::Picture(picture) = &mut panel.content {
            *picture = shrunk(picture);
        }
    }
    figure
}

/// Adds parts between a start and an end; nothing if there are none.
fn section(page: &mut String, start: &str, parts: impl Iterator<Item = String>, end: &str) {
    let parts: String = parts.collect();
    if !parts.is_empty() {
        page.extend([start, &parts, end]);
    }
}

fn figure_section(at: usize, figure: &Figure, width: Width) -> Result<String, FigureError> {
    let number = at + 1;
    let drawing = draw::draw(&lightened(figure), width)?;
    let class = if width == Width::OneColumn { "paper lead" } else { "paper" };
    Ok(format!(
        "<figure id=\"figure-{number}\">\n<h3>{}</h3>\n<div class=\"{class}\">\n{drawing}</div>\n\
         <figcaption>{}</figcaption>\n</figure>\n",
        escape(&figure.title),
        escape(&figure.caption),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_pictures_are_shrunk_to_means() {
        let (width, height) = (1281, 4);
        let rgb = (0..width * height).map(|at| [if at % width % 3 == 2 { 90 } else { 0 }, 30, 0]).collect();
        let picture = Picture { width, height, rgb, colour_bar: None };
        let small = shrunk(&picture);
        assert_eq!((small.width, small.height, small.rgb.len()), (427, 1, 427));
        assert!(small.rgb.iter().all(|pixel| *pixel == [30, 30, 0]), "a third of the pixels has 90");
        assert_eq!(shrunk(&small), small);
    }
}
