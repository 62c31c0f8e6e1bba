//! Keys that belong to no panel.

use egui::{Key, Modifiers};
use formats::manifest::QueueId;

use super::ask::Asking;
use super::{App, Task};

impl App {
    pub(super) fn take_keys(&mut self, ui: &egui::Ui) {
        // Menus close by themselves. A question's line may have the keyboard.
        if !egui::Popup::is_any_open(ui.ctx())
            && (self.prompt.is_some() || !ui.ctx().egui_wants_keyboard_input())
            && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
        {
            self.close_top();
        }
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed =
            |modifiers: Modifiers, key: Key| ui.input_mut(|input| input.consume_key(modifiers, key));
        // The ones with more modifiers first: the others would take them too.
        for (modifiers, key, task) in [
            (Modifiers::COMMAND | Modifiers::SHIFT, Key::Z, Task::Redo),
            (Modifiers::COMMAND, Key::Y, Task::Redo),
            (Modifiers::COMMAND, Key::Z, Task::Undo),
            (Modifiers::ALT, Key::ArrowLeft, Task::Undo),
            (Modifiers::ALT, Key::ArrowRight, Task::Redo),
            (Modifiers::COMMAND, Key::O, Task::Ask(Asking::OpenRecording)),
            (Modifiers::COMMAND, Key::S, Task::Ask(Asking::SaveSession)),
            (Modifiers::NONE, Key::F5, Task::Refresh),
        ] {
            if pressed(modifiers, key) {
                self.task = Some(task);
            }
        }
        if ui.input(|input| {
            input.events.iter().any(|event| matches!(event, egui::Event::Text(text) if text == "?"))
        }) {
            self.is_help_open = !self.is_help_open;
        }
        // A slow frame takes several.
        let times = |key: Key| 0..ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key));
        for (key, step) in [(Key::ArrowDown, 1), (Key::ArrowUp, -1)] {
            times(key).for_each(|_| self.next_order(step, ui.ctx().cumulative_frame_nr()));
        }
        for (key, step) in [(Key::ArrowRight, 1), (Key::ArrowLeft, -1)] {
            times(key).for_each(|_| self.next_bounce(step));
        }
    }

    /// Closes what lies over everything else; where nothing does, nothing is selected any more.
    fn close_top(&mut self) {
        if self.prompt.take().is_none() && self.shown.take().is_none() {
            match self.is_help_open {
                true => self.is_help_open = false,
                false => self.context.selection.clear(),
            }
        }
    }

    /// Makes the next order of the table of methods B, or the one before.
    fn next_order(&mut self, step: isize, frame: u64) {
        let mut orders = self.context.ranking(frame);
        orders.retain(|order| order.elsewhere.is_none());
        let now = orders.iter().position(|order| order.method == self.context.selection.method);
        let next = now.and_then(|now| now.checked_add_signed(step)).and_then(|next| orders.get(next));
        if let Some(next) = next {
            self.context.order_by(&next.method);
        }
    }

    /// Goes to the same rays one bounce later or earlier.
    fn next_bounce(&mut self, step: i32) {
        let now = self.context.selection.queue;
        let Some(bounce) = now.bounce.checked_add_signed(step) else { return };
        let next = QueueId { bounce, ..now };
        if self.context.recording().is_some_and(|open| open.queue(next).is_some()) {
            self.context.go_to(next);
        }
    }
}
