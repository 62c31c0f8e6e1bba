//! What `export` writes is what the recording holds, and its geometry is where the rays are.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]

mod on_disk;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use formats::manifest::{MethodArray, Place, QueueArray};
use formats::ray::{Hit, Ray};
use formats::reader::Dump;
use on_disk::sample::QUEUE;
use on_disk::written;

fn inspector(arguments: &[&str], paths: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inspector")).args(arguments).args(paths).output().unwrap()
}

/// Exports into a folder beside the recording.
fn export(dump: &Path, arguments: &[&str]) -> PathBuf {
    let out = dump.with_file_name(arguments.join("_"));
    let output = inspector(&[&["export"], arguments].concat(), &[Path::new("--out"), &out, dump]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

/// A place and a colour.
type Vertex = ([f32; 3], [u8; 3]);

/// Vertices and the count of the other element of a binary PLY.
fn read_ply(path: &Path) -> (Vec<Vertex>, usize) {
    let bytes = fs::read(path).unwrap();
    let end = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(element));
        line.map_or(0, |count| count.trim().parse().unwrap())
    };
    let vertices: usize = count("element vertex");
    let (edges, faces): (usize, usize) = (count("element edge"), count("element face"));
    assert_eq!(bytes.len(), end + vertices * 15 + edges * 8 + faces * 13, "{header}");
    let read = |at: usize| {
        let vertex = &bytes[end + at * 15..][..15];
        let part = |axis: usize| f32::from_le_bytes(vertex[axis * 4..axis * 4 + 4].try_into().unwrap());
        ([part(0), part(1), part(2)], [vertex[12], vertex[13], vertex[14]])
    };
    let rest = end + vertices * 15;
    for edge in bytes[rest..rest + edges * 8].chunks(4) {
        assert!((u32::from_le_bytes(edge.try_into().unwrap()) as usize) < vertices);
    }
    for face in bytes[rest + edges * 8..].chunks(13) {
        let corners = face[1..].chunks(4).map(|corner| u32::from_le_bytes(corner.try_into().unwrap()));
        assert!(face[0] == 3 && corners.into_iter().all(|corner| (corner as usize) < vertices));
    }
    ((0..vertices).map(read).collect(), edges + faces)
}

#[test]
fn csv_has_each_ray_in_the_order_of_the_method() {
    let (_folder, path) = written();
    let dump = Dump::open(&path).unwrap();
    let method = &dump.manifest().methods[0].name;
    let out = export(&path, &["--format", "csv", "--method", method]);
    let rays = dump.array::<Ray>(&Place::Queue(QUEUE, QueueArray::Rays)).unwrap();
    let hits = dump.array::<Hit>(&Place::Queue(QUEUE, QueueArray::Hits)).unwrap();
    let place = Place::Method(QUEUE, method.clone(), MethodArray::Permutation);
    let permutation = dump.array::<u32>(&place).unwrap();
    let mut reader =
        csv::Reader::from_path(out.join(format!("pass-001-bounce-01-closest-{method}.csv"))).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), rays.len());
    for (place, row) in rows.iter().enumerate() {
        let index = permutation[place] as usize;
        assert_eq!((row[0].parse(), row[1].parse()), (Ok(place), Ok(index)));
        let number = |at: usize| row[at].parse::<f32>().unwrap();
        assert_eq!([number(3), number(4), number(5)], rays[index].origin);
        assert_eq!([number(7), number(8), number(9)], rays[index].direction);
        assert_eq!(number(11), hits[index].t);
        assert_eq!(row[12].parse().ok(), hits[index].is_hit().then_some(hits[index].triangle));
    }
}

#[test]
fn ply_has_rays_hits_curve_and_capsules() {
    let (_folder, path) = written();
    let dump = Dump::open(&path).unwrap();
    let out = export(&path, &["--format", "ply"]);
    let read = |what: &str| read_ply(&out.join(format!("pass-001-bounce-01-closest-unsorted-{what}.ply")));
    let rays = dump.array::<Ray>(&Place::Queue(QUEUE, QueueArray::Rays)).unwrap();
    let hits = dump.array::<Hit>(&Place::Queue(QUEUE, QueueArray::Hits)).unwrap();
    let (vertices, edges) = read("rays");
    assert_eq!((vertices.len(), edges), (2 * rays.len(), rays.len()));
    for (at, (ray, hit)) in rays.iter().zip(hits.iter()).enumerate() {
        let (start, end) = (vertices[2 * at].0, vertices[2 * at + 1].0);
        assert_eq!(start, ray.origin);
        let length = (0..3).map(|axis| (end[axis] - start[axis]).powi(2)).sum::<f32>().sqrt();
        assert!(!hit.is_hit() || (length - hit.t).abs() < 1e-4 * (1.0 + hit.t), "ray {at}: {length}");
    }
    let count = hits.iter().filter(|hit| hit.is_hit()).count();
    assert!(count > 0 && count < rays.len(), "the sample has hits and misses");
    assert_eq!(read("hits").0.len(), count);
    let (curve, steps) = read("curve");
    assert_eq!((curve.len(), steps), (rays.len(), rays.len() - 1));
    assert_eq!((curve[0].1, curve[rays.len() - 1].1), ([68, 1, 84], [253, 231, 37]));
    let (corners, _) = read("capsules");
    assert_eq!(corners.len() % rays.len().div_ceil(64), 0);
    for (ray, group) in rays.iter().zip((0..).map(|at| at / 64)) {
        let per_group = corners.len() / rays.len().div_ceil(64);
        let mesh = &corners[group * per_group..][..per_group];
        for axis in 0..3 {
            let low = mesh.iter().map(|corner| corner.0[axis]).fold(f32::INFINITY, f32::min);
            let high = mesh.iter().map(|corner| corner.0[axis]).fold(f32::NEG_INFINITY, f32::max);
            // Facets cut a little off the sphere.
            let room = 0.05 * (high - low);
            let origin = ray.origin[axis];
            assert!(origin > low - room && origin < high + room, "{origin} is not in {low} to {high}");
        }
    }
}

