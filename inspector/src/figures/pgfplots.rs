//! The same figure for LaTeX: a standalone file that draws with pgfplots what it reads from one CSV a panel.

use std::fmt::Write;

use super::FigureError;
use super::axis::{Mapping, Tick};
use super::layout::{Layout, Plot};
use super::legend::{LegendEntry, Sample, entries};
use super::model::{Axis, Content, Figure, Panel, Picture, Point, Scale, Series};
use super::series::{STACK_HEIGHT, has_spreads, marker_stride};
use super::style::{Marker, REFERENCE_DASH, Style, Width, style};
use super::{csv, raster};

/// What every file starts with.
const HEAD: &str = r"% Compile with pdflatex; the numbers and pictures of the panels must lie beside this file.
\documentclass[border=2pt]{standalone}
\usepackage[utf8]{inputenc}
\usepackage{pgfplots}
\pgfplotsset{compat=1.16}
\usepgfplotslibrary{groupplots}
\renewcommand{\familydefault}{\sfdefault}
";

/// The files that draw a figure, with their names: NAME.tex, and of each panel its numbers
/// (NAME-panel-1.csv) or its pixels (NAME-panel-1.png).
///
/// # Errors
/// If a picture has another number of pixels than its sides say.
pub fn files(figure: &Figure, width: Width) -> Result<Vec<(String, Vec<u8>)>, FigureError> {
    let layout = Layout::new(figure, width);
    let mut files = vec![(format!("{}.tex", figure.name), tex(figure, width, &layout).into_bytes())];
    for (at, plot) in layout.plots.iter().enumerate() {
        files.push(match &plot.panel.content {
            Content::Picture(picture) => (panel_file(figure, at, "png"), raster::picture_png(picture)?),
            content => (panel_file(figure, at, "csv"), csv::panel(&columns(plot, content))?),
        });
    }
    Ok(files)
}

fn panel_file(figure: &Figure, panel: usize, extension: &str) -> String {
    format!("{}-panel-{}.{extension}", figure.name, panel + 1)
}

/// The points of each series.
fn columns(plot: &Plot, content: &Content) -> Vec<Vec<Point>> {
    let of_series = |series: &Series| match (content, &plot.panel.x.scale) {
        // A stack must not lack a category.
        (Content::Stacks(_), Scale::Categories(names)) => {
            let of_category = |x: usize| {
                let point = series.points.iter().find(|point| point.x == x as f64 && point.y.is_finite());
                point.cloned().unwrap_or(csv::bare_point(x as f64, 0.0, ""))
            };
            (0..names.len()).map(of_category).collect()
        }
        _ => series.points.clone(),
    };
    content.series().iter().map(of_series).collect()
}

/// The LaTeX source of a figure: the same axes in the same places as in the SVG.
fn tex(figure: &Figure, width: Width, layout: &Layout) -> String {
    let mut tex = HEAD.to_owned();
    for number in styles_of(figure) {
        let hex = style(number).colour.hex().to_uppercase();
        let ink = style(number).colour.ink().hex().to_uppercase();
        let _ = writeln!(tex, "\\definecolor{{style{number}}}{{HTML}}{{{hex}}}");
        let _ = writeln!(tex, "\\definecolor{{line{number}}}{{HTML}}{{{ink}}}");
    }
    tex.push_str("\\begin{document}\n\\footnotesize\n");
    tex.push_str(&group_start(layout));
    for (at, plot) in layout.plots.iter().enumerate() {
        let panel = plot.panel;
        let _ = writeln!(tex, "\\nextgroupplot[{}]", axis_options(plot, layout.row));
        if let Content::Picture(picture) = &panel.content {
            tex.push_str(&picture_plot(picture, &panel_file(figure, at, "png")));
        }
        for (number, series) in panel.content.series().iter().enumerate() {
            let look = series_look(&panel.content, series);
            let _ = writeln!(
                tex,
                "\\addplot[{look}] table[col sep=comma, {}]{{{}}};",
                columns_of(&panel.content, number),
                panel_file(figure, at, "csv")
            );
        }
    }
    tex.push_str("\\end{groupplot}\n");
    tex.push_str(&legend(&entries(figure, false), width));
    tex.push_str("\\end{tikzpicture}\n\\end{document}\n");
    tex
}

