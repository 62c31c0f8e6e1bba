//! What panels say and mark in the same way: why something is not shown, legends, marks of axes.

use std::collections::BTreeSet;

use formats::metrics::speedup::Verdict;
use formats::ray::Work;

use crate::analysis::GroupWidth;
use crate::analysis::timing::SpeedupLine;
use crate::figures::style::COLOURS;
use crate::model::key::{ReadKey, field_text};
use crate::model::{Absent, Context, Order};
use crate::output::{count, counted, times};
use crate::theme::Theme;

/// A name with its colour before it, in one piece: it goes to the next line as a whole.
pub(super) fn legend(ui: &mut egui::Ui, colour: egui::Color32, name: &str) {
    const SWATCH: f32 = 10.0;
    let (font, text_colour) = (egui::TextStyle::Body.resolve(ui.style()), ui.visuals().text_color());
    let text = ui.painter().layout_no_wrap(name.to_owned(), font, text_colour);
    let size = egui::vec2(SWATCH + 5.0 + text.size().x, text.size().y.max(SWATCH));
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    let square = egui::Rect::from_center_size(
        egui::pos2(rect.left() + 0.5 * SWATCH, rect.center().y),
        egui::Vec2::splat(SWATCH),
    );
    ui.painter().rect_filled(square, 2.0, colour);
    let place = egui::pos2(rect.right() - text.size().x, rect.center().y - 0.5 * text.size().y);
    ui.painter().galley(place, text, text_colour);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, name));
}

/// The colour of a method, the same in all panels; a ring where another method has that colour too.
pub(crate) fn swatch(ui: &mut egui::Ui, style: usize) {
    let colour = Theme::of(ui.ctx()).series(style);
    let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), egui::Sense::hover());
    if style < COLOURS {
        ui.painter().rect_filled(rect, 2.0, colour);
    } else {
        ui.painter().circle_stroke(rect.center(), 4.0, egui::Stroke::new(2.5, colour));
    }
}

/// A speedup, and whether it may be chance.
pub(super) fn marked(line: &SpeedupLine) -> String {
    let sign = match line.verdict {
        Verdict::NoSignificantDifference | Verdict::WithinControl => "\u{2248}",
        Verdict::Unknown => "?",
        Verdict::Faster | Verdict::Slower => "",
    };
    format!("{sign}{}", times(line.ratio))
}

/// A chart that always shows all that it has.
pub(super) fn still<'a>(name: &str, height: f32) -> egui_plot::Plot<'a> {
    egui_plot::Plot::new(name).height(height).allow_scroll(false).allow_zoom(false).allow_drag(false)
}

/// The number of a logarithm, where it is a power of ten.
pub(super) fn power_of_ten(exponent: f64) -> String {
    if (exponent - exponent.round()).abs() > 1e-6 {
        return String::new();
    }
    match exponent.round() as i32 {
        exponent @ -3..=3 => format!("{}", 10f64.powi(exponent)),
        exponent => format!("1e{exponent}"),
    }
}

/// The name of a row or column of a chart at its number; nothing between them.
pub(super) fn name_at(names: &[String], value: f64) -> String {
    let is_one = value >= 0.0 && (value - value.round()).abs() < 1e-3;
    names.get(value.round() as usize).filter(|_| is_one).cloned().unwrap_or_default()
}

/// Why something is not shown of a recording, for those who draw without a screen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lacking(BTreeSet<String>);

impl Lacking {
    /// What was said since it was last asked for.
    pub(crate) fn take(window: &egui::Context) -> BTreeSet<String> {
        window.data_mut(|data| data.remove_temp::<Self>(egui::Id::NULL)).unwrap_or_default().0
    }

    pub(super) fn note(window: &egui::Context, reason: &str) {
        window.data_mut(|data| {
            data.get_temp_mut_or_default::<Self>(egui::Id::NULL).0.insert(reason.to_owned());
        });
    }
}

