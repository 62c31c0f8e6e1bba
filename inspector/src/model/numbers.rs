//! What the numbers of an order's rays are read from.

use std::sync::Arc;

use formats::key::Encoder;
use formats::manifest::Header;
use formats::metrics::quantity::{OrderedRays, Quantity};

use super::groups::Groups;
use super::order::Order;
use crate::analysis::GroupWidth;
use crate::analysis::comparison::Side;
use crate::filter::{self, Expression, FilterError, FilteredRays, Passing};

/// All that numbers of an order's rays are read from.
#[derive(Clone, Debug)]
pub struct Numbers {
    /// The order.
    pub order: Arc<Order>,
    /// Rays of a group.
    pub width: GroupWidth,
    image_width: u32,
    cells: Option<Encoder>,
}

impl Numbers {
    /// Of an order of a recording.
    pub fn of(order: Arc<Order>, header: &Header, width: GroupWidth) -> Self {
        Self { order, width, image_width: header.options.width.max(1), cells: header.cell_encoder() }
    }

    /// Finds what is found once for all rays, on this thread: to be called before the numbers of rays are asked
    /// for, by many threads at once or not.
    pub fn prepare(&self, quantity: Quantity) {
        if quantity.is_of_group() {
            self.order.groups(self.width);
        }
    }

    /// The places whose rays meet an expression.
    ///
    /// # Errors
    /// If it asks for what is not known of these rays.
    pub fn passing(&self, expression: &Expression) -> Result<Passing, FilterError> {
        if expression.takes_groups() {
            self.order.groups(self.width);
        }
        let fields = self.order.readable_fields();
        filter::passing(expression, &FilteredRays { rays: self.rays(), method: &self.order.method, fields })
    }

    /// The order as one of two that are compared.
    pub fn side(&self) -> Side<'_> {
        let order = &*self.order;
        let mean_area = order.groups(self.width).mean_area;
        let layout = order.keys.as_ref().map_or("", |(_, layout)| &layout.text);
        Side { name: &order.method, rays: self.rays(), place_of_ray: order.place_of_ray(), layout, mean_area }
    }

    /// The rays, with all that is known of them now.
    pub fn rays(&self) -> OrderedRays<'_> {
        let (order, queue) = (&*self.order, &*self.order.queue);
        OrderedRays {
            id: queue.id,
            image_width: self.image_width,
            traced: &queue.traced,
            lengths: &queue.lengths,
            path_ids: &queue.path_ids,
            lights: queue.lights.as_deref(),
            materials: queue.materials.as_deref().map_err(String::as_str),
            work: queue.work.as_deref().map_err(String::as_str),
            table: queue.table.as_ref().map_err(String::as_str),
            cells: self.cells.as_ref(),
            places: &order.places,
            keys: order.keys.as_ref().map(|(keys, layout)| (keys, layout.key_bits)).map_err(String::as_str),
            group_width: self.width.rays(),
            groups: order.known_groups(self.width).map_or(&[], |known: &Groups| &known.groups),
        }
    }
}
