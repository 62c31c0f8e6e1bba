//! From SVG to PNG and PDF, with the embedded font alone.

use std::sync::{Arc, LazyLock};

use krilla::geom::Size;
use krilla::page::PageSettings;
use krilla_svg::{SurfaceExt, SvgSettings};
use resvg::{tiny_skia, usvg};

use super::FigureError;
use super::model::Picture;
use super::style::{DOTS_PER_INCH, FONT, FONT_FAMILY, POINTS_PER_INCH};

static FONTS: LazyLock<Arc<usvg::fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family(FONT_FAMILY);
    Arc::new(fonts)
});

/// CSS pixels per inch: what usvg counts in.
const PIXELS_PER_INCH: f64 = 96.0;
/// Metres per inch.
const METRES_PER_INCH: f64 = 0.0254;

/// Reads an SVG with the embedded font.
///
/// # Errors
/// If it is no SVG.
pub(crate) fn tree(svg: &str) -> Result<usvg::Tree, FigureError> {
    let options = usvg::Options {
        fontdb: FONTS.clone(),
        font_family: FONT_FAMILY.to_owned(),
        ..usvg::Options::default()
    };
    usvg::Tree::from_str(svg, &options).map_err(|cause| FigureError::Render(cause.to_string()))
}

/// A PNG of an SVG at 300 dots per inch.
///
/// # Errors
/// If it cannot be read or is too large.
pub fn png(svg: &str) -> Result<Vec<u8>, FigureError> {
    let tree = tree(svg)?;
    let scale = (DOTS_PER_INCH / PIXELS_PER_INCH) as f32;
    let size = tree.size();
    let (width, height) = ((size.width() * scale).round() as u32, (size.height() * scale).round() as u32);
    let mut pixels = tiny_skia::Pixmap::new(width, height)
        .ok_or_else(|| FigureError::Render(format!("{width} × {height} pixels are too many")))?;
    pixels.fill(tiny_skia::Color::WHITE);
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
    // White lies below everything, so alpha is 255 everywhere.
    let rgb: Vec<u8> =
        pixels.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    let dots_per_metre = (DOTS_PER_INCH / METRES_PER_INCH).round() as u32;
    encode(width, height, &rgb, Some(dots_per_metre))
}

/// A PDF of an SVG, one page as wide as the figure; text stays text.
///
/// # Errors
/// If it cannot be read or converted.
pub fn pdf(svg: &str) -> Result<Vec<u8>, FigureError> {
    let tree = tree(svg)?;
    let points = (POINTS_PER_INCH / PIXELS_PER_INCH) as f32;
    let (width, height) = (tree.size().width() * points, tree.size().height() * points);
    let refused = || FigureError::Render(format!("a page of {width} × {height} points is no page"));
    let size = Size::from_wh(width, height).ok_or_else(refused)?;
    let mut document = krilla::Document::new();
    let mut page = document.start_page_with(PageSettings::new(size));
    let mut surface = page.surface();
    surface.draw_svg(&tree, size, SvgSettings::default()).ok_or_else(refused)?;
    surface.finish();
    page.finish();
    document.finish().map_err(|cause| FigureError::Render(format!("{cause:?}")))
}

/// The pixels of a picture as PNG.
///
/// # Errors
/// If it has another number of pixels than its sides say.
pub fn picture_png(picture: &Picture) -> Result<Vec<u8>, FigureError> {
    encode(picture.width, picture.height, picture.rgb.as_flattened(), None)
}

fn encode(width: u32, height: u32, rgb: &[u8], dots_per_metre: Option<u32>) -> Result<Vec<u8>, FigureError> {
    let failed = |cause: png::EncodingError| FigureError::Render(cause.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(dots_per_metre.map(|dots| png::PixelDimensions {
        xppu: dots,
        yppu: dots,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(rgb).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}
