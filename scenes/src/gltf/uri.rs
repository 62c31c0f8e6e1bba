//! The bytes behind a URI: base64 data, or a file next to the glTF file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use percent_encoding::percent_decode_str;

use super::error::UriError;

/// Reads at most `limit` bytes of what `uri` names. Relative paths start at `folder`.
pub(super) fn read(uri: &str, folder: &Path, limit: u64) -> Result<Vec<u8>, UriError> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode_data(data);
    }
    if let Some((scheme, _)) = uri.split_once(':') {
        return Err(UriError::Scheme { scheme: scheme.into() });
    }
    let Ok(relative) = percent_decode_str(uri).decode_utf8() else {
        return Err(UriError::NotUtf8 { uri: uri.into() });
    };
    if Path::new(&*relative).has_root() {
        return Err(UriError::Absolute { uri: uri.into() });
    }
    read_file(&folder.join(&*relative), limit)
}

/// The bytes of a data URI, given without its `data:`.
fn decode_data(data: &str) -> Result<Vec<u8>, UriError> {
    let Some((_, encoded)) = data.split_once(";base64,") else {
        return Err(UriError::NotBase64);
    };
    let engine = base64::engine::general_purpose::STANDARD;
    engine.decode(encoded).map_err(|source| UriError::Base64 { source })
}

fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, UriError> {
    let failed = |source| UriError::File { path: path.into(), source };
    // Before opening, which would wait for ever on a pipe.
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(UriError::NotAFile { path: path.into() });
    }
    let file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::with_capacity(metadata.len().min(limit) as usize);
    file.take(limit).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}
