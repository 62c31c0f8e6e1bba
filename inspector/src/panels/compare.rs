//! Two orders side by side, seen from one place: of the same rays, or of two recordings of a scene.

use std::sync::Arc;

use egui::{ScrollArea, Ui};
use formats::key::method::UNSORTED;
use serde::{Deserialize, Serialize};

use super::notes::{choose, hint};
use super::space::layers::RayValues;
use super::space::{SpaceState, SpaceView, ViewSetup};
use crate::analysis::GroupWidth;
use crate::model::background::Background;
use crate::model::comparison::{Compared, Difference, LOWEST_DISTANCE};
use crate::model::differences::{Row, counts, settings, speedups};
use crate::model::{Context, Order, Selection};
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::render::range::ValueRange;
use crate::theme::Theme;

/// Part of the panel's height that the table may take.
const TABLE_PART: f32 = 0.4;

/// What is compared, and how it is shown. The right side is the selected order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Choice {
    /// The method on the left.
    before: String,
    /// The recording on the left, by its place among those open; that of the right side if `None`.
    before_recording: Option<usize>,
    /// What of the rays colours stand for; what the views say if `None`.
    difference: Option<Difference>,
    /// Whether the table is shown.
    table: bool,
    /// Whether it has the lines that do not differ, too.
    all_rows: bool,
}

/// What sessions keep.
#[derive(Serialize, Deserialize)]
struct State {
    #[serde(flatten)]
    choice: Choice,
    #[serde(flatten)]
    space: SpaceState,
}

/// What is compared: the serial numbers of both orders, rays of a group, and what colours stand for.
type Wanted = ([u64; 2], GroupWidth, Option<Difference>);

/// The panel. Of the two views, the first has the controls and the slider of both.
pub(super) struct Compare {
    views: [SpaceView; 2],
    choice: Choice,
    comparing: Background<Wanted, Arc<Compared>, 1>,
    compared: Option<Arc<Compared>>,
}

impl Compare {
    pub(super) fn new(setup: &ViewSetup) -> Self {
        let choice = Choice {
            before: UNSORTED.to_owned(),
            before_recording: None,
            difference: None,
            table: false,
            all_rows: false,
        };
        Self {
            views: [SpaceView::new(setup), SpaceView::new(setup)],
            choice,
            comparing: Background::default(),
            compared: None,
        }
    }
}

impl Panel for Compare {
    fn show(&mut self, ui: &mut Ui, context: &mut Context) {
        if context.recording().is_none() {
            return hint(ui, "no recording is open");
        }
        self.keep_choice(context);
        self.compare(context);
        self.views[0].controls(ui, context);
        self.comparison_controls(ui);
        self.views[1].options = self.views[0].options.clone();
        let below = SpaceView::slider_height(ui);
        let table = if self.choice.table { TABLE_PART * ui.available_height() } else { 0.0 };
        let height = ui.available_height() - below - table;
        ui.columns(2, |columns| {
            let [left, right] = columns else { return };
            self.left(left, context, height);
            self.right(right, context, height);
        });
        self.views[0].slider(ui);
        if self.choice.table {
            self.table(ui, context);
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let compared = self.compared.as_ref().ok_or("it is not compared yet: show the table first")?;
        let rows = self.rows(context, Some(compared));
        let cells = |row: Row| {
            let [left, right] = row.sides;
            vec![row.what.to_owned(), left, right, row.differs.to_string()]
        };
        Ok(Data::new(&["what", "left", "right", "differs"], rows.into_iter().map(cells)))
    }

    fn state(&self) -> serde_json::Value {
        let state = State { choice: self.choice.clone(), space: self.views[0].kept() };
        serde_json::to_value(state).unwrap_or_default()
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        let State { choice, space } = serde_json::from_value(state)?;
        self.choice = choice;
        self.views[0].set_state(space);
        Ok(())
    }

    fn space(&mut self) -> Option<&mut SpaceView> {
        self.views.first_mut()
    }
}

impl Compare {
    /// Leaves what is not there any more.
    fn keep_choice(&mut self, context: &Context) {
        let selected = context.selection.recording;
        let choice = &mut self.choice;
        choice.before_recording =
            choice.before_recording.filter(|at| *at < context.recordings.len() && *at != selected);
        let methods = context.methods_of(choice.before_recording.unwrap_or(selected));
        if !methods.contains(&choice.before) {
            UNSORTED.clone_into(&mut choice.before);
        }
    }

