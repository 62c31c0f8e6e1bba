//! Pictures as PNG files.

use std::path::Path;

use anyhow::Context as _;
use formats::files::replace;

/// Writes pixels of four bytes each, row by row; their opacity is left out. The file is written whole or not
/// at all.
pub(crate) fn write(path: &Path, [width, height]: [u32; 2], rgba: &[u8]) -> anyhow::Result<()> {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Best);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let encoded = encoder.write_header().and_then(|mut writer| writer.write_image_data(&rgb));
    encoded.context("the picture cannot be encoded")?;
    replace(path, |file| file.write_all(&png)).with_context(|| format!("cannot write {}", path.display()))
}
