//! The rays that pass the filter, sorted by any column, as a table of which only the rows in sight are made.
//!
//! The table scrolls by rows, not by pixels: f32 cannot tell the rows of a long table apart.

mod window;

use std::ops::Range;
use std::sync::Arc;

use egui::{Align, Layout};
use egui_extras::{Column, TableBuilder};
use formats::metrics::quantity::Quantity;
use serde::de::Error as _;
use serde::{Deserialize, Serialize};

use self::window::RowWindow;
use super::filter_box::{filter_box, filter_problem};
use super::notes::{found, select};
use crate::model::numbers::Numbers;
use crate::model::rows::{Direction, Rows, Sorting};
use crate::model::{Context, Order};
use crate::output::{count, counted};
use crate::panels::data::Data;
use crate::panels::panel::Panel;

/// Between columns, points.
const GAP: f32 = 14.0;
/// Room for the bar that scrolls sideways, points.
const BAR: f32 = 10.0;

pub(super) struct RaysPanel {
    window: RowWindow,
    sorting: Sorting,
    columns: Vec<ShownColumn>,
    /// The ray that was last scrolled to, and what it was looked for in.
    seen: Option<(usize, *const Rows)>,
    /// The place of the playhead that was last scrolled to.
    played: Option<usize>,
}

struct ShownColumn {
    quantity: Quantity,
    /// Most characters that were seen in it: columns grow, but never jump back and forth.
    characters: usize,
}

impl ShownColumn {
    fn of(quantity: Quantity) -> Self {
        // The name, and the mark of what rows are sorted by.
        Self { quantity, characters: quantity.name().len() + 2 }
    }
}

/// Columns that are shown at first.
const AT_FIRST: [Quantity; 12] = [
    Quantity::Place,
    Quantity::Ray,
    Quantity::Pixel,
    Quantity::Key,
    Quantity::Length,
    Quantity::Triangle,
    Quantity::OriginX,
    Quantity::OriginY,
    Quantity::OriginZ,
    Quantity::DirectionX,
    Quantity::DirectionY,
    Quantity::DirectionZ,
];

impl Default for RaysPanel {
    fn default() -> Self {
        let columns = AT_FIRST.into_iter().map(ShownColumn::of).collect();
        Self { window: RowWindow::default(), sorting: Sorting::default(), columns, seen: None, played: None }
    }
}

/// A triangle that points the way rows go: fonts have no such sign.
fn arrow(ui: &mut egui::Ui, direction: Direction) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(7.0, 5.0), egui::Sense::hover());
    let (base, tip) = match direction {
        Direction::Ascending => (rect.bottom(), rect.top()),
        Direction::Descending => (rect.top(), rect.bottom()),
    };
    let corners = [(rect.left(), base), (rect.right(), base), (rect.center().x, tip)];
    let corners = corners.map(|(x, y)| egui::pos2(x, y)).to_vec();
    let colour = ui.visuals().strong_text_color();
    ui.painter().add(egui::Shape::convex_polygon(corners, colour, egui::Stroke::NONE));
}

/// What sessions keep of the table.
#[derive(Serialize, Deserialize)]
struct State {
    columns: Vec<Quantity>,
    sorted_by: Quantity,
    descending: bool,
}

#[derive(Default)]
struct Done {
    clicked: Option<usize>,
    sorted: Option<Quantity>,
    copied: Option<Range<usize>>,
}

