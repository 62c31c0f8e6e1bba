//! Every colour of the window, light and dark, in one place. Series have the colours of the figures.

use egui::{Color32, Theme as Mode};
use formats::manifest::Stage;
use formats::metrics::speedup::Verdict;

use crate::figures::style;

/// A colour as shaders take it: red, green, blue, alpha, 0 to 1, in sRGB.
pub type ShaderColour = [f32; 4];

/// Pictures as they are.
pub const UNTINTED: Color32 = Color32::WHITE;

/// Words on the bars of a series.
pub const ON_BARS: Color32 = Color32::WHITE;

/// Within marks of which only the edge is drawn.
pub const HOLLOW: Color32 = Color32::TRANSPARENT;

/// Size of small text, points: still read on a screen of low resolution.
const SMALL_TEXT: f32 = 11.0;

/// Text on a dark page, and how much of the colour of text is left where it is weak: it stands out from the page by
/// 4.5 to 1 all the same (WCAG 2.1).
const DARK_TEXT: Color32 = Color32::from_gray(190);
const WEAK_TEXT: f32 = 0.8;

/// How visible the handle of a scroll bar is while the pointer is elsewhere: a sign that there is more to see.
const IDLE_SCROLL_BAR: f32 = 0.5;

/// Sets what light and dark windows have in common.
pub fn set_up(context: &egui::Context) {
    context.all_styles_mut(|style| {
        if let Some(font) = style.text_styles.get_mut(&egui::TextStyle::Small) {
            font.size = SMALL_TEXT;
        }
        style.visuals.weak_text_alpha = WEAK_TEXT;
        style.spacing.scroll.dormant_handle_opacity = IDLE_SCROLL_BAR;
        if style.visuals.dark_mode {
            style.visuals.widgets.noninteractive.fg_stroke.color = DARK_TEXT;
        }
    });
}

/// A colour of a figure or a map: red, green, blue.
pub fn opaque([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

/// What the window is coloured by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theme {
    mode: Mode,
}

impl Theme {
    /// Of a window that is light or dark.
    pub fn of(context: &egui::Context) -> Self {
        Self { mode: context.theme() }
    }

    fn pick<T>(self, dark: T, light: T) -> T {
        if self.mode == Mode::Dark { dark } else { light }
    }

    /// Behind everything that is drawn in space.
    pub fn background(self) -> ShaderColour {
        self.pick([0.07, 0.075, 0.085, 1.0], [0.965, 0.965, 0.97, 1.0])
    }

    /// The scene's surfaces.
    pub fn mesh(self) -> ShaderColour {
        self.pick([0.46, 0.47, 0.50, 1.0], [0.86, 0.86, 0.88, 1.0])
    }

    /// What the colours of surfaces fade to, and how much of them is left: data are the brightest on a dark page
    /// and the darkest on a light one.
    pub fn faded(self) -> ShaderColour {
        self.pick([0.07, 0.075, 0.085, 0.55], [1.0, 1.0, 1.0, 0.6])
    }

    /// Their edges.
    pub fn edges(self) -> ShaderColour {
        self.pick([0.42, 0.44, 0.48, 1.0], [0.52, 0.53, 0.56, 1.0])
    }

    /// What is selected, in space.
    pub fn selected(self) -> ShaderColour {
        let [red, green, blue, _] = self.selected_mark().to_array().map(|part| f32::from(part) / 255.0);
        [red, green, blue, 1.0]
    }

    /// What is selected, in plots and pictures.
    pub fn selected_mark(self) -> Color32 {
        self.pick(Color32::from_rgb(0xff, 0x4f, 0xd8), Color32::from_rgb(0xd0, 0x00, 0x9a))
    }

    /// Pixels and cells of which nothing is known.
    pub fn nothing(self) -> Color32 {
        self.pick(Color32::from_rgb(0x16, 0x17, 0x1a), Color32::from_rgb(0xee, 0xee, 0xf0))
    }

    /// Rays that the filter leaves out, where others are shown.
    pub fn left_out(self) -> Color32 {
        self.pick(Color32::from_rgb(0x3a, 0x3b, 0x3f), Color32::from_rgb(0xc6, 0xc6, 0xca))
    }

    /// Lines to compare with, such as break-even.
    pub fn reference(self) -> Color32 {
        self.pick(Color32::from_rgb(0xd0, 0xd0, 0xd4), Color32::from_rgb(0x40, 0x40, 0x44))
    }

    /// What went wrong.
    pub fn problem(self) -> Color32 {
        self.pick(Color32::from_rgb(0xff, 0x8a, 0x70), Color32::from_rgb(0xb0, 0x20, 0x10))
    }

    /// What is surely faster or slower; `None` where it may be chance.
    pub fn verdict(self, verdict: Verdict) -> Option<Color32> {
        match verdict {
            Verdict::Faster => {
                Some(self.pick(Color32::from_rgb(0x4f, 0xd6, 0xa4), Color32::from_rgb(0x00, 0x74, 0x52)))
            }
            Verdict::Slower => Some(self.problem()),
            Verdict::NoSignificantDifference | Verdict::WithinControl | Verdict::Unknown => None,
        }
    }

    /// Text about a series: its colour, darker where it could not be read on a light page.
    pub fn series_text(self, number: usize) -> Color32 {
        /// Most that text on a light page may reflect, 0 to 1.
        const BRIGHTEST: f32 = 0.5;
        let colour = self.series(number);
        let [red, green, blue, _] = colour.to_array().map(|part| f32::from(part) / 255.0);
        let brightness = 0.299 * red + 0.587 * green + 0.114 * blue;
        if self.mode == Mode::Dark || brightness <= BRIGHTEST {
            return colour;
        }
        opaque([red, green, blue].map(|part| (part * BRIGHTEST / brightness * 255.0) as u8))
    }

    /// A series of this number, as in the figures.
    pub fn series(self, number: usize) -> Color32 {
        let colour = opaque(style::style(number).colour.0);
        // The figures' first colour is black, which no one sees on a dark page.
        if colour == Color32::BLACK && self.mode == Mode::Dark { self.reference() } else { colour }
    }

    /// A stage, by its place among all: of a ramp that no series has, as in the figures; on a dark page tracing is
    /// dark, as it is pale on a light one.
    pub fn stage(self, place: usize) -> Color32 {
        const ON_DARK: [[u8; 3]; Stage::OF_ORDERS.len()] = [
            [0xf0, 0xf0, 0xf0], // decide
            [0x8e, 0x5c, 0xd0], // key
            [0xa9, 0x9e, 0xe0], // sort
            [0xcf, 0xcf, 0xee], // gather
            [0x3e, 0x44, 0x4a], // trace
            [0x9a, 0xa5, 0xae], // scatter
            [0x50, 0x58, 0x60], // trace through indices
            [0x6e, 0x80, 0x8e], // accumulate
        ];
        let on_light = style::style(style::STAGE_STYLES + place).colour.0;
        opaque(self.pick(ON_DARK[place % ON_DARK.len()], on_light))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weak_text_can_be_read() {
        let context = egui::Context::default();
        set_up(&context);
        let luminance = |colour: Color32| {
            let [red, green, blue, _] = egui::Rgba::from(colour).to_array();
            0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05
        };
        for mode in [Mode::Dark, Mode::Light] {
            let visuals = context.style_of(mode).visuals.clone();
            let page = visuals.panel_fill;
            let [text, page] = [page.blend(visuals.weak_text_color()), page].map(luminance);
            let contrast = text.max(page) / text.min(page);
            assert!(contrast >= 4.5, "{mode:?}: {contrast}");
        }
    }
}
