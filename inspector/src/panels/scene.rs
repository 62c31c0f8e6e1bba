//! The scene with rays, the curve of their order, capsules and table cells: of order B, or of A and B side by side
//! with one camera, one range of colours and one playhead.

use std::sync::Arc;

use egui::Ui;
use serde::{Deserialize, Serialize};

use super::differences::{rows, table};
use super::notes::{choose, hint, swatch};
use super::space::layers::RayValues;
use super::space::{RATIOS, SpaceState, SpaceView, ViewSetup};
use super::views::PRESETS;
use crate::analysis::GroupWidth;
use crate::analysis::comparison::{Comparison, Difference, LOWEST_DISTANCE};
use crate::analysis::differences::Row;
use crate::model::background::Background;
use crate::model::context::Problem;
use crate::model::{Context, Order};
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::render::range::ValueRange;
use crate::session::setting::change_state;

/// Width of the properties, points.
const PROPERTIES_WIDTH: f32 = 250.0;

/// Part of the panel's height that the table may take.
const TABLE_PART: f32 = 0.4;

/// What is shown of A besides B.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Choice {
    /// Whether A has a picture, too.
    side_by_side: bool,
    /// What of the rays colours stand for, with both pictures; what the views say if `None`.
    difference: Option<Difference>,
    /// Whether the table of what differs is shown.
    table: bool,
    /// Whether what is shown, and how, can be changed beside the picture.
    properties: bool,
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

/// The panel. The view of B has the controls, the camera and the playhead of both.
pub(super) struct Scene {
    b: SpaceView,
    a: SpaceView,
    choice: Choice,
    comparing: Background<Wanted, Arc<Comparison>, 1>,
    compared: Option<Arc<Comparison>>,
}

impl Scene {
    pub(super) fn new(setup: &ViewSetup) -> Self {
        let [a, b] = [SpaceView::new(setup), SpaceView::new(setup)];
        Self { b, a, choice: Choice::default(), comparing: Background::default(), compared: None }
    }
}

impl Panel for Scene {
    fn show(&mut self, ui: &mut Ui, context: &mut Context) {
        if context.recording().is_none() {
            return hint(ui, "no recording is open");
        }
        self.compare(context);
        if !context.is_bare {
            ui.horizontal_wrapped(|ui| {
                self.presets(ui, context);
                self.choices(ui);
                self.b.controls(ui, context);
            });
        }
        if self.choice.properties && !context.is_bare {
            let panel = egui::Panel::left("properties").resizable(false).default_size(PROPERTIES_WIDTH);
            let area = egui::ScrollArea::vertical().auto_shrink([false, false]);
            panel.show(ui, |ui| {
                area.show(ui, |ui| {
                    if self.choice.side_by_side {
                        self.difference(ui);
                        ui.separator();
                    }
                    self.b.properties(ui, context);
                });
            });
        }
        let shows_table = self.choice.side_by_side && self.choice.table;
        let table_height = if shows_table { TABLE_PART * ui.available_height() } else { 0.0 };
        let height = ui.available_height() - SpaceView::height_below(ui, context) - table_height;
        if self.choice.side_by_side {
            ui.columns(2, |columns| {
                let [left, right] = columns else { return };
                self.a_side(left, context, height);
                self.b_side(right, context, height);
            });
        } else {
            self.b.picture(ui, context, egui::vec2(ui.available_width(), height));
        }
        self.b.below(ui, context);
        if shows_table {
            table(ui, context, self.compared.as_deref());
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        if !(self.choice.side_by_side && self.choice.table) {
            return self.b.data(context);
        }
        let compared = self.compared.as_ref().ok_or("A and B are still being compared")?;
        let rows = rows(context, Some(compared));
        let cells = |row: Row| {
            let [a, b] = row.sides;
            vec![row.what.to_owned(), a, b, row.differs.to_string()]
        };
        Ok(Data::new(&["what", "a", "b", "differs"], rows.into_iter().map(cells)))
    }

    fn state(&self) -> serde_json::Value {
        let state = State { choice: self.choice.clone(), space: self.b.kept() };
        serde_json::to_value(state).unwrap_or_default()
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        let State { choice, space } = serde_json::from_value(state)?;
        self.choice = choice;
        self.b.set_state(space);
        Ok(())
    }

    fn space(&mut self) -> Option<&mut SpaceView> {
        Some(&mut self.b)
    }
}

impl Scene {
    /// A button for each of the pictures that answer a question.
    fn presets(&mut self, ui: &mut Ui, context: &mut Context) {
        for preset in &PRESETS {
            if !ui.button(preset.title).on_hover_text(preset.about).clicked() {
                continue;
            }
            let choice = Choice { properties: self.choice.properties, ..Choice::default() };
            let space = SpaceState::default();
            let at_first = serde_json::to_value(State { choice, space }).unwrap_or_default();
            let state = change_state(at_first, preset.settings, "scene");
            let shown = state.and_then(|state| Ok(self.set_state(state)?));
            if let Err(error) = shown {
                let what = format!("the picture {} cannot be shown", preset.name);
                context.problems.push(Problem { what, why: error.to_string() });
            }
        }
        ui.separator();
    }