impl Panel for RaysPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let Some(order) = found(ui, context.order()) else { return };
        let Some(numbers) = context.numbers(order.clone()) else { return };
        ui.horizontal_wrapped(|ui| {
            filter_box(ui, context, (ui.available_width() - 130.0).clamp(80.0, 420.0))
        });
        filter_problem(ui, context);
        let shows_groups = self.columns.iter().any(|column| column.quantity.is_of_group());
        let has_groups = !shows_groups || context.groups(&order).is_some();
        let Some(rows) = context.rows(&order, self.sorting).filter(|_| has_groups) else {
            ui.spinner();
            return;
        };
        let row_height = ui.text_style_height(&egui::TextStyle::Monospace) + 4.0;
        let step = row_height + ui.spacing().item_spacing.y;
        let mut done = Done::default();
        ui.horizontal_wrapped(|ui| self.above(ui, &order, &rows, &mut done));
        let all = rows.len();
        let in_sight = (((ui.available_height() - BAR) / step - 1.0) as usize).clamp(1, 500);
        self.follow(context, &order, &rows, in_sight);
        if ui.rect_contains_pointer(ui.max_rect()) {
            let wheel = ui.input(|input| input.smooth_scroll_delta.y);
            self.window.scroll(-wheel / step, all, in_sight);
        }
        self.window.scroll(0.0, all, in_sight);
        let seen = self.window.rows(all, in_sight);
        self.table(ui, context, (&numbers, &rows), seen.clone(), row_height, &mut done);
        if let Some(range) = done.copied {
            let range = if range.is_empty() { seen } else { range };
            ui.ctx().copy_text(self.rows(numbers.clone(), rows.clone(), range).text());
        }
        if let Some(by) = done.sorted {
            self.sort(by);
        }
        if let Some(ray) = done.clicked {
            select(ui, context, Some(ray));
            self.seen = Some((ray, Arc::as_ptr(&rows)));
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let order = context.order()?;
        let rows = context.rows(&order, self.sorting).ok_or("its rows are still being sorted")?;
        let numbers = context.numbers(order).ok_or("no recording is open")?;
        let all = 0..rows.len();
        Ok(self.rows(numbers, rows, all))
    }

    fn state(&self) -> serde_json::Value {
        let state = State {
            columns: self.quantities(),
            sorted_by: self.sorting.by,
            descending: self.sorting.direction == Direction::Descending,
        };
        serde_json::to_value(state).unwrap_or_default()
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        let State { columns, sorted_by, descending } = serde_json::from_value(state)?;
        if columns.is_empty() {
            return Err(serde_json::Error::custom("a table has at least one column"));
        }
        self.columns = columns.into_iter().map(ShownColumn::of).collect();
        let direction = if descending { Direction::Descending } else { Direction::Ascending };
        self.sorting = Sorting { by: sorted_by, direction };
        if sorted_by != Quantity::Place && !self.quantities().contains(&sorted_by) {
            self.show_column(sorted_by);
        }
        Ok(())
    }
}

impl RaysPanel {
    fn quantities(&self) -> Vec<Quantity> {
        self.columns.iter().map(|column| column.quantity).collect()
    }

    /// Rows with the columns that are shown.
    fn rows(&self, numbers: Numbers, rows: Arc<Rows>, range: Range<usize>) -> Data {
        let columns = self.quantities();
        let names: Vec<&str> = columns.iter().map(|quantity| quantity.name()).collect();
        columns.iter().for_each(|&quantity| numbers.prepare(quantity));
        let row = move |row: usize| {
            let (rays, place) = (numbers.rays(), rows.place(row));
            columns.iter().map(|quantity| quantity.text(rays.at(place))).collect()
        };
        Data::new(&names, range.map(row))
    }

    /// How many rows there are, where the window starts, which columns it has, and what can be copied.
    fn above(&mut self, ui: &mut egui::Ui, order: &Order, rows: &Rows, done: &mut Done) {
        let rays = counted(order.len() as u64, "ray", "rays");
        ui.label(if rows.len() == order.len() {
            format!("{rays} by {}", order.method)
        } else {
            format!("{} of {rays} by {}", count(rows.len() as u64), order.method)
        });
        let last = rows.len().saturating_sub(1);
        ui.add(egui::DragValue::new(&mut self.window.first).range(0..=last).prefix("from row "))
            .on_hover_text("The first row in sight; drag, or type a row");
        ui.menu_button("columns", |ui| self.choose(ui))
            .response
            .on_hover_text("Which numbers of rays are shown");
        if ui
            .button("copy")
            .on_hover_text("Copies the rows in sight; a click on a row with the other button copies that row")
            .clicked()
        {
            done.copied = Some(0..0);
        }
    }