fn group_start(layout: &Layout) -> String {
    let (columns, rows) = (layout.columns, layout.plots.len().div_ceil(layout.columns));
    let largest = |part: fn(&Plot) -> f64| layout.plots.iter().map(part).fold(0.0, f64::max);
    let between = |part: fn(&Plot) -> f64, skipped: usize| {
        let plots = layout.plots.iter().enumerate().filter(|(at, _)| at % columns != skipped);
        plots.map(|(_, plot)| part(plot)).fold(0.0, f64::max)
    };
    let beside = between(|plot| plot.margins.left, 0) + between(|plot| plot.margins.right, columns - 1) + 4.0;
    let above = largest(|plot| plot.top) + largest(|plot| plot.bottom) + 12.0;
    format!(
        "\\begin{{tikzpicture}}\n\\begin{{groupplot}}[\n  group style={{group size={columns} by {rows}, \
         horizontal sep={beside:.0}bp, vertical sep={above:.0}bp}},\n  \
         scale only axis, grid style={{black!12}}, tick align=outside, tick pos=left,\n  \
         unbounded coords=jump, title style={{font=\\small, align=center}}, label style={{align=center}},\n]\n"
    )
}

fn styles_of(figure: &Figure) -> std::collections::BTreeSet<usize> {
    figure.panels.iter().flat_map(|panel| panel.content.series()).map(|series| series.style).collect()
}

/// Axis labels, scales, ticks and how bars stand.
fn axis_options(plot: &Plot, row: f64) -> String {
    let panel = plot.panel;
    let mut options = vec![
        format!("width={:.1}bp, height={:.1}bp", plot.width, plot.height),
        format!("title={{{}}}", lines(&plot.title)),
        format!("xlabel={{{}}}", lines(&plot.x_label)),
        format!("ylabel={{{}}}", lines(&plot.y_label)),
    ];
    let is_in_rows = panel.content.is_in_rows();
    let (across, upwards) = if is_in_rows { (&panel.y, &panel.x) } else { (&panel.x, &panel.y) };
    options.extend(scale_options('x', across, &plot.x));
    options.extend(scale_options('y', upwards, &plot.y));
    if is_in_rows {
        options.push("y dir=reverse".to_owned());
    }
    if matches!(panel.content, Content::Stacks(_)) {
        options.push(format!("xbar stacked, bar width={:.2}bp", STACK_HEIGHT * row));
    }
    if let Content::Picture(picture) = &panel.content {
        options.push(picture_options(plot, picture));
    }
    if let Some(line) = &panel.reference {
        // Stacks are drawn at the very end of an axis, so that a line across comes after it.
        options.push(format!("after end axis/.append code={{{}}}", reference_line(panel, line.y)));
    }
    options.join(", ")
}

fn scale_options(axis: char, shown: &Axis, mapping: &Mapping) -> Vec<String> {
    let mut options = tick_options(axis, mapping);
    if !matches!(shown.scale, Scale::Categories(_)) {
        options.push(format!("{axis}majorgrids"));
    }
    match &shown.scale {
        Scale::Logarithmic { base } => options.push(format!("{axis}mode=log, log basis {axis}={base}")),
        Scale::Ratio => options.push(format!("{axis}mode=log")),
        _ => {}
    }
    let between = values(mapping.ticks.iter().filter(|tick| tick.label.is_empty()));
    // pgfplots refuses marks between powers of another base than 10.
    let is_refused = matches!(shown.scale, Scale::Logarithmic { base } if base != 10);
    if !between.is_empty() && !is_refused {
        options.push(format!("minor {axis}tick={{{between}}}"));
    }
    options
}