/// Says why something is not shown, where it would have been.
pub(super) fn missing(ui: &mut egui::Ui, absent: impl Into<Absent>) {
    match absent.into() {
        Absent::Awaited => {
            ui.add_space(8.0);
            ui.vertical_centered(|ui| {
                ui.spinner();
                ui.label("reading the recording");
            });
        }
        Absent::Impossible(reason) => {
            Lacking::note(ui.ctx(), &reason);
            hint(ui, &reason);
        }
    }
}

/// What was found; else says why it is not shown, where it would have been.
pub(super) fn found<T>(ui: &mut egui::Ui, found: Result<T, impl Into<Absent>>) -> Option<T> {
    found.map_err(|absent| missing(ui, absent)).ok()
}

/// Says what to do to have something shown.
pub(super) fn hint(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.vertical_centered(|ui| {
        ui.label(egui::RichText::new("Nothing to show here").strong());
        ui.label(text);
    });
}

/// A list to choose one of: what each is called, and what it is, if that is to be said. Whether another one was
/// chosen.
pub(crate) fn choose<T: PartialEq>(
    ui: &mut egui::Ui,
    (id, shown): (&str, &str),
    chosen: &mut T,
    choices: impl IntoIterator<Item = (T, String, Option<String>)>,
) -> bool {
    let mut is_other = false;
    egui::ComboBox::from_id_salt(id).selected_text(shown).show_ui(ui, |ui| {
        for (choice, name, about) in choices {
            let mut response = ui.selectable_value(chosen, choice, name);
            if let Some(about) = about {
                response = response.on_hover_text(about);
            }
            is_other |= response.changed();
        }
    });
    is_other
}

/// Selects a ray that was clicked, or nothing; with Ctrl besides those that are selected, or no longer.
pub(super) fn select(ui: &egui::Ui, context: &mut Context, ray: Option<usize>) {
    match ray {
        Some(ray) if ui.input(|input| input.modifiers.command) => context.toggle_ray(ray),
        None if ui.input(|input| input.modifiers.command) => {}
        ray => context.select_ray(ray),
    }
}

/// What a ray cost: `12 nodes, 1 triangle`.
pub(super) fn cost(Work { nodes, triangles }: Work) -> String {
    let nodes = counted(nodes.into(), "node", "nodes");
    format!("{nodes}, {}", counted(triangles.into(), "triangle", "triangles"))
}

/// A ray in three lines: its place and pixel, what it cost, its key.
pub(super) fn about_ray(order: &Order, ray: usize) -> String {
    let Some(&place) = order.place_of_ray().get(ray) else { return String::new() };
    let place = format!("ray {} at place {}", count(ray as u64), count(u64::from(place)));
    let work = order.queue.work.as_ref().ok().and_then(|work| work.get(ray));
    let work = work.map_or(String::new(), |&work| format!(", {}", cost(work)));
    match ReadKey::of(order, ray) {
        Ok(key) => {
            let fields: Vec<String> = key.fields.iter().map(field_text).collect();
            format!("{place}{work}\nkey {}\n{}", key.hexadecimal(), fields.join("   "))
        }
        Err(reason) => format!("{place}{work}\n{reason}"),
    }
}

/// The names of columns, and what they are.
pub(super) fn headings<'a>(ui: &mut egui::Ui, columns: impl IntoIterator<Item = (&'a str, &'a str)>) {
    for (name, about) in columns {
        ui.strong(name).on_hover_text(about);
    }
    ui.end_row();
}

/// Chooses how many rays a group has.
pub(super) fn group_widths(ui: &mut egui::Ui, name: &str, context: &mut Context) {
    ui.label(name).on_hover_text("Consecutive rays of the order that a GPU traces together");
    for width in [GroupWidth::Rays32, GroupWidth::Rays64, GroupWidth::Rays128] {
        let is_now = context.selection.group_width == width;
        if ui.selectable_label(is_now, width.rays().to_string()).clicked() && !is_now {
            context.selection.group_width = width;
            context.select_rays(context.selection.rays());
        }
    }
}
