//! Hierarchies on disk, by content hash: the second run of a scene starts without building.
//!
//! One file per scene content, format and builder version. All integers are little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `RSCPBVH` and the format version |
//! | 32 | SHA-256 of what the hierarchy was built from |
//! | 8 | number of nodes |
//! | 8 | number of leaf slots |
//! | 4 | CRC-32C of all bytes that follow |
//! | … | the nodes, then `order` as u32 |

use std::{
    env, fs,
    io::{self, Read, Write},
    path::{Path, PathBuf},
};

use bytemuck::{Pod, Zeroable};
use sha2::{Digest, Sha256};

use super::{Bvh, Bvh2Node, BvhError, BvhKind, CwbvhNode, WideNode, build, validate};
use crate::{Scene, files};

/// Raised with every change to the file's layout, the node formats or the way trees are built.
const FORMAT_VERSION: u8 = 4;

const MAGIC: [u8; 8] = [b'R', b'S', b'C', b'P', b'B', b'V', b'H', FORMAT_VERSION];

/// What comes before the nodes.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    content: [u8; 32],
    nodes: [u8; 8],
    slots: [u8; 8],
    checksum: [u8; 4],
}

/// Where a hierarchy came from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Read from the cache.
    Cached,
    /// Built now, and kept for the next run if a folder for that was given.
    Built,
    /// Built now; it could not be kept.
    BuiltNotKept {
        /// Why the cache could not be written, naming the file.
        reason: String,
    },
}

/// `$XDG_CACHE_HOME/rayscope/bvh`, or `~/.cache/rayscope/bvh` where that variable is not set;
/// `None` where neither it nor a home is known.
pub fn default_cache_folder() -> Option<PathBuf> {
    let absolute = |name| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(cache.join("rayscope").join("bvh"))
}

/// Loads the hierarchy of a scene from `cache_folder`, or builds it and keeps it there. Without a
/// folder it is always built. A damaged or foreign file is replaced.
///
/// # Errors
/// As for [`build`]; a cache that cannot be read or written is no error.
pub fn load_or_build(
    scene: &Scene,
    kind: BvhKind,
    cache_folder: Option<&Path>,
) -> Result<(Bvh, Source), BvhError> {
    let Some(folder) = cache_folder else {
        return Ok((build(scene, kind)?, Source::Built));
    };
    let content = content_hash(scene, kind);
    let path = folder.join(file_name(&content, kind));
    if let Some(bvh) = load(&path, &content, kind, scene) {
        return Ok((bvh, Source::Cached));
    }
    let bvh = build(scene, kind)?;
    let source = match keep(&path, &content, &bvh) {
        Ok(()) => Source::Built,
        Err(error) => Source::BuiltNotKept { reason: format!("{}: {error}", path.display()) },
    };
    Ok((bvh, source))
}

/// Hash of everything that a hierarchy depends on.
fn content_hash(scene: &Scene, kind: BvhKind) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(MAGIC);
    hash.update(kind.name());
    hash.update((scene.positions.len() as u64).to_le_bytes());
    hash.update(bytemuck::cast_slice::<_, u8>(&scene.positions));
    hash.update((scene.triangles.len() as u64).to_le_bytes());
    hash.update(bytemuck::cast_slice::<_, u8>(&scene.triangles));
    hash.finalize().into()
}

fn file_name(content: &[u8; 32], kind: BvhKind) -> String {
    let hexadecimal: String = content[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{hexadecimal}.{kind}")
}

/// Reads a hierarchy; `None` if there is none, or none that can be trusted.
fn load(path: &Path, content: &[u8; 32], kind: BvhKind, scene: &Scene) -> Option<Bvh> {
    let (file, bytes) = files::open(path).ok()?;
    let mut file = io::BufReader::new(file);
    let mut header = Header::zeroed();
    file.read_exact(bytemuck::bytes_of_mut(&mut header)).ok()?;
    let (nodes, slots) = (u64::from_le_bytes(header.nodes), u64::from_le_bytes(header.slots));
    // Nothing is allocated before the file's length agrees with what it claims to hold.
    let expected = nodes
        .checked_mul(node_bytes(kind) as u64)
        .and_then(|size| size.checked_add(slots.checked_mul(4)?))
        .and_then(|size| size.checked_add(size_of::<Header>() as u64))?;
    if header.magic != MAGIC || header.content != *content || bytes != expected {
        return None;
    }
    let mut checksum = 0;
    let bvh = match kind {
        BvhKind::Bvh2 => Bvh::Bvh2 {
            nodes: read_array(&mut file, nodes, &mut checksum)?,
            order: read_array(&mut file, slots, &mut checksum)?,
        },
        BvhKind::Cwbvh => Bvh::Cwbvh {
            nodes: read_array(&mut file, nodes, &mut checksum)?,
            order: read_array(&mut file, slots, &mut checksum)?,
        },
        BvhKind::Wide => Bvh::Wide {
            nodes: read_array(&mut file, nodes, &mut checksum)?,
            order: read_array(&mut file, slots, &mut checksum)?,
        },
    };
    let is_intact = u32::from_le_bytes(header.checksum) == checksum && validate(&bvh, scene).is_ok();
    is_intact.then_some(bvh)
}

/// Bytes of a node.
fn node_bytes(kind: BvhKind) -> usize {
    match kind {
        BvhKind::Bvh2 => size_of::<Bvh2Node>(),
        BvhKind::Cwbvh => size_of::<CwbvhNode>(),
        BvhKind::Wide => size_of::<WideNode>(),
    }
}

/// Reads `count` items and adds their bytes to the checksum.
fn read_array<T: Pod>(file: &mut impl Read, count: u64, checksum: &mut u32) -> Option<Vec<T>> {
    let mut items = vec![T::zeroed(); usize::try_from(count).ok()?];
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut items);
    file.read_exact(bytes).ok()?;
    *checksum = crc32c::crc32c_append(*checksum, bytes);
    Some(items)
}