    /// The left side as a selection; a ray of the right side is the one of the same path.
    fn left_selection(&self, selection: &Selection) -> Selection {
        let other = self.choice.before_recording;
        let comparison = self.compared.as_ref().map(|compared| &compared.comparison);
        let ray = match (other, selection.ray) {
            (Some(_), Some(ray)) => comparison.and_then(|comparison| comparison.left_of(ray)),
            (_, ray) => ray,
        };
        let recording = other.unwrap_or(selection.recording);
        Selection { recording, method: self.choice.before.clone(), ray, group: None, ..selection.clone() }
    }

    fn left_order(&self, context: &mut Context) -> Option<Arc<Order>> {
        let left = self.left_selection(&context.selection);
        let selected = std::mem::replace(&mut context.selection, left);
        let order = context.order();
        context.selection = selected;
        order.ok()
    }

    /// Finds out what differs, if anything that is shown needs it, and colours both views by it.
    fn compare(&mut self, context: &mut Context) {
        let is_wanted =
            self.choice.table || self.choice.difference.is_some() || self.choice.before_recording.is_some();
        self.compared = if is_wanted { self.found(context) } else { None };
        let values = self.compared.as_ref().and_then(|compared| {
            let difference = self.choice.difference?;
            let range = range(difference, compared.nearly_largest);
            Some((difference, range, compared.id, compared.values.as_ref()?))
        });
        for (side, view) in self.views.iter_mut().enumerate() {
            view.colour_by(values.map(|(difference, range, id, values)| RayValues {
                id: 2 * id + side as u64,
                title: difference.title(),
                of_ray: values[side].clone(),
                range: Some(range),
            }));
        }
    }

    fn found(&mut self, context: &mut Context) -> Option<Arc<Compared>> {
        let orders = [self.left_order(context)?, context.order().ok()?];
        let (width, difference) = (context.selection.group_width, self.choice.difference);
        let wanted = (orders.each_ref().map(|order| order.serial), width, difference);
        let make = move || Arc::new(Compared::of(&orders, width, difference));
        self.comparing.of(wanted, context.waker(), make).ok().cloned()
    }

    fn comparison_controls(&mut self, ui: &mut Ui) {
        let choice = &mut self.choice;
        ui.horizontal_wrapped(|ui| {
            ui.label("Difference");
            let name = choice.difference.map_or("none", Difference::name);
            let differences = Difference::ALL
                .map(|(difference, name, title)| (Some(difference), name.to_owned(), Some(title.to_owned())));
            let none = (None, "none".to_owned(), None);
            let choices = std::iter::once(none).chain(differences);
            choose(ui, ("difference", name), &mut choice.difference, choices);
            ui.toggle_value(&mut choice.table, "Table").on_hover_text("What differs between the two sides");
            if choice.table {
                ui.checkbox(&mut choice.all_rows, "also what is the same");
            }
            if choice.difference.is_some() && self.compared.is_none() {
                ui.spinner();
            }
        });
    }

    fn left(&mut self, ui: &mut Ui, context: &mut Context, height: f32) {
        let left = self.left_selection(&context.selection);
        ui.horizontal_wrapped(|ui| self.choose_left(ui, context));
        // The left picture shows the same selection in another order.
        let selected = std::mem::replace(&mut context.selection, left);
        context.select_ray(context.selection.ray);
        area(ui, context);
        let room = height - (ui.cursor().top() - ui.min_rect().top());
        let ray = context.selection.ray;
        let camera = self.views[0].camera;
        self.views[0].look_from(camera);
        self.views[0].picture(ui, context, egui::vec2(ui.available_width(), room));
        let chosen = context.selection.ray;
        context.selection = selected;
        if chosen != ray {
            let comparison = self.compared.as_ref().map(|compared| &compared.comparison);
            context.select_ray(match (self.choice.before_recording, chosen) {
                (Some(_), Some(ray)) => comparison.and_then(|comparison| comparison.right_of(ray)),
                (_, ray) => ray,
            });
        }
    }

    fn choose_left(&mut self, ui: &mut Ui, context: &Context) {
        let selected = context.selection.recording;
        let choice = &mut self.choice;
        if context.recordings.len() > 1 {
            let mut at = choice.before_recording.unwrap_or(selected);
            let name = context.recordings.get(at).map_or("", |recording| recording.label.as_str());
            let open = context.recordings.iter().enumerate();
            let choices = open.map(|(at, recording)| (at, recording.label.clone(), None));
            choose(ui, ("before recording", name), &mut at, choices);
            choice.before_recording = (at != selected).then_some(at);
        }
        let methods = context.methods_of(choice.before_recording.unwrap_or(selected));
        choose_method(ui, "before", &mut choice.before, &methods);
    }

