//! Keys that belong to no panel.

use egui::{Key, Modifiers};
use formats::manifest::QueueId;

use super::ask::Asking;
use super::{App, Task};

impl App {
    pub(super) fn take_keys(&mut self, ui: &egui::Ui) {
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
        if pressed(Modifiers::NONE, Key::Escape) {
            self.context.selection.clear();
            (self.is_help_open, self.shown_command) = (false, None);
        }
        if ui.input(|input| {
            input.events.iter().any(|event| matches!(event, egui::Event::Text(text) if text == "?"))
        }) {
            self.is_help_open = !self.is_help_open;
        }
        for (key, step) in [(Key::ArrowDown, 1), (Key::ArrowUp, -1)] {
            if pressed(Modifiers::NONE, key) {
                self.next_order(step);
            }
        }
        for (key, step) in [(Key::ArrowRight, 1), (Key::ArrowLeft, -1)] {
            if pressed(Modifiers::NONE, key) {
                self.next_bounce(step);
            }
        }
    }

    /// Goes to the next order of the queue, or the one before.
    fn next_order(&mut self, step: isize) {
        let methods = self.context.methods();
        let now = methods.iter().position(|method| *method == self.context.selection.method);
        let next = now.and_then(|now| now.checked_add_signed(step)).and_then(|next| methods.get(next));
        if let Some(next) = next.cloned() {
            self.context.order_by(&next);
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
