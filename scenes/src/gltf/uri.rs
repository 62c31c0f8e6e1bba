//! The bytes behind a URI: base64 data, or a file next to the glTF file.

use std::borrow::Cow;
use std::path::Path;

use base64::Engine;
use percent_encoding::percent_decode_str;

use super::error::UriError;
use crate::files;

/// Reads at most `limit` bytes of what `uri` names. Relative paths start at `folder`.
pub(super) fn read(uri: &str, folder: &Path, limit: u64) -> Result<Vec<u8>, UriError> {
    match uri.split_once(':') {
        Some((scheme, data)) if scheme.eq_ignore_ascii_case("data") => return decode_data(data),
        // After a slash it is part of a path (RFC 3986 §4.2).
        Some((scheme, _)) if !scheme.contains('/') => return Err(UriError::Scheme { scheme: scheme.into() }),
        _ => {}
    }
    let Ok(relative) = percent_decode_str(uri).decode_utf8() else {
        return Err(UriError::NotUtf8 { uri: uri.into() });
    };
    if Path::new(&*relative).has_root() {
        return Err(UriError::Absolute { uri: uri.into() });
    }
    let path = folder.join(&*relative);
    files::read_start(&path, limit).map_err(|source| UriError::File { path, source })
}

/// The bytes of a data URI, given without its `data:`.
fn decode_data(data: &str) -> Result<Vec<u8>, UriError> {
    let Some((_, encoded)) = data.split_once(";base64,") else {
        return Err(UriError::NotBase64);
    };
    let engine = base64::engine::general_purpose::STANDARD;
    // Some exporters escape `+`, `/` and `=`.
    let encoded: Cow<[u8]> = percent_decode_str(encoded).into();
    engine.decode(encoded).map_err(|source| UriError::Base64 { source })
}
