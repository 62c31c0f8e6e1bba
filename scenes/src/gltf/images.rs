//! Decoding of PNG and JPEG images, in parallel and each once.

use std::borrow::Cow;
use std::io::Cursor;

use ::gltf::json::{Index, image::Image};
use image::{ImageError, ImageReader, RgbaImage};
use rayon::prelude::*;

use super::error::GltfError;
use super::{Document, uri};
use crate::{Texture, memory};

/// The longest file of one image that is read, in bytes.
const MAX_IMAGE_FILE_BYTES: u64 = 1 << 32;

/// An image that some material needs, and in which form.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// Its number in the file.
    pub(super) image: Index<Image>,
    /// Its texels.
    pub(super) texels: bool,
    /// Its mean colour.
    pub(super) mean: bool,
}

/// What became of a [`Wanted`] image.
pub(super) struct Decoded {
    pub(super) texture: Option<Texture>,
    /// Mean of red, green, blue and alpha, taken as numbers from 0 to 1. Zero if not wanted.
    pub(super) mean: [f32; 4],
    /// Mean of the red, green and blue light that the bytes stand for as sRGB. Zero if not wanted.
    pub(super) mean_linear: [f32; 3],
}

/// Decodes all images, in the same order, if their pixels fit into memory.
pub(super) fn decode_all(document: &Document, wanted: &[Wanted]) -> Result<Vec<Decoded>, GltfError> {
    let encoded = wanted.par_iter().map(|wanted| find(document, wanted.image));
    let encoded = encoded.collect::<Result<Vec<Encoded>, GltfError>>()?;
    let bytes = encoded.iter().fold(0_u64, |all, image| all.saturating_add(image.decoded_bytes));
    memory::check(bytes, memory::free())
        .map_err(|source| GltfError::Memory { what: format!("its {} images", wanted.len()), source })?;
    wanted.par_iter().zip(encoded).map(|(wanted, encoded)| decode(wanted, &encoded.bytes)).collect()
}

/// An image as it lies in the file.
struct Encoded<'a> {
    bytes: Cow<'a, [u8]>,
    /// What its pixels take.
    decoded_bytes: u64,
}

/// Finds an image and how large it says it is.
fn find<'a>(document: &'a Document, image: Index<Image>) -> Result<Encoded<'a>, GltfError> {
    let index = image.value();
    let json = document.get(image, || "a texture".into(), "image")?;
    let bytes = match (json.buffer_view, &json.uri) {
        (Some(view), _) => Cow::Borrowed(document.view(view, || format!("image {index}"))?.0),
        (None, Some(uri)) => Cow::Owned(
            uri::read(uri, document.folder, MAX_IMAGE_FILE_BYTES)
                .map_err(|source| GltfError::Uri { what: format!("image {index}"), source })?,
        ),
        (None, None) => return Err(GltfError::NoImageData { image: index }),
    };
    let (width, height) = reader(&bytes)
        .and_then(ImageReader::into_dimensions)
        .map_err(|source| GltfError::Image { image: index, source })?;
    Ok(Encoded { bytes, decoded_bytes: 4 * u64::from(width) * u64::from(height) })
}

/// By content: declared types are often wrong. The reader's own limits bound what one image allocates.
fn reader(encoded: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, ImageError> {
    ImageReader::new(Cursor::new(encoded)).with_guessed_format().map_err(ImageError::IoError)
}

fn decode(wanted: &Wanted, encoded: &[u8]) -> Result<Decoded, GltfError> {
    let pixels = reader(encoded)
        .and_then(ImageReader::decode)
        .map_err(|source| GltfError::Image { image: wanted.image.value(), source })?
        .into_rgba8();
    let linear: [f32; 256] = std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0));
    Ok(Decoded {
        mean: if wanted.mean { mean(&pixels, |byte| f32::from(byte) / 255.0) } else { [0.0; 4] },
        mean_linear: if wanted.mean { mean(&pixels, |byte| linear[byte as usize]) } else { [0.0; 3] },
        texture: wanted.texels.then(|| Texture {
            width: pixels.width(),
            height: pixels.height(),
            rgba: pixels.pixels().map(|pixel| pixel.0).collect(),
        }),
    })
}

/// The mean of the first `N` of red, green, blue and alpha, each byte standing for `value(byte)`.
fn mean<const N: usize>(pixels: &RgbaImage, value: impl Fn(u8) -> f32) -> [f32; N] {
    let mut sum = [0.0_f64; N];
    for pixel in pixels.pixels() {
        for (sum, &byte) in sum.iter_mut().zip(&pixel.0) {
            *sum += f64::from(value(byte));
        }
    }
    let count = (f64::from(pixels.width()) * f64::from(pixels.height())).max(1.0);
    sum.map(|sum| (sum / count) as f32)
}

/// The transfer function of IEC 61966-2-1.
fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