    /// Whether A has a picture, and whether properties are shown.
    fn choices(&mut self, ui: &mut Ui) {
        let choice = &mut self.choice;
        ui.toggle_value(&mut choice.side_by_side, "A | B")
            .on_hover_text("Order A beside order B, with one camera, one range of colours and one playhead");
        ui.toggle_value(&mut choice.properties, "Properties")
            .on_hover_text("What is shown, and how, beside the picture");
    }

    /// What of A and B is compared.
    fn difference(&mut self, ui: &mut Ui) {
        let choice = &mut self.choice;
        ui.label("Difference of A and B").on_hover_text("Colours each ray by what differs between A and B");
        let name = choice.difference.map_or("none", Difference::name);
        let differences = Difference::ALL
            .map(|(difference, name, title)| (Some(difference), name.to_owned(), Some(title.to_owned())));
        let none = (None, "none".to_owned(), None);
        let choices = std::iter::once(none).chain(differences);
        choose(ui, ("difference", name), &mut choice.difference, choices);
        ui.toggle_value(&mut choice.table, "All differences").on_hover_text("What differs between A and B");
        if choice.difference.is_some() && self.compared.is_none() {
            ui.spinner();
        }
    }

    /// Finds out what differs, if anything that is shown needs it, and colours both views by it.
    fn compare(&mut self, context: &mut Context) {
        let Choice { side_by_side, difference, table, .. } = self.choice;
        let is_other = context.selection.baseline.recording.is_some();
        let is_wanted = side_by_side && (table || difference.is_some() || is_other);
        self.compared = if is_wanted { self.found(context) } else { None };
        let values = self.compared.as_ref().zip(difference).and_then(|(compared, difference)| {
            Some((difference, range(difference), compared.id, compared.values.as_ref()?))
        });
        for (side, view) in [&mut self.a, &mut self.b].into_iter().enumerate() {
            view.colour_by(values.map(|(difference, range, id, values)| RayValues {
                id: 2 * id + side as u64,
                title: difference.title(),
                of_ray: values[side].clone(),
                range: Some(range),
                logarithm: difference.logarithm(),
            }));
        }
    }

    fn found(&mut self, context: &mut Context) -> Option<Arc<Comparison>> {
        let a: Arc<Order> = context.of_baseline(|_| None, |context| context.order().ok())?;
        let b = context.order().ok()?;
        let (width, difference) = (context.selection.group_width, self.choice.difference);
        let wanted = ([a.serial, b.serial], width, difference);
        let numbers = [context.of_baseline(|_| None, |context| context.numbers(a)), context.numbers(b)];
        let [Some(a), Some(b)] = numbers else { return None };
        let make = move || Arc::new(Comparison::of(&[a.side(), b.side()], difference));
        self.comparing.of(wanted, context.waker(), make).ok().cloned()
    }

    /// The picture of A, seen as B is. A ray that is chosen in it is that of the same path in B.
    fn a_side(&mut self, ui: &mut Ui, context: &mut Context, height: f32) {
        let is_other = context.selection.baseline.recording.is_some();
        let comparison = self.compared.as_deref();
        let a_of = |ray| if is_other { comparison?.left_of(ray) } else { Some(ray) };
        let b_of = |ray| if is_other { comparison?.right_of(ray) } else { Some(ray) };
        let style = context.style_of(&context.selection.baseline.method);
        let Self { a, b, .. } = self;
        a.follow(b);
        let [before, chosen] = context.of_baseline(a_of, |context| {
            let before = context.selection.rays();
            side(ui, context, ("A", style, height), a);
            [before, context.selection.rays()]
        });
        b.options.clone_from(&a.options);
        b.look_from(a.camera);
        if chosen != before {
            context.select_rays(chosen.into_iter().filter_map(b_of).collect());
        }
    }

    fn b_side(&mut self, ui: &mut Ui, context: &mut Context, height: f32) {
        let style = context.style_of(&context.selection.method);
        side(ui, context, ("B", style, height), &mut self.b);
    }
}

/// The picture of the selected order below its name.
fn side(ui: &mut Ui, context: &mut Context, (name, style, height): (&str, usize, f32), view: &mut SpaceView) {
    let order = context.order().ok();
    let area = order.as_ref().and_then(|order| context.groups(order)).map(|groups| groups.mean_area);
    let label = context.recording().filter(|_| context.recordings.len() > 1);
    let label = label.map_or(String::new(), |open| format!(" of {}", open.label));
    let area = area.map_or(String::new(), |area| format!("mean capsule area {area:.4}"));
    let top = ui.cursor().top();
    ui.horizontal(|ui| {
        ui.strong(name);
        swatch(ui, style);
        ui.add(egui::Label::new(format!("{}{label}", context.selection.method)).truncate());
        ui.add(egui::Label::new(egui::RichText::new(area).weak()).truncate());
    });
    let room = height - (ui.cursor().top() - top);
    view.picture(ui, context, egui::vec2(ui.available_width(), room));
}

/// What the ends of the colours stand for.
fn range(difference: Difference) -> ValueRange {
    match difference {
        Difference::Displacement | Difference::Hit | Difference::Key => ValueRange { low: 0.0, high: 1.0 },
        Difference::Distance => ValueRange { low: LOWEST_DISTANCE, high: 0.0 },
        Difference::CapsuleArea => RATIOS,
    }
}
