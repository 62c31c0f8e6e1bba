//! What a curve through a grid is: the order of its cells, and where it jumps.

use formats::key::{Encoder, Extent, Facts, KEY_BITS_MIN, LayoutText};
use formats::ray::Ray;
use formats::unit_space::UnitSpace;

use super::building::figure;
use super::{Findings, Made};
use crate::analysis::RecordingAnalysis;
use crate::colour_map::{ColourMap, STEPS};
use crate::figures::model::{Axis, Content, Of, Panel, Picture, Point, Series};

/// Both curves, by their name and what stands for a level of theirs in a layout.
const CURVES: [(&str, &str); 2] = [("Morton", "(ox oy)"), ("Hilbert", "hilbert(ox oy)")];
/// Bits of each coordinate in the grid that is drawn as a line, and in the one whose cells are coloured.
const LINE_BITS: u32 = 3;
const COLOUR_BITS: u32 = 6;
/// Steps of a line at most.
const MARKED: usize = 16;
/// Of a step to a neighbour and of a jump.
const STEP_STYLE: usize = 0;
const JUMP_STYLE: usize = 2;

/// A place in a grid: column from the left, row from below.
type Cell = [u32; 2];

/// Both curves through a small grid as lines, and through a larger one in colours. Made beside whatever was timed.
pub fn curve(findings: &Findings<'_>) -> Made {
    let orders = findings.analysis.recordings.iter().flat_map(RecordingAnalysis::measured);
    let is_timed = orders.flat_map(|queue| &queue.orders).any(|order| !order.stages.is_empty());
    if !is_timed && findings.benches.is_empty() {
        return Err("it explains orders, and none was timed".to_owned());
    }
    let (mut panels, mut settings) = (Vec::new(), Vec::new());
    for (bits, panel) in [(LINE_BITS, line as fn(String, &[Cell]) -> Panel), (COLOUR_BITS, coloured)] {
        for (name, level) in CURVES {
            let layout = format!("{level}*{bits}");
            let cells = cells(&layout, bits)?;
            let side = 1 << bits;
            let jumps = match cells.windows(2).filter(|pair| is_jump(pair)).count() {
                0 => "no jump".to_owned(),
                jumps => format!("{jumps} jumps"),
            };
            panels.push(panel(format!("{name}, {side} × {side}: {jumps}"), &cells));
            settings.push(format!("{name}, {side} × {side} cells: keys by {layout}"));
        }
    }
    figure(
        "Sorting along a curve",
        "Cells of a square in the order of their keys, from the lower left corner on; below in colours, from the first (dark blue) to the last (dark red). Neighbours in the order are neighbours in space, but where the curve jumps between cells that do not touch: a group of rays that is sorted across a jump spans both of its ends. Morton's curve interleaves the bits of x and y and jumps after every eighth cell, Hilbert's never does.",
        settings,
        panels,
        "there is no curve",
    )
}

/// The cells of a grid of 2^`bits` cells a side, in the order of their centres' keys.
fn cells(layout: &str, bits: u32) -> Result<Vec<Cell>, String> {
    let layout = LayoutText::parse(layout)
        .and_then(|text| text.expand(Extent::NOTHING))
        .map_err(|error| error.to_string())?;
    let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
    let encoder = Encoder::new(&layout, KEY_BITS_MIN.max(2 * bits), unit, &[]);
    let side = 1u32 << bits;
    let centre = |at: u32| (at as f32 + 0.5) / side as f32;
    let key = |&[column, row]: &Cell| {
        let origin = [centre(column), centre(row), 0.0];
        encoder.encode(&Ray { origin, t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: 0.0 }, Facts::default())
    };
    let mut cells: Vec<Cell> = (0..side * side).map(|at| [at % side, at / side]).collect();
    cells.sort_by_cached_key(key);
    Ok(cells)
}

/// Whether two cells do not even share a corner.
fn is_jump(pair: &[Cell]) -> bool {
    (0..2).any(|axis| pair[0][axis].abs_diff(pair[1][axis]) > 1)
}

