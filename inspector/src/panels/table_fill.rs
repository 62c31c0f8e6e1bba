//! How full the length table is from bounce to bounce and from pass to pass.

use egui::Align2;
use egui_plot::{AxisHints, Bar, BarChart, PlotPoint, Text};
use formats::manifest::{Place, QueueArray, QueueId};

use super::notes::{name_at, still};
use crate::model::{Context, Recording};
use crate::theme::{ON_BARS, Theme};

/// Height of the chart, points.
pub(super) const HEIGHT: f32 = 96.0;
/// Most bars whose numbers have room in them.
const MOST_WRITTEN: usize = 12;
/// Between two bounces that are played, seconds: long enough for each to be looked at.
const PACE: f64 = 0.8;

/// A bar for each queue of the selected kind: a click goes to it, *Play* through all of them.
#[derive(Default)]
pub(super) struct FillPlot {
    /// When the next one is gone to, as the window tells the time.
    next: Option<f64>,
}

impl FillPlot {
    pub(super) fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let now = context.selection.queue;
        let fills = context.recording().map_or(Vec::new(), |recording| fills(recording, now));
        let at = fills.iter().position(|(queue, _)| *queue == now).unwrap_or(0);
        let mut next = self.played(ui, context, at + 1 < fills.len()).then_some(at + 1);
        let theme = Theme::of(ui.ctx());
        let bar = |(row, (queue, fill)): (usize, &(QueueId, f64))| {
            let colour = if *queue == now { theme.selected_mark() } else { theme.series(1) };
            Bar::new(row as f64, *fill)
                .width(0.8)
                .fill(colour)
                .name(format!("pass {}, bounce {}", queue.pass, queue.bounce))
        };
        let bars = BarChart::new("fill", fills.iter().enumerate().map(bar).collect());
        let names: Vec<String> =
            fills.iter().map(|(queue, _)| format!("{}.{}", queue.pass, queue.bounce)).collect();
        ui.horizontal(|ui| {
            if !context.is_bare {
                let name = if self.next.is_some() { "Stop" } else { "Play" };
                let button = ui.add_enabled(fills.len() > 1, egui::Button::new(name));
                if button.on_hover_text("Goes through all bounces and passes").clicked() {
                    self.next = self.next.is_none().then(|| ui.input(|input| input.time));
                    if at + 1 == fills.len() {
                        next = Some(0);
                    }
                }
            }
            let below = AxisHints::new_x().formatter(move |mark, _| name_at(&names, mark.value));
            let plot = still("fill", HEIGHT)
                .include_y(0.0)
                .show_grid([false, true])
                .custom_y_axes(vec![AxisHints::new_y().label("touched, %").label_spacing(8.0..=16.0)])
                .custom_x_axes(vec![below.label("pass.bounce").label_spacing(16.0..=24.0)])
                .x_grid_spacer(egui_plot::uniform_grid_spacer(|_| [1.0, 1.0, 1.0]))
                .show(ui, |plot| {
                    plot.bar_chart(bars);
                    for (row, (_, fill)) in fills.iter().enumerate().filter(|_| fills.len() <= MOST_WRITTEN) {
                        let text = Text::new("fill", PlotPoint::new(row as f64, *fill), format!("{fill:.2}"));
                        plot.text(text.anchor(Align2::CENTER_TOP).color(ON_BARS));
                    }
                    plot.pointer_coordinate()
                });
            if let Some(point) = plot.inner.filter(|_| plot.response.clicked()) {
                next = Some(point.x.round().max(0.0) as usize);
            }
        });
        if let Some((queue, _)) = next.and_then(|next| fills.get(next)) {
            context.go_to(*queue);
        }
    }

    /// Whether it is time for the next one; none comes after the last.
    fn played(&mut self, ui: &egui::Ui, context: &mut Context, has_next: bool) -> bool {
        let Some(next) = self.next else { return false };
        let time = ui.input(|input| input.time);
        let is_time = time >= next && context.queue().is_ok();
        if is_time {
            self.next = has_next.then_some(time + PACE);
        }
        ui.ctx().request_repaint_after_secs((next - time).max(0.05) as f32);
        is_time && has_next
    }
}

/// The queues of the kind of one by pass and bounce, and how many percent of the table's cells are touched before each.
fn fills(recording: &Recording, of: QueueId) -> Vec<(QueueId, f64)> {
    let cells = 2f64.powi(recording.dump.manifest().header.options.table_bits as i32);
    let fill = |queue: QueueId| {
        let touched = recording.dump.shape(&Place::Queue(queue, QueueArray::Lengths))?.first()?;
        Some((queue, 100.0 * *touched as f64 / cells))
    };
    let queues = recording.queues().iter().map(|record| record.id).filter(|queue| queue.kind == of.kind);
    let mut fills: Vec<_> = queues.filter_map(fill).collect();
    fills.sort_by_key(|(queue, _)| (queue.pass, queue.bounce));
    fills
}