/// Range and labelled ticks.
fn tick_options(axis: char, mapping: &Mapping) -> Vec<String> {
    let (start, end) = mapping.range;
    let labels: Vec<String> =
        mapping.labelled().map(|tick| format!("{{{}}}", tick_label(&tick.label))).collect();
    let ticks =
        if labels.is_empty() { "\\empty".to_owned() } else { format!("{{{}}}", values(mapping.labelled())) };
    vec![
        format!("{axis}min={}, {axis}max={}", start.min(end), start.max(end)),
        format!("{axis}tick={ticks}"),
        format!("{axis}ticklabels={{{}}}", labels.join(",")),
    ]
}

fn values<'a>(ticks: impl Iterator<Item = &'a Tick>) -> String {
    ticks.map(|tick| tick.value.to_string()).collect::<Vec<_>>().join(",")
}

/// A power as TeX writes it: `2^10` and `2.5e−7`; other labels as they are.
fn tick_label(label: &str) -> String {
    let is_number = |text: &str| text.parse::<f64>().is_ok();
    let plain = label.replace('−', "-");
    let power = match (plain.split_once('^'), plain.split_once('e')) {
        (Some((base, power)), _) if is_number(base) && is_number(power) => format!("{base}\\sp{{{power}}}"),
        (_, Some(("1", power))) if is_number(power) => format!("10\\sp{{{power}}}"),
        (_, Some((factor, power))) if is_number(factor) && is_number(power) => {
            format!("{factor}\\times10\\sp{{{power}}}")
        }
        _ => return lines(label),
    };
    format!("\\ensuremath{{{power}}}")
}

/// Which columns of its table a series is drawn from.
fn columns_of(content: &Content, number: usize) -> String {
    let (across, upwards) = if content.is_in_rows() { ('y', 'x') } else { ('x', 'y') };
    let of = if content.is_in_rows() { 'x' } else { 'y' };
    format!(
        "x={across}{number}, y={upwards}{number}, {of} error minus=below{number}, {of} error plus=above{number}"
    )
}

/// How a series is drawn, with error bars where spreads are known.
fn series_look(content: &Content, series: &Series) -> String {
    let number = series.style;
    let (look, ink) = match content {
        Content::Lines(_) => {
            let stride = marker_stride(series);
            let phase = 1 + (2 * stride - stride / 2 - number % stride) % stride;
            let (line, marker) = (line_look(number), marker_look(number));
            (format!("{line}, {marker}, mark repeat={stride}, mark phase={phase}"), format!("line{number}"))
        }
        Content::Scatter(_) => (format!("only marks, {}", marker_look(number)), format!("line{number}")),
        Content::Dots(_) if series.is_part => {
            (format!("only marks, mark=*, mark size=1.1bp, style{number}"), format!("line{number}"))
        }
        Content::Dots(_) => (format!("only marks, {}", marker_look(number)), format!("line{number}")),
        Content::Stacks(_) | Content::Picture(_) => (bar_look(number), "black".to_owned()),
    };
    let has_none = series.points.iter().all(|point| point.spread.is_none());
    if has_none || series.is_part || !has_spreads(content) {
        return look;
    }
    if content.is_in_rows() {
        let bar = format!("{ink}, solid, line width=2.2bp");
        return format!(
            "{look}, error bars/.cd, x dir=both, x explicit, error mark=none, error bar style={{{bar}}}"
        );
    }
    format!("{look}, error bars/.cd, y dir=both, y explicit, error bar style={{{ink}, solid}}")
}

fn line_look(number: usize) -> String {
    let dash = dash_pattern(style(number).dash);
    format!("line{number}, line width=1.1bp, {dash}")
}

fn dash_pattern(lengths: &[f64]) -> String {
    if lengths.is_empty() {
        return "solid".to_owned();
    }
    let words = ["on", "off"].into_iter().cycle();
    let parts: Vec<String> =
        lengths.iter().zip(words).map(|(length, word)| format!("{word} {length}bp")).collect();
    format!("dash pattern={}", parts.join(" "))
}