    fn choose(&mut self, ui: &mut egui::Ui) {
        let height = (ui.ctx().content_rect().height() - 80.0).max(120.0);
        egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
            for &quantity in Quantity::ALL {
                let at = self.columns.iter().position(|column| column.quantity == quantity);
                let mut is_shown = at.is_some();
                if ui.checkbox(&mut is_shown, quantity.name()).on_hover_text(quantity.about()).changed() {
                    match at {
                        Some(at) if self.columns.len() > 1 => drop(self.columns.remove(at)),
                        Some(_) => {}
                        None => self.show_column(quantity),
                    }
                }
            }
        });
    }

    /// Beside the place, where it is seen without scrolling.
    fn show_column(&mut self, quantity: Quantity) {
        self.columns.insert(self.columns.len().min(1), ShownColumn::of(quantity));
    }

    /// Sorts by a column; again by the same one: the other way.
    fn sort(&mut self, by: Quantity) {
        let direction = match self.sorting {
            Sorting { by: now, direction: Direction::Ascending } if now == by => Direction::Descending,
            _ => Direction::Ascending,
        };
        self.sorting = Sorting { by, direction };
        self.window = RowWindow::default();
    }

    /// Brings a ray that was selected elsewhere into sight, and that of the playhead.
    fn follow(&mut self, context: &Context, order: &Order, rows: &Arc<Rows>, in_sight: usize) {
        let played = context.playhead.place(order.len());
        if std::mem::replace(&mut self.played, played) != played
            && let Some(row) = played.and_then(|place| rows.row_of(place))
        {
            self.window.reveal(row, rows.len(), in_sight);
        }
        let selected = context.selection.ray.map(|ray| (ray, Arc::as_ptr(rows)));
        if self.seen == selected {
            return;
        }
        self.seen = selected;
        let place = selected.and_then(|(ray, _)| order.place_of_ray().get(ray));
        if let Some(row) = place.and_then(|&place| rows.row_of(place as usize)) {
            self.window.reveal(row, rows.len(), in_sight);
        }
    }

    fn table(
        &mut self,
        ui: &mut egui::Ui,
        context: &Context,
        (numbers, rows): (&Numbers, &Rows),
        seen: Range<usize>,
        row_height: f32,
        done: &mut Done,
    ) {
        let rays = numbers.rays();
        let cell = |column: &ShownColumn, row| column.quantity.text(rays.at(rows.place(row)));
        let cells = |row| self.columns.iter().map(|column| cell(column, row)).collect();
        let texts: Vec<Vec<String>> = seen.clone().map(cells).collect();
        for (at, column) in self.columns.iter_mut().enumerate() {
            let longest = texts.iter().map(|cells| cells[at].chars().count()).max().unwrap_or(0);
            column.characters = column.characters.max(longest);
        }
        let font = egui::TextStyle::Monospace.resolve(ui.style());
        let selected = context.selection.rays();
        let glyph = ui.fonts_mut(|fonts| fonts.glyph_width(&font, '0'));
        egui::ScrollArea::horizontal().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            let mut table = TableBuilder::new(ui)
                .striped(true)
                .vscroll(false)
                .sense(egui::Sense::click())
                .cell_layout(Layout::right_to_left(Align::Center));
            for column in &self.columns {
                table = table.column(Column::exact(column.characters as f32 * glyph + 2.0));
            }
            let header = |mut header: egui_extras::TableRow<'_, '_>| {
                for column in &self.columns {
                    header.col(|ui| self.header(ui, column.quantity, done));
                }
            };
            table.header(row_height, header).body(|body| {
                body.rows(row_height, seen.len(), |mut row| {
                    let number = seen.start + row.index();
                    let ray = numbers.order.places.ray(rows.place(number));
                    row.set_selected(selected.contains(&ray));
                    for text in &texts[row.index()] {
                        row.col(|ui| {
                            let text = egui::RichText::new(text).monospace();
                            ui.add(egui::Label::new(text).selectable(false).extend());
                        });
                    }
                    let response = row.response();
                    if response.clicked() {
                        done.clicked = Some(ray);
                    }
                    response.context_menu(|ui| {
                        if ui.button("Copy row").clicked() {
                            done.copied = Some(number..number + 1);
                            ui.close();
                        }
                    });
                });
            });
        });
    }

    /// The name of a column, which rows are sorted by on a click.
    fn header(&self, ui: &mut egui::Ui, quantity: Quantity, done: &mut Done) {
        if self.sorting.by == quantity {
            arrow(ui, self.sorting.direction);
        }
        let text = egui::RichText::new(quantity.name()).strong();
        let label = egui::Label::new(text).selectable(false).extend().sense(egui::Sense::click());
        let response = ui.add(label).on_hover_text(format!("{}. A click sorts by it", quantity.about()));
        if response.clicked() {
            done.sorted = Some(quantity);
        }
    }
}
