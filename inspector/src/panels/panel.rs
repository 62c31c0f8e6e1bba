//! The trait that all panels have in common.

use super::data::Data;
use super::space::SpaceView;
use crate::model::Context;

/// A part of the window.
pub trait Panel {
    /// Draws it and takes what is done to it.
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context);

    /// The numbers behind it.
    ///
    /// # Errors
    /// Why there are none.
    fn data(&mut self, _context: &mut Context) -> Result<Data, String> {
        Err("it shows no numbers of its own".to_owned())
    }

    /// What it shows besides the selection, as sessions keep it; null if there is nothing to keep.
    fn state(&self) -> serde_json::Value {
        serde_json::Value::Null
    }

    /// Takes what [`Panel::state`] gave.
    ///
    /// # Errors
    /// If that is no state of this panel.
    fn set_state(&mut self, _state: serde_json::Value) -> Result<(), serde_json::Error> {
        Ok(())
    }

    /// The view into space that it has, if it has one.
    fn space(&mut self) -> Option<&mut SpaceView> {
        None
    }
}