    fn right(&mut self, ui: &mut Ui, context: &mut Context, height: f32) {
        let Some(recording) = context.recording() else { return };
        let methods = context.methods();
        let mut after = context.selection.method.clone();
        ui.horizontal_wrapped(|ui| {
            if context.recordings.len() > 1 {
                ui.label(&recording.label);
            }
            choose_method(ui, "after", &mut after, &methods);
        });
        if after != context.selection.method {
            context.order_by(&after);
        }
        area(ui, context);
        let room = height - (ui.cursor().top() - ui.min_rect().top());
        let [left, right] = &mut self.views;
        right.look_from(left.camera);
        right.picture(ui, context, egui::vec2(ui.available_width(), room));
        left.look_from(right.camera);
    }

    fn rows(&self, context: &Context, compared: Option<&Arc<Compared>>) -> Vec<Row> {
        let selection = &context.selection;
        let left = context.recordings.get(self.choice.before_recording.unwrap_or(selection.recording));
        let Some((left, right)) = left.zip(context.recording()) else { return Vec::new() };
        let mut rows = settings(left, right);
        rows.extend(compared.map(|compared| counts(&compared.comparison)).unwrap_or_default());
        rows.extend(speedups(
            selection.queue,
            [(left, self.choice.before.as_str()), (right, selection.method.as_str())],
        ));
        rows
    }

    fn table(&self, ui: &mut Ui, context: &Context) {
        let mut rows = self.rows(context, self.compared.as_ref());
        let all = rows.len();
        rows.retain(|row| row.differs || self.choice.all_rows);
        if self.compared.is_none() {
            ui.spinner();
        }
        let differing = Theme::of(ui.ctx()).selected_mark();
        ScrollArea::both().id_salt("differences").auto_shrink([false, false]).show(ui, |ui| {
            if rows.is_empty() {
                ui.label(format!("None of {all} settings and numbers differs."));
            }
            egui::Grid::new("differences").striped(true).num_columns(3).spacing([18.0, 3.0]).show(ui, |ui| {
                let right = context.recording().map_or("", |recording| recording.label.as_str());
                let left = self.choice.before_recording.and_then(|at| context.recordings.get(at));
                let left = left.map_or(right, |recording| recording.label.as_str());
                let methods = [&self.choice.before, &context.selection.method];
                ui.strong("");
                for (label, method) in [left, right].into_iter().zip(methods) {
                    ui.strong(format!("{label}, {method}"));
                }
                ui.end_row();
                for row in &rows {
                    let name = egui::RichText::new(row.what);
                    ui.label(if row.differs { name.color(differing) } else { name }).on_hover_text(row.about);
                    for side in &row.sides {
                        ui.label(shortened(side)).on_hover_text(side);
                    }
                    ui.end_row();
                }
            });
        });
    }
}

/// What the ends of the colours stand for.
fn range(difference: Difference, nearly_largest: f32) -> ValueRange {
    match difference {
        Difference::Displacement | Difference::Hit | Difference::Key => ValueRange { low: 0.0, high: 1.0 },
        Difference::Distance => ValueRange { low: LOWEST_DISTANCE, high: 0.0 },
        Difference::CapsuleArea => {
            // No change is in the middle.
            let most = nearly_largest.max(1e-3);
            ValueRange { low: -most, high: most }
        }
    }
}

/// Longest text in a cell, characters.
const LONGEST: usize = 48;

fn shortened(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None if text.is_empty() => "-".to_owned(),
        None => text.to_owned(),
    }
}

fn choose_method(ui: &mut Ui, id: &str, chosen: &mut String, methods: &[String]) {
    let choices = methods.iter().map(|method| (method.clone(), method.clone(), None));
    let now = chosen.clone();
    choose(ui, (id, &now), chosen, choices);
}

/// The mean capsule area of the order that is selected.
fn area(ui: &mut Ui, context: &mut Context) {
    let order = context.order().ok();
    let groups = order.as_ref().and_then(|order| context.groups(order));
    ui.label(groups.map_or(String::new(), |groups| format!("mean capsule area {:.4}", groups.mean_area())));
}
