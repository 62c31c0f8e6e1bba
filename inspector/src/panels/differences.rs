//! What differs between order A and order B, as a table.

use egui::{Grid, Label, ScrollArea, Ui};

use crate::analysis::comparison::Comparison;
use crate::analysis::differences::{Row, counts, settings};
use crate::model::Context;

/// Width of the widest column, points.
const WIDEST: f32 = 320.0;

/// Settings, and counts of rays as far as they are known, of A and of B.
pub(super) fn rows(context: &Context, compared: Option<&Comparison>) -> Vec<Row> {
    let Some((a, b)) = context.baseline_recording().zip(context.recording()) else { return Vec::new() };
    let mut rows = settings([&a.shown, &b.shown]);
    rows.extend(compared.map(counts).unwrap_or_default());
    rows
}

/// The rows that differ.
pub(super) fn table(ui: &mut Ui, context: &Context, compared: Option<&Comparison>) {
    let mut rows = rows(context, compared);
    let all = rows.len();
    rows.retain(|row| row.differs);
    if compared.is_none() {
        ui.spinner();
    }
    ScrollArea::both().id_salt("differences").auto_shrink([false, false]).show(ui, |ui| {
        if rows.is_empty() {
            ui.label(format!("None of {all} settings and numbers differs."));
        }
        Grid::new("differences")
            .striped(true)
            .num_columns(3)
            .max_col_width(WIDEST)
            .spacing([18.0, 3.0])
            .show(ui, |ui| {
                let recordings = [context.baseline_recording(), context.recording()];
                let methods = [&context.selection.baseline.method, &context.selection.method];
                ui.strong("");
                for ((side, recording), method) in ["A", "B"].into_iter().zip(recordings).zip(methods) {
                    ui.strong(format!(
                        "{side}: {}, {method}",
                        recording.map_or("", |open| open.label.as_str())
                    ));
                }
                ui.end_row();
                for row in &rows {
                    ui.label(row.what).on_hover_text(row.about);
                    for side in &row.sides {
                        ui.add(Label::new(side).truncate()).on_hover_text(side);
                    }
                    ui.end_row();
                }
            });
    });
}