/// Against the path indices of all queues of the pass, and the rays there.
#[test]
fn paths_are_the_rays_of_all_bounces_of_the_same_pixels() {
    let (_folder, path) = written();
    let dump = Dump::open(&path).unwrap();
    let out = export(&path, &["--format", "ply", "--group", "1"]);
    let (vertices, edges) = read_ply(&out.join("pass-001-bounce-01-closest-unsorted-group-1-paths.ply"));
    let pixels_of = |queue| dump.array::<u32>(&Place::Queue(queue, QueueArray::PathIds)).unwrap();
    let group: Vec<u32> = pixels_of(QUEUE)[64..128].to_vec();
    let mut expected = Vec::new();
    for queue in dump.manifest().queues.iter().map(|queue| queue.id).filter(|id| id.pass == QUEUE.pass) {
        let rays = dump.array::<Ray>(&Place::Queue(queue, QueueArray::Rays)).unwrap();
        let pixels = pixels_of(queue);
        let of_group = pixels.iter().zip(rays.iter()).filter(|(pixel, _)| group.contains(pixel));
        expected.extend(of_group.map(|(_, ray)| ray.origin));
    }
    assert!(expected.len() > 3 * group.len(), "{} rays on {} paths", expected.len(), group.len());
    assert_eq!(edges, expected.len());
    assert_eq!(vertices.iter().step_by(2).map(|(origin, _)| *origin).collect::<Vec<_>>(), expected);
    // Camera rays are dark blue, those of the last bounce are yellow.
    assert_eq!((vertices[0].1, vertices[vertices.len() - 1].1), ([68, 1, 84], [253, 231, 37]));
}

#[test]
fn one_group_is_one_group() {
    let (_folder, path) = written();
    let out = export(&path, &["--format", "csv", "--kind", "shadow", "--group", "1", "--group-width", "32"]);
    let text = fs::read_to_string(out.join("pass-001-bounce-01-shadow-unsorted-group-1.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].ends_with(",distance,light"), "{}", lines[0]);
    assert!(lines.len() == 33 && lines[1].starts_with("32,32,"), "{} lines", lines.len());
}

#[test]
fn what_is_not_there_is_one_sentence() {
    let (folder, path) = written();
    let blocked = folder.path().join("file");
    fs::write(&blocked, "no folder").unwrap();
    let out = folder.path().join("out");
    let is_refused = |arguments: &[&str], out: &Path, code: i32, expected: &str| {
        let output = inspector(arguments, &[Path::new("--out"), out, &path]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(expected) && !said.contains("panicked"), "{said}");
    };
    is_refused(&["export", "--format", "csv", "--bounce", "7"], &out, 1, "it has: ");
    is_refused(&["export", "--format", "csv", "--method", "none"], &out, 1, "has no ");
    is_refused(&["export", "--format", "csv", "--group", "9999"], &out, 1, "no group 9999");
    is_refused(&["export", "--format", "obj"], &out, 2, "csv, ply");
    is_refused(&["export", "--format", "csv"], &blocked, 1, "cannot write ");
    is_refused(&["plot", "--figure", "no-such"], &out, 1, "there is no figure no-such");
    is_refused(&["report"], &blocked, 1, "cannot write ");
}

#[test]
fn a_filter_leaves_the_rays_that_meet_it() {
    let (folder, path) = written();
    let filter = "t < 1.5 && direction.x > 0";
    let out = export(&path, &["--format", "csv", "--method", "aila", "--filter", filter]);
    let all = export(&path, &["--format", "csv", "--method", "aila"]);
    let rows = |folder: &Path, name: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(folder.join(name)).unwrap();
        text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let number = |cell: &String| cell.parse::<f32>().unwrap();
    let mut expected = rows(&all, "pass-001-bounce-01-closest-aila.csv");
    let whole = expected.len();
    // Columns: direction_x is the eighth, t the twelfth.
    expected.retain(|row| number(&row[11]) < 1.5 && number(&row[7]) > 0.0);
    assert!(!expected.is_empty() && expected.len() < whole);
    assert_eq!(rows(&out, "pass-001-bounce-01-closest-aila-filtered.csv"), expected);
    let files = export(&path, &["--format", "ply", "--filter", "hit"]);
    let names: Vec<String> =
        fs::read_dir(files).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.len() == 3 && !names.iter().any(|name| name.contains("capsules")), "{names:?}");
    let refused = inspector(
        &["export", "--format", "csv", "--filter", "t < 1 && hits", "--out"],
        &[&folder.path().join("x"), &path],
    );
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        !refused.status.success() && said.contains("did you mean 'hit'?") && said.contains("^^^^"),
        "{said}"
    );
}
