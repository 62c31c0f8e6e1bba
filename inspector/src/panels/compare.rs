//! Two orders of the same rays side by side, seen from one place: before sorting and after it.

use egui::ComboBox;
use formats::key::method::UNSORTED;

use super::missing;
use super::space::SpaceView;
use crate::model::Context;
use crate::panels::Panel;

/// The panel. Of the two views, the first has the controls and the slider of both.
pub(super) struct Compare {
    views: [SpaceView; 2],
    /// The order on the left; the selected one is on the right.
    before: String,
}

impl Compare {
    pub(super) fn new(format: wgpu::TextureFormat) -> Self {
        Self { views: [SpaceView::new(format), SpaceView::new(format)], before: UNSORTED.to_owned() }
    }
}

impl Panel for Compare {
    fn title(&self) -> &'static str {
        "Compare"
    }

    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        if context.recording().is_none() {
            return missing(ui, "no recording is open");
        }
        let methods = context.methods();
        if !methods.contains(&self.before) {
            UNSORTED.clone_into(&mut self.before);
        }
        self.views[0].controls(ui, context);
        self.views[1].options = self.views[0].options.clone();
        let height = ui.available_height() - SpaceView::slider_height(ui);
        ui.columns(2, |columns| {
            let [left, right] = columns else { return };
            self.order_before(left, context, &methods, height);
            order_selected(right, context, &methods);
            let size = right.available_width();
            let room = height - (right.cursor().top() - right.min_rect().top());
            let pose = self.views[0].pose();
            self.views[1].set_pose(pose);
            self.views[1].picture(right, context, egui::vec2(size, room));
            let pose = self.views[1].pose();
            self.views[0].set_pose(pose);
        });
        self.views[0].slider(ui);
    }

    fn space(&mut self) -> Option<&mut SpaceView> {
        self.views.first_mut()
    }
}

impl Compare {
    fn order_before(&mut self, ui: &mut egui::Ui, context: &mut Context, methods: &[String], height: f32) {
        let mut before = std::mem::take(&mut self.before);
        // The picture of the left half shows the same selection in another order.
        let selected = std::mem::replace(&mut context.selection.method, before.clone());
        let group = context.selection.group;
        context.select_ray(context.selection.ray);
        ui.horizontal(|ui| {
            choose(ui, "before", &mut before, methods);
            area(ui, context);
        });
        let room = height - (ui.cursor().top() - ui.min_rect().top());
        let ray = context.selection.ray;
        self.views[0].picture(ui, context, egui::vec2(ui.available_width(), room));
        let is_other_ray = context.selection.ray != ray;
        context.selection.method = selected;
        context.selection.group = group;
        if is_other_ray {
            context.select_ray(context.selection.ray);
        }
        self.before = before;
    }
}

fn order_selected(ui: &mut egui::Ui, context: &mut Context, methods: &[String]) {
    ui.horizontal(|ui| {
        let mut after = context.selection.method.clone();
        choose(ui, "after", &mut after, methods);
        if after != context.selection.method {
            context.selection.order_by(&after);
            context.select_ray(context.selection.ray);
        }
        area(ui, context);
    });
}

fn choose(ui: &mut egui::Ui, name: &str, chosen: &mut String, methods: &[String]) {
    ComboBox::from_id_salt(name).selected_text(chosen.as_str()).show_ui(ui, |ui| {
        for method in methods {
            ui.selectable_value(chosen, method.clone(), method);
        }
    });
}

/// The mean capsule area of the order that is selected.
fn area(ui: &mut egui::Ui, context: &mut Context) {
    let width = context.selection.group_width;
    if let Ok(order) = context.order() {
        ui.label(format!("mean capsule area {:.4}", order.groups(width).mean_area()));
    }
}
