//! The buffers of a file and the slices that buffer views cut out of them.

use std::borrow::Cow;
use std::path::Path;

use ::gltf::json::{Index, buffer::View};

use super::container::Parsed;
use super::error::GltfError;
use super::{Document, uri};

/// The bytes of every buffer, each at least as long as it says. A buffer may have none, as long as nothing
/// that is read lies in it.
pub(super) fn read<'a>(parsed: &Parsed<'a>, folder: &Path) -> Result<Vec<Option<Cow<'a, [u8]>>>, GltfError> {
    let mut buffers = Vec::with_capacity(parsed.lists.root.buffers.len());
    for (buffer, json) in parsed.lists.root.buffers.iter().enumerate() {
        let stated = json.byte_length.0;
        let bytes = match (&json.uri, parsed.binary) {
            (Some(uri), _) => Cow::Owned(
                uri::read(uri, folder, stated)
                    .map_err(|source| GltfError::Uri { what: format!("buffer {buffer}"), source })?,
            ),
            // The binary chunk belongs to the first buffer alone (glTF 2.0 §4.4.3.3).
            (None, Some(binary)) if buffer == 0 => Cow::Borrowed(binary),
            (None, _) => {
                buffers.push(None);
                continue;
            }
        };
        if (bytes.len() as u64) < stated {
            let found = bytes.len() as u64;
            return Err(GltfError::BufferLength { buffer, stated, found });
        }
        buffers.push(Some(bytes));
    }
    Ok(buffers)
}

impl Document<'_> {
    /// The bytes of a buffer view, and the view.
    pub(super) fn view(
        &self,
        index: Index<View>,
        from: impl FnOnce() -> String,
    ) -> Result<(&[u8], &View), GltfError> {
        let view = self.get(index, from, "buffer view")?;
        let buffer = view.buffer.value();
        let Some(bytes) = self.buffers.get(buffer) else {
            return Err(GltfError::Reference {
                from: format!("buffer view {}", index.value()),
                to: "buffer",
                index: buffer,
            });
        };
        let bytes = bytes.as_ref().ok_or(GltfError::NoBinaryChunk { buffer })?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        let slice = usize::try_from(start).ok().zip(usize::try_from(end).ok());
        match slice.and_then(|(start, end)| bytes.get(start..end)) {
            Some(slice) => Ok((slice, view)),
            None => Err(GltfError::View { view: index.value(), start, end, buffer, found: bytes.len() }),
        }
    }
}
