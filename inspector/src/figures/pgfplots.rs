//! The same figure for LaTeX: a standalone file that reads the CSV beside it and draws with pgfplots.

use std::fmt::Write;

use super::axis::Mapping;
use super::csv::{ABOVE_COLUMN, BELOW_COLUMN, CURVE_COLUMN, X_COLUMN, Y_COLUMN};
use super::frame::Frame;
use super::legend::{Entry, Sample, entries, reference_labels};
use super::model::{Axis, Content, Figure, Panel, Picture, Scale, Series};
use super::style::{Hatch, Marker, REFERENCE_DASHES, Style, Width, style};
use super::svg::{Layout, layout};

/// What every file starts with: packages, how rows of one curve are picked, and how the CSV is read.
const HEAD: &str = r"% Compile with pdflatex; the CSV must lie beside this file.
\documentclass[border=2pt]{standalone}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage{helvet}
\renewcommand{\familydefault}{\sfdefault}
\usepackage{pgfplots}
\usepackage{pgfplotstable}
\usepgfplotslibrary{groupplots}
\usetikzlibrary{patterns}
\pgfplotsset{compat=1.16}
\pgfplotsset{
  /pgfplots/curve/.style={x filter/.append code={%
    \edef\curvefound{\thisrowno{CURVE}}\edef\curvewanted{#1}%
    \ifx\curvefound\curvewanted\else\def\pgfmathresult{}\fi}},
}
";

/// Reads the CSV with its text as it is, whatever TeX's special characters in it.
const READ: &str = r"\catcode37=12\catcode35=12\catcode36=12\catcode38=12\catcode94=12\catcode95=12\catcode126=12\relax
\pgfplotstableread[col sep=comma,header=has colnames]{CSV}\numbers
\catcode37=14\catcode35=6\catcode36=3\catcode38=4\catcode94=7\catcode95=8\catcode126=13\relax
";

/// File name of the pixels of a panel that shows a picture.
pub fn picture_name(figure: &Figure, panel: usize) -> String {
    format!("{}-panel-{}.png", figure.name, panel + 1)
}

/// The LaTeX source of a figure: the same axes in the same places as in the SVG.
pub fn write(figure: &Figure, width: Width) -> String {
    let mut tex = HEAD.replace("CURVE", &CURVE_COLUMN.to_string());
    for number in styles_of(figure) {
        let hex = style(number).colour.hex().to_uppercase();
        let _ = writeln!(tex, "\\definecolor{{style{number}}}{{HTML}}{{{hex}}}");
    }
    tex.push_str("\\begin{document}\n\\footnotesize\n");
    tex.push_str(&READ.replace("CSV", &format!("{}.csv", figure.name)));
    let Layout { columns, frames, .. } = layout(figure, width);
    tex.push_str(&group_start(&frames, columns));
    let references = reference_labels(figure);
    let mut curve = 0;
    for (at, frame) in frames.iter().enumerate() {
        let panel = frame.panel;
        let _ = writeln!(tex, "\\nextgroupplot[{}]", axis_options(frame));
        for series in panel.content.series() {
            tex.push_str(&plot(panel, series, curve));
            curve += 1;
        }
        if let Content::Picture(picture) = &panel.content {
            tex.push_str(&picture_plot(figure, at, picture));
        }
        tex.push_str(&reference_lines(panel, &references));
    }
    tex.push_str("\\end{groupplot}\n");
    tex.push_str(&legend(&entries(figure), width));
    tex.push_str("\\end{tikzpicture}\n\\end{document}\n");
    tex
}

fn group_start(frames: &[Frame], columns: usize) -> String {
    let rows = frames.len().div_ceil(columns);
    let largest = |part: fn(&Frame) -> f64| frames.iter().map(part).fold(0.0, f64::max);
    let beside = largest(|frame| frame.left) + largest(|frame| frame.right) + 4.0;
    let above = largest(|frame| frame.top) + largest(|frame| frame.bottom) + 12.0;
    format!(
        "\\begin{{tikzpicture}}\n\\begin{{groupplot}}[\n  group style={{group size={columns} by {rows}, \
         horizontal sep={beside:.0}bp, vertical sep={above:.0}bp}},\n  \
         scale only axis, ymajorgrids, grid style={{black!12}}, tick align=outside, tick pos=left,\n  \
         unbounded coords=jump, title style={{font=\\small, align=center}}, label style={{align=center}},\n]\n"
    )
}

fn styles_of(figure: &Figure) -> std::collections::BTreeSet<usize> {
    figure.panels.iter().flat_map(|panel| panel.content.series()).map(|series| series.style).collect()
}

/// Axis labels, scales, ticks and how bars stand.
fn axis_options(frame: &Frame) -> String {
    let (panel, width) = (frame.panel, frame.width);
    let mut options = vec![
        format!("width={:.1}bp, height={:.1}bp", frame.width, frame.height),
        format!("title={{{}}}", escape(&panel.title)),
        format!("xlabel={{{}}}", escape(&panel.x.label)),
        format!("ylabel={{{}}}", escape(&panel.y.label)),
    ];
    options.extend(scale_options('x', &panel.x, &frame.x));
    options.extend(scale_options('y', &panel.y, &frame.y));
    if let Scale::Categories(names) = &panel.x.scale {
        let bar_room = width / names.len().max(1) as f64;
        match &panel.content {
            Content::Bars(series) => {
                options.push(format!(
                    "bar width={:.2}bp",
                    (0.8 * bar_room / series.len().max(1) as f64).min(24.0)
                ));
            }
            Content::Stacks(_) => {
                options.push(format!("ybar stacked, bar width={:.2}bp", (0.7 * bar_room).min(36.0)));
            }
            _ => {}
        }
        let widest = names.iter().map(|name| super::text::width(name, 8.0)).fold(0.0, f64::max);
        if widest + 5.0 > bar_room {
            options.push("x tick label style={rotate=45, anchor=north east, inner sep=1pt}".to_owned());
        }
    }
    if let Content::Picture(picture) = &panel.content {
        options.push(picture_options(picture));
    }
    options.join(", ")
}

fn scale_options(axis: char, shown: &Axis, mapping: &Mapping) -> Vec<String> {
    let (low, high) = mapping.range;
    let mut options = vec![format!("{axis}min={low}, {axis}max={high}")];
    match &shown.scale {
        Scale::Linear { .. } => {}
        Scale::Logarithmic { base } => options.push(format!("{axis}mode=log, log basis {axis}={base}")),
        Scale::Categories(names) => {
            let places: Vec<String> = (0..names.len()).map(|at| at.to_string()).collect();
            let labels: Vec<String> = names.iter().map(|name| format!("{{{}}}", escape(name))).collect();
            options.push(format!("{axis}tick={{{}}}", places.join(",")));
            options.push(format!("{axis}ticklabels={{{}}}", labels.join(",")));
        }
    }
    options
}

/// One series: the rows of the CSV with its number.
fn plot(panel: &Panel, series: &Series, curve: usize) -> String {
    let look = match &panel.content {
        Content::Lines(_) => format!("{}, {}", line_look(series.style), marker_look(series.style)),
        Content::Scatter(_) => format!("only marks, {}", marker_look(series.style)),
        Content::Bars(all) => {
            let at = all.iter().position(|one| std::ptr::eq(one, series)).unwrap_or(0);
            let shift = at as f64 - 0.5 * (all.len() as f64 - 1.0);
            format!("ybar, bar shift={shift}*\\pgfplotbarwidth, {}", bar_look(series.style))
        }
        Content::Stacks(_) | Content::Picture(_) => bar_look(series.style),
    };
    let has_spread = series.points.iter().any(|point| point.spread.is_some());
    let (bars, columns) = if has_spread {
        let bars = ", error bars/.cd, y dir=both, y explicit, error bar style={black, solid}";
        (bars, format!(", y error minus index={BELOW_COLUMN}, y error plus index={ABOVE_COLUMN}"))
    } else {
        ("", String::new())
    };
    format!(
        "% {}\n\\addplot+[{look}, curve={curve}{bars}] table[x index={X_COLUMN}, y index={Y_COLUMN}{columns}]{{\\numbers}};\n",
        series.label.replace(['\n', '\r'], " ")
    )
}

fn line_look(number: usize) -> String {
    let dash = dash_pattern(style(number).dash);
    format!("style{number}, line width=1.1bp, {dash}")
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
    let shape = match style(number).marker {
        Marker::Circle => "mark=*",
        Marker::Square => "mark=square*",
        Marker::Triangle => "mark=triangle*",
        Marker::Diamond => "mark=diamond*",
        Marker::TriangleDown => "mark=triangle*, every mark/.append style={rotate=180}",
        Marker::Cross => "mark=x",
        Marker::Plus => "mark=+",
        Marker::Pentagon => "mark=pentagon*",
        Marker::Ring => "mark=o",
    };
    format!("{shape}, mark size=2bp, mark options={{solid, style{number}, fill=style{number}}}")
}

fn bar_look(number: usize) -> String {
    let Style { colour, hatch, .. } = style(number);
    let pattern = match hatch {
        Hatch::Solid => "",
        Hatch::Rising => "north east lines",
        Hatch::Falling => "north west lines",
        Hatch::Crossed => "crosshatch",
        Hatch::Level => "horizontal lines",
        Hatch::Upright => "vertical lines",
        Hatch::Dotted => "dots",
        Hatch::Grid => "grid",
    };
    let fill = format!("draw=black, line width=0.4bp, fill=style{number}");
    if pattern.is_empty() {
        return fill;
    }
    let [red, ..] = colour.contrast().0;
    let lines = if red == 0 { "black" } else { "white" };
    format!("{fill}, postaction={{pattern={pattern}, pattern color={lines}}}")
}

fn picture_options(picture: &Picture) -> String {
    let mut options = String::from("axis on top, y dir=reverse");
    if let Some(bar) = &picture.colour_bar {
        let colours: Vec<String> =
            bar.colours.iter().map(|[red, green, blue]| format!("rgb255=({red},{green},{blue})")).collect();
        let _ = write!(
            options,
            ", colormap={{figure}}{{{}}}, colorbar, point meta min={}, point meta max={}, colorbar style={{ylabel={{{}}}, y dir=normal}}",
            colours.join(" "),
            bar.range.0,
            bar.range.1,
            escape(&bar.label)
        );
    }
    options
}

fn picture_plot(figure: &Figure, panel: usize, picture: &Picture) -> String {
    let (width, height, name) = (picture.width, picture.height, picture_name(figure, panel));
    format!("\\addplot graphics[xmin=0, xmax={width}, ymin={height}, ymax=0]{{{name}}};\n")
}

/// Lines across, from edge to edge where they have no span.
fn reference_lines(panel: &Panel, labels: &[String]) -> String {
    let mut tex = String::new();
    for reference in &panel.references {
        let number = labels.iter().position(|label| *label == reference.label).unwrap_or(0);
        let y = reference.y;
        let (from, to) = match reference.span {
            Some((from, to)) => (format!("axis cs:{from},{y}"), format!("axis cs:{to},{y}")),
            None => (
                format!("{{rel axis cs:0,0}}|-{{axis cs:{},{y}}}", inside(panel)),
                format!("{{rel axis cs:1,0}}|-{{axis cs:{},{y}}}", inside(panel)),
            ),
        };
        let _ = writeln!(
            tex,
            "% {}\n\\draw[{}] ({from}) -- ({to});",
            reference.label.replace(['\n', '\r'], " "),
            reference_look(number)
        );
    }
    tex
}

/// A number that the axis to the right has a place for.
fn inside(panel: &Panel) -> f64 {
    let points = panel.content.series().iter().flat_map(|series| &series.points);
    points.map(|point| point.x).find(|x| x.is_finite() && *x > 0.0).unwrap_or(1.0)
}

fn reference_look(number: usize) -> String {
    let dash = dash_pattern(REFERENCE_DASHES[number % REFERENCE_DASHES.len()]);
    format!("black!62, line width=0.9bp, {dash}")
}

/// The legend as a paragraph below all panels, which breaks into lines by itself.
fn legend(entries: &[Entry], width: Width) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let mut tex = format!(
        "\\node[anchor=north, align=center, text width={:.0}bp] at ([yshift=-4bp]current bounding box.south) {{%\n",
        width.points() - 12.0
    );
    for Entry { sample, label } in entries {
        let image = match *sample {
            Sample::Line(number) => {
                format!("mark repeat=2, mark phase=2, {}, {}", line_look(number), marker_look(number))
            }
            Sample::Marker(number) => {
                format!("only marks, mark repeat=2, mark phase=2, {}", marker_look(number))
            }
            Sample::Bar(number) => format!("area legend, {}", bar_look(number)),
            Sample::Reference(number) => reference_look(number),
        };
        let _ = writeln!(tex, "\\mbox{{\\addlegendimageintext{{{image}}}~{}}}\\quad", escape(label));
    }
    tex.push_str("};\n");
    tex
}

/// Text as TeX wants it.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\\' => escaped.push_str("\\textbackslash{}"),
            '{' | '}' | '$' | '&' | '#' | '%' | '_' => escaped.extend(['\\', character]),
            '^' => escaped.push_str("\\textasciicircum{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '<' => escaped.push_str("\\textless{}"),
            '>' => escaped.push_str("\\textgreater{}"),
            '×' => escaped.push_str("$\\times$"),
            'µ' | 'μ' => escaped.push_str("$\\mu$"),
            '²' => escaped.push_str("$^2$"),
            '³' => escaped.push_str("$^3$"),
            '≥' => escaped.push_str("$\\ge$"),
            '≤' => escaped.push_str("$\\le$"),
            '−' => escaped.push_str("$-$"),
            '→' => escaped.push_str("$\\to$"),
            '±' => escaped.push_str("$\\pm$"),
            '·' => escaped.push_str("$\\cdot$"),
            '°' => escaped.push_str("$^\\circ$"),
            'Δ' => escaped.push_str("$\\Delta$"),
            '∞' => escaped.push_str("$\\infty$"),
            '…' => escaped.push_str("\\ldots{}"),
            control if control.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}