/// Runs of touching cells, and the jumps between them.
fn line(title: String, cells: &[Cell]) -> Panel {
    let series = |label: &str, style: usize, first: usize, count: usize| {
        let point = |at: usize| {
            let [column, row] = cells[at];
            let of = Of::detail(format!("cell {at} of {}", cells.len()));
            Point::new(f64::from(column), f64::from(row), 1, of)
        };
        let points = (first..first + count).map(point).collect();
        Series::new(label, style, points)
    };
    let (mut runs, mut jumps, mut first) = (Vec::new(), Vec::new(), 0);
    for run in cells.chunk_by(|a, b| !is_jump(&[*a, *b])) {
        // Short enough that every cell has its marker.
        for start in (0..run.len()).step_by(MARKED) {
            let count = (run.len() - start).min(MARKED + 1);
            runs.push(series("next cell", STEP_STYLE, first + start, count));
        }
        first += run.len();
        if first < cells.len() {
            jumps.push(series("jump", JUMP_STYLE, first - 1, 2));
        }
    }
    let axis = |label| Axis::marked(label, []);
    runs.append(&mut jumps);
    Panel::new(title, axis("x"), axis("y"), Content::Lines(runs))
}

/// Each cell in the colour of its place in the order.
fn coloured(title: String, cells: &[Cell]) -> Panel {
    let colours = ColourMap::Turbo.colours();
    let side = cells.len().isqrt();
    let mut rgb = vec![[0; 3]; cells.len()];
    for (place, &[column, row]) in cells.iter().enumerate() {
        rgb[(side - 1 - row as usize) * side + column as usize] = colours[place * STEPS / cells.len()];
    }
    let picture = Picture { width: side as u32, height: side as u32, rgb, colour_bar: None };
    Panel::picture(title, picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_visited_once_and_hilbert_never_jumps() {
        for (bits, morton_jumps) in [(LINE_BITS, 7), (COLOUR_BITS, 511)] {
            let side = 1 << bits;
            for ((name, level), expected) in CURVES.into_iter().zip([morton_jumps, 0]) {
                let cells = cells(&format!("{level}*{bits}"), bits).unwrap();
                let mut seen = cells.clone();
                seen.sort_unstable();
                let all: Vec<Cell> = (0..side * side).map(|at| [at / side, at % side]).collect();
                assert_eq!(seen, all, "{name}");
                // After Morton's place k bits of y and of x are carried as far as k ends in ones: with one or two of
                // them to a neighbour, with three or more farther. Every eighth k, but the last, ends in three.
                assert_eq!(cells.windows(2).filter(|pair| is_jump(pair)).count(), expected, "{name}");
                assert_eq!(cells[0], [0, 0]);
            }
        }
    }

    #[test]
    fn mortons_first_cells_by_hand() {
        let cells = cells("(ox oy)*3", 3).unwrap();
        assert_eq!(cells[..4], [[0, 0], [0, 1], [1, 0], [1, 1]]);
        assert_eq!(cells[7..9], [[1, 3], [2, 0]]);
        assert!(is_jump(&cells[7..9]) && !is_jump(&cells[1..3]) && !is_jump(&cells[3..5]));
    }

    #[test]
    fn lines_break_where_the_curve_jumps_and_colours_start_below() {
        let cells = cells("(ox oy)*3", 3).unwrap();
        let panel = line(String::new(), &cells);
        let (runs, jumps) = panel.content.series().split_at(8);
        assert!(runs.iter().all(|run| run.points.len() == 8 && run.label == "next cell"));
        assert!(jumps.len() == 7 && jumps.iter().all(|jump| jump.points.len() == 2 && jump.label == "jump"));
        let Content::Picture(picture) = coloured(String::new(), &cells).content else { panic!("a picture") };
        let colours = ColourMap::Turbo.colours();
        assert_eq!([picture.rgb[56], picture.rgb[7]], [colours[0], colours[63 * STEPS / 64]]);
    }
}