fn marker_look(number: usize) -> String {
    let Style { colour, marker, .. } = style(number);
    let shape = match marker {
        Marker::Circle => "mark=*",
        Marker::Square => "mark=square*",
        Marker::Triangle => "mark=triangle*",
        Marker::Diamond => "mark=diamond*",
        Marker::TriangleDown => "mark=triangle*",
        Marker::Cross => "mark=x",
        Marker::Plus => "mark=+",
        Marker::Pentagon => "mark=pentagon*",
        Marker::Ring => "mark=o",
    };
    let paint = match marker {
        Marker::Cross | Marker::Plus => format!("style{number}, line width=1.1bp"),
        Marker::Ring => format!("style{number}, fill=white, line width=1.1bp"),
        _ if colour.ink() != colour || marker == Marker::Pentagon => {
            format!("black, fill=style{number}, line width=0.5bp")
        }
        _ => format!("white, fill=style{number}, line width=0.4bp"),
    };
    let turned = if marker == Marker::TriangleDown { ", rotate=180" } else { "" };
    let size =
        if matches!(marker, Marker::Triangle | Marker::TriangleDown | Marker::Diamond) { 3.0 } else { 2.3 };
    format!("{shape}, mark size={size}bp, mark options={{solid, {paint}{turned}}}")
}

fn bar_look(number: usize) -> String {
    format!("draw=black, line width=0.4bp, fill=style{number}")
}

fn picture_options(plot: &Plot, picture: &Picture) -> String {
    let mut options = String::from("axis on top, grid=none, y dir=reverse");
    if let (Some(bar), Some((mapping, label))) = (&picture.colour_bar, &plot.colour_bar) {
        let colours: Vec<String> =
            bar.colours.iter().map(|[red, green, blue]| format!("rgb255=({red},{green},{blue})")).collect();
        let _ = write!(
            options,
            ", colormap={{figure}}{{{}}}, colorbar, point meta min={}, point meta max={}, colorbar style={{\
             ylabel={{{}}}, ylabel style={{align=center}}, {}, y dir=normal, width=8bp, xshift=-4bp}}",
            colours.join(" "),
            bar.range.0,
            bar.range.1,
            lines(label),
            tick_options('y', mapping).join(", "),
        );
    }
    options
}

fn picture_plot(picture: &Picture, file: &str) -> String {
    let (width, height) = (picture.width, picture.height);
    format!("\\addplot graphics[xmin=0, xmax={width}, ymin={height}, ymax=0]{{{file}}};\n")
}

/// A line across, from edge to edge.
fn reference_line(panel: &Panel, y: f64) -> String {
    let end = |side: u8| {
        if panel.content.is_in_rows() {
            format!("{{axis cs:{y},0}}|-{{rel axis cs:0,{side}}}")
        } else {
            format!("{{rel axis cs:{side},0}}|-{{axis cs:{},{y}}}", inside(panel))
        }
    };
    format!("\\draw[{}] ({}) -- ({});", reference_look(), end(0), end(1))
}

/// A number that the axis to the right has a place for.
fn inside(panel: &Panel) -> f64 {
    let points = panel.content.series().iter().flat_map(|series| &series.points);
    points.map(|point| point.x).find(|x| x.is_finite() && *x > 0.0).unwrap_or(1.0)
}

fn reference_look() -> String {
    format!("black!62, line width=0.9bp, {}", dash_pattern(REFERENCE_DASH))
}

/// Where a line in the legend runs.
const SAMPLE: &str = "(0,0) (12bp,0) (24bp,0)";

/// The legend as a paragraph below all panels, which breaks into lines by itself.
fn legend(entries: &[LegendEntry], width: Width) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let mut tex = format!(
        "\\node[anchor=north, align=center, text width={:.0}bp] at ([yshift=-4bp]current bounding box.south) {{\n",
        width.points() - 12.0
    );
    for LegendEntry { sample, label } in entries {
        let drawn = match *sample {
            Sample::Line(number) => {
                let (line, marker) = (line_look(number), marker_look(number));
                format!("\\draw[{line}] plot[{marker}, mark indices={{2}}] coordinates {{{SAMPLE}}};")
            }
            Sample::Marker(number) => {
                format!("\\path plot[{}, mark indices={{2}}] coordinates {{{SAMPLE}}};", marker_look(number))
            }
            Sample::Bar(number) => format!("\\path[{}] (0,-4bp) rectangle (15bp,4bp);", bar_look(number)),
            Sample::Reference => format!("\\draw[{}] (0,0) -- (24bp,0);", reference_look()),
        };
        let _ = writeln!(tex, "\\mbox{{\\tikz[baseline=-0.6ex]{{{drawn}}} {}}}\\quad", escape(label));
    }
    tex.push_str("};\n");
    tex
}