/// Writes a hierarchy under another name and renames it, so that no reader ever sees half a file.
fn keep(path: &Path, content: &[u8; 32], bvh: &Bvh) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let nodes = bvh.node_bytes().len() / node_bytes(bvh.kind());
    let order: &[u8] = bytemuck::cast_slice(bvh.order());
    let header = Header {
        magic: MAGIC,
        content: *content,
        nodes: (nodes as u64).to_le_bytes(),
        slots: (bvh.order().len() as u64).to_le_bytes(),
        checksum: crc32c::crc32c_append(crc32c::crc32c(bvh.node_bytes()), order).to_le_bytes(),
    };
    let mut file = tempfile::NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")))?;
    file.write_all(bytemuck::bytes_of(&header))?;
    file.write_all(bvh.node_bytes())?;
    file.write_all(order)?;
    file.persist(path).map(drop).map_err(|error| error.error)
}

#[cfg(test)]
mod tests {
    use super::{super::tests::soup, *};

    /// Loads twice through a folder of its own.
    fn twice(damage: impl Fn(&Path)) -> (Source, Source, bool) {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let scene = soup(500, 1);
        let (first, built) = load_or_build(&scene, BvhKind::Cwbvh, Some(folder)).unwrap();
        let files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert_eq!(files.len(), 1, "one file and no leftovers: {files:?}");
        damage(&files[0]);
        let (second, again) = load_or_build(&scene, BvhKind::Cwbvh, Some(folder)).unwrap();
        (built, again, first == second)
    }

    #[test]
    fn what_was_built_is_loaded() {
        let (built, again, same) = twice(|_| {});
        assert!(matches!(built, Source::Built));
        assert_eq!(again, Source::Cached);
        assert!(same);
    }

    #[test]
    fn damaged_files_are_rebuilt() {
        let flip = |at: usize| {
            move |path: &Path| {
                let mut bytes = fs::read(path).unwrap();
                let at = at % bytes.len();
                bytes[at] ^= 0x10;
                fs::write(path, bytes).unwrap();
            }
        };
        for at in [0, 7, 9, 41, 47, 49, 57, 60, 61, 100, 4321, usize::MAX] {
            let (_, again, same) = twice(flip(at));
            assert!(matches!(again, Source::Built), "byte {at} changed: {again:?}");
            assert!(same);
        }
        let (_, again, _) = twice(|path| {
            let bytes = fs::read(path).unwrap();
            fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        });
        assert!(matches!(again, Source::Built), "half a file: {again:?}");
        let (_, again, _) = twice(|path| fs::write(path, b"").unwrap());
        assert!(matches!(again, Source::Built), "an empty file: {again:?}");
    }

    #[test]
    fn other_content_has_another_name() {
        let scene = soup(500, 1);
        let mut moved = scene.clone();
        moved.positions[3][1] += 1e-3;
        let mut turned = scene.clone();
        turned.triangles[7].swap(0, 1);
        let name = |scene: &Scene, kind| file_name(&content_hash(scene, kind), kind);
        let names = [
            name(&scene, BvhKind::Cwbvh),
            name(&scene, BvhKind::Bvh2),
            name(&moved, BvhKind::Cwbvh),
            name(&turned, BvhKind::Cwbvh),
        ];
        for (index, one) in names.iter().enumerate() {
            assert!(!names[index + 1..].contains(one), "{one} stands for two contents");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_is_no_error() {
        let scene = soup(20, 2);
        let file = tempfile::NamedTempFile::new().unwrap();
        let (_, source) = load_or_build(&scene, BvhKind::Bvh2, Some(&file.path().join("cache"))).unwrap();
        assert!(matches!(source, Source::BuiltNotKept { .. }), "{source:?}");
    }

    #[test]
    fn a_file_that_cannot_be_kept_leaves_nothing() {
        let scene = soup(20, 2);
        let folder = tempfile::tempdir().unwrap();
        let name = file_name(&content_hash(&scene, BvhKind::Bvh2), BvhKind::Bvh2);
        // A file cannot take the place of a folder.
        fs::create_dir(folder.path().join(&name)).unwrap();
        let (_, source) = load_or_build(&scene, BvhKind::Bvh2, Some(folder.path())).unwrap();
        assert!(matches!(source, Source::BuiltNotKept { .. }), "{source:?}");
        let left: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, [name.as_str()]);
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_in_place_of_a_file_is_not_waited_for() {
        let scene = soup(20, 2);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(file_name(&content_hash(&scene, BvhKind::Bvh2), BvhKind::Bvh2));
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let (_, source) = load_or_build(&scene, BvhKind::Bvh2, Some(folder.path())).unwrap();
        assert!(matches!(source, Source::Built), "{source:?}");
        assert!(fs::metadata(&path).unwrap().is_file(), "it is replaced, like any file that is no hierarchy");
    }
}
