//! Where the words of an SVG are.

use resvg::usvg::{Group, Node, Tree};

/// A line of text on the page.
pub(super) struct TextBox {
    pub(super) words: String,
    /// Around it, pixels, turned with it.
    pub(super) corners: [(f32, f32); 4],
    /// Of its font, pixels.
    pub(super) size: f32,
}

/// All text of a drawing.
pub(super) fn texts(tree: &Tree) -> Vec<TextBox> {
    let mut found = Vec::new();
    collect(tree.root(), &mut found);
    found
}

fn collect(group: &Group, found: &mut Vec<TextBox>) {
    for node in group.children() {
        match node {
            Node::Group(inner) => collect(inner, found),
            Node::Text(text) => {
                let place = text.bounding_box();
                let transform = text.abs_transform();
                let scale = transform.get_scale().0;
                let chunk = &text.chunks()[0];
                let size = chunk.spans()[0].font_size().get() * scale;
                // Of the height, what letters with and without tails take.
                let (top, bottom) = (place.top(), place.bottom());
                let mut corners = [
                    (place.left(), top),
                    (place.right(), top),
                    (place.right(), bottom),
                    (place.left(), bottom),
                ];
                for (x, y) in &mut corners {
                    let mut mapped = resvg::tiny_skia::Point::from_xy(*x, *y);
                    transform.map_point(&mut mapped);
                    (*x, *y) = (mapped.x, mapped.y);
                }
                found.push(TextBox { words: chunk.text().to_owned(), corners, size });
            }
            _ => {}
        }
    }
}

/// Whether two boxes share more than this many pixels in every direction: no side of either one
/// separates them.
pub(super) fn overlap(one: &TextBox, other: &TextBox, tolerance: f32) -> bool {
    let directions = [one, other].into_iter().flat_map(|text| {
        let [a, b, _, d] = text.corners;
        [(b.0 - a.0, b.1 - a.1), (d.0 - a.0, d.1 - a.1)]
    });
    directions.into_iter().all(|(x, y)| {
        let length = x.hypot(y).max(1e-6);
        let reach = |text: &TextBox| {
            let along = text.corners.map(|corner| (corner.0 * x + corner.1 * y) / length);
            along
                .into_iter()
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
        };
        let ((low, high), (other_low, other_high)) = (reach(one), reach(other));
        high.min(other_high) - low.max(other_low) > tolerance
    })
}

/// Filled shapes and pictures.
pub(super) fn count_marks(tree: &Tree) -> usize {
    fn count(group: &Group) -> usize {
        let marks = group.children().iter().map(|node| match node {
            Node::Group(inner) => count(inner),
            Node::Path(path) => usize::from(path.fill().is_some()),
            Node::Image(_) => 1,
            Node::Text(_) => 0,
        });
        marks.sum()
    }
    count(tree.root())
}

#[test]
fn turned_boxes_beside_each_other_do_not_overlap() {
    let slanted = |x: f32| TextBox {
        words: String::new(),
        corners: [(x, 0.0), (x + 10.0, 10.0), (x + 8.0, 12.0), (x - 2.0, 2.0)],
        size: 8.0,
    };
    assert!(!overlap(&slanted(0.0), &slanted(5.0), 0.1));
    assert!(overlap(&slanted(0.0), &slanted(3.0), 0.1));
}