/// Lines of text below each other.
fn lines(text: &str) -> String {
    text.lines().map(escape).collect::<Vec<_>>().join("\\\\ ")
}

/// Text as TeX wants it.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        let word = match character {
            '\\' => "\\textbackslash{}",
            '{' | '}' | '$' | '&' | '#' | '%' | '_' => {
                escaped.extend(['\\', character]);
                continue;
            }
            '^' => "\\textasciicircum{}",
            '~' => "\\textasciitilde{}",
            '<' => "\\textless{}",
            '>' => "\\textgreater{}",
            '"' => "''",
            '×' => "\\ensuremath{\\times}",
            'µ' | 'μ' => "\\ensuremath{\\mu}",
            '²' => "\\ensuremath{\\sp{2}}",
            '³' => "\\ensuremath{\\sp{3}}",
            '≥' => "\\ensuremath{\\ge}",
            '≤' => "\\ensuremath{\\le}",
            '−' => "\\ensuremath{-}",
            '→' => "\\ensuremath{\\to}",
            '±' => "\\ensuremath{\\pm}",
            '·' => "\\ensuremath{\\cdot}",
            '°' => "\\ensuremath{\\sp{\\circ}}",
            'Δ' => "\\ensuremath{\\Delta}",
            '∞' => "\\ensuremath{\\infty}",
            '…' => "\\ldots{}",
            '–' => "\\textendash{}",
            '—' => "\\textemdash{}",
            control if control.is_control() => " ",
            other => {
                escaped.push(other);
                continue;
            }
        };
        escaped.push_str(word);
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_what_tex_shows_as_it_was() {
        assert_eq!(escape("50 % of a_b & {c} #1 $x$"), "50 \\% of a\\_b \\& \\{c\\} \\#1 \\$x\\$");
        assert_eq!(
            escape("\\input 2^20 × ~ µs"),
            "\\textbackslash{}input 2\\textasciicircum{}20 \\ensuremath{\\times} \\textasciitilde{} \\ensuremath{\\mu}s"
        );
        assert_eq!(lines("a\nb"), "a\\\\ b");
    }

    #[test]
    fn powers_are_raised() {
        assert_eq!(tick_label("2^10"), "\\ensuremath{2\\sp{10}}");
        assert_eq!(tick_label("1e−4"), "\\ensuremath{10\\sp{-4}}");
        assert_eq!(tick_label("2.5e12"), "\\ensuremath{2.5\\times10\\sp{12}}");
        assert_eq!(tick_label("two-point^e"), "two-point\\textasciicircum{}e");
        assert_eq!(tick_label("1,000"), "1,000");
    }

    #[test]
    fn marks_between_powers_are_only_where_pgfplots_takes_them() {
        for (base, is_taken) in [(2, false), (10, true)] {
            let axis = Axis { label: String::new(), scale: Scale::Logarithmic { base } };
            let mapping = Mapping::new(&axis.scale, [1.0, 1e6], 7);
            assert!(mapping.ticks.iter().any(|tick| tick.label.is_empty()));
            let options = scale_options('x', &axis, &mapping).join(", ");
            assert_eq!(options.contains("minor xtick"), is_taken, "{options}");
        }
    }

    #[test]
    fn dashes_are_those_of_the_style() {
        assert_eq!(dash_pattern(&[]), "solid");
        assert_eq!(dash_pattern(&[5.0, 2.0, 1.0, 2.0]), "dash pattern=on 5bp off 2bp on 1bp off 2bp");
    }
}
