//! What `export --format parquet` writes is what the recording holds, complete or not at all.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]

mod on_disk;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use formats::manifest::{MethodArray, Place, QueueArray, QueueId, SceneArray};
use formats::ray::{Hit, Kind, Ray, Work};
use formats::reader::Dump;
use formats::study::{JOB_VERSION, JobRecord};
use formats::writer::DumpWriter;
use on_disk::sample::{self, QUEUE};
use on_disk::written;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};

fn export(input: &Path, out: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inspector"));
    command.args(["export", "--format", "parquet"]).args(arguments).arg("--out").args([out, input]);
    command.output().unwrap()
}

fn exported(input: &Path, out: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = export(input, out, &[&["--json"], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn is_refused(output: &Output, part: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains(part) && !said.contains("panicked"), "{said}");
}

fn reader(path: &Path) -> SerializedFileReader<File> {
    SerializedFileReader::new(File::open(path).unwrap()).unwrap()
}

/// The rows of a file, as they lie in it.
fn rows(path: &Path) -> Vec<BTreeMap<String, Field>> {
    let of = |row: Row| row.get_column_iter().map(|(name, value)| (name.clone(), value.clone())).collect();
    reader(path).get_row_iter(None).unwrap().map(|row| of(row.unwrap())).collect()
}

/// Every file of rays below a folder.
fn ray_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        if entry.path().is_dir() {
            found.extend(ray_files(&entry.path()));
        } else {
            found.push(entry.path());
        }
    }
    found.sort();
    found
}

/// The file of a queue in the order of a method.
fn file_of(out: &Path, queue: QueueId, method: &str) -> PathBuf {
    let is_of = |path: &PathBuf| {
        let path = path.to_str().unwrap();
        let partition = format!("bounce={}/kind={}/method={method}/", queue.bounce, queue.kind);
        path.contains(&partition) && path.ends_with(&format!("-pass-{:03}.parquet", queue.pass))
    };
    ray_files(&out.join("rays")).into_iter().find(is_of).unwrap()
}

#[test]
fn rows_are_the_arrays_in_the_order_of_the_method() {
    let (folder, path) = written();
    let out = folder.path().join("out");
    let written = exported(&path, &out, &[]);
    let dump = Dump::open(&path).unwrap();
    let place = |array| Place::Queue(QUEUE, array);
    let rays = dump.array::<Ray>(&place(QueueArray::Rays)).unwrap();
    let paths = dump.array::<u32>(&place(QueueArray::PathIds)).unwrap();
    let hits = dump.array::<Hit>(&place(QueueArray::Hits)).unwrap();
    let work = dump.array::<Work>(&place(QueueArray::Work)).unwrap();
    let materials = dump.array::<u32>(&Place::Scene(SceneArray::Materials)).unwrap();
    let of_method = |array| Place::Method(QUEUE, "two-point".to_owned(), array);
    let keys = dump.array::<u64>(&of_method(MethodArray::Keys)).unwrap();
    let permutation = dump.array::<u32>(&of_method(MethodArray::Permutation)).unwrap();
    let rows = rows(&file_of(&out, QUEUE, "two-point"));
    assert_eq!(rows.len(), rays.len());
    for (at, row) in rows.iter().enumerate() {
        let index = permutation[at] as usize;
        let (ray, hit) = (rays[index], hits[index]);
        let or_null = |number: u32| if hit.is_hit() { Field::UInt(number) } else { Field::Null };
        let material = materials.get(hit.triangle as usize).copied().unwrap_or_default();
        for (name, expected) in [
            ("recording", Field::Str("sample.raydump".to_owned())),
            ("pass", Field::UInt(1)),
            ("place", Field::UInt(at as u32)),
            ("group", Field::UInt(at as u32 / 64)),
            ("ray", Field::UInt(index as u32)),
            ("path", Field::UInt(paths[index])),
            ("key", Field::ULong(keys[index])),
            ("origin_x", Field::Float(ray.origin[0])),
            ("origin_y", Field::Float(ray.origin[1])),
            ("origin_z", Field::Float(ray.origin[2])),
            ("direction_x", Field::Float(ray.direction[0])),
            ("direction_y", Field::Float(ray.direction[1])),
            ("direction_z", Field::Float(ray.direction[2])),
            ("t", if hit.is_hit() { Field::Float(hit.t) } else { Field::Null }),
            ("triangle", or_null(hit.triangle)),
            ("material", or_null(material)),
            ("light", Field::Null),
            ("nodes", Field::UInt(work[index].nodes)),
            ("triangles_tested", Field::UInt(work[index].triangles)),
        ] {
            assert_eq!(row[name], expected, "{name} at place {at}");
        }
    }
    // A method that estimates nothing, and one whose estimate is the truth.
    assert!(self::rows(&file_of(&out, QUEUE, "aila")).iter().all(|row| row["estimate"] == Field::Null));
    let number = |field: &Field| if let Field::Float(number) = field { *number } else { f32::NAN };
    for row in self::rows(&file_of(&out, QUEUE, "two-point-real")) {
        assert!((number(&row["estimate"]) - number(&row["length"])).abs() < 1e-4, "{row:?}");
    }
    let unsorted = self::rows(&file_of(&out, QUEUE, "unsorted"));
    assert!(unsorted.iter().all(|row| row["key"] == Field::Null && row["place"] == row["ray"]));
    let shadow = self::rows(&file_of(&out, QueueId { kind: Kind::Shadow, ..QUEUE }, "aila"));
    assert!(shadow.iter().all(|row| row["light"] != Field::Null && row["triangle"] == Field::Null));
    let files = ray_files(&out.join("rays"));
    let sum: i64 = files.iter().map(|path| reader(path).metadata().file_metadata().num_rows()).sum();
    assert_eq!(written["rays"], sum);
    assert_eq!(written["ray_files"], files.len());
    assert_eq!(written["left_out"], serde_json::json!([]));
    assert!(files.iter().any(|path| path.to_str().unwrap().ends_with("pass-000.parquet")), "{files:?}");
}

#[test]
fn every_sample_and_every_order_is_a_row() {
    let (folder, path) = written();
    let out = folder.path().join("out");
    exported(&path, &out, &["--kind", "shadow", "--method", "aila"]);
    assert!(ray_files(&out).iter().all(|path| !path.to_str().unwrap().contains("kind=closest")));
    let dump = Dump::open(&path).unwrap();
    let samples: Vec<u64> =
        dump.manifest().timings.iter().flat_map(|timing| timing.samples_ns.clone()).collect();
    let timings = rows(&out.join("timings.parquet"));
    let ns = |row: &BTreeMap<String, Field>| match row["ns"] {
        Field::ULong(ns) => ns,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(timings.iter().map(ns).collect::<Vec<_>>(), samples);
    let disturbed: Vec<_> = timings.iter().filter(|row| row["disturbed"] == Field::Bool(true)).collect();
    let recorded: usize = dump.manifest().disturbed.iter().map(|disturbed| disturbed.samples.len()).sum();
    assert_eq!(disturbed.len(), recorded);
    assert!(
        disturbed
            .iter()
            .all(|row| row["round"] == Field::UInt(1) && row["method"].to_string().contains("unsorted"))
    );
    let summaries = rows(&out.join("summaries.parquet"));
    let orders: usize = dump.manifest().queues.iter().map(|queue| queue.methods.len()).sum();
    let frames = summaries.iter().filter(|row| row["bounce"] == Field::Null).count();
    assert!(frames > 0 && summaries.len() == orders + frames, "{frames} of {}", summaries.len());
}

#[test]
fn summaries_are_the_same_whatever_rays_are_written() {
    let (folder, path) = written();
    let summaries = |name: &str, arguments: &[&str]| {
        let out = folder.path().join(name);
        exported(&path, &out, arguments);
        rows(&out.join("summaries.parquet"))
    };
    for width in ["32", "128"] {
        let all = summaries(&format!("all-{width}"), &["--group-width", width]);
        let known = ["capsule_area", "direction_spread", "lane_utilisation"];
        assert!(all.iter().any(|row| known.iter().all(|&name| row[name] != Field::Null)), "{all:?}");
        let one = ["--group-width", width, "--bounce", "0", "--method", "unsorted"];
        assert_eq!(summaries(&format!("one-{width}"), &one), all);
    }
}

#[test]
fn files_have_units_and_row_groups_of_whole_groups() {
    let (folder, path) = written();
    let out = folder.path().join("out");
    exported(&path, &out, &[]);
    for (file, unit, expected) in [
        (file_of(&out, QUEUE, "aila"), "origin_x.unit", "world units"),
        (file_of(&out, QUEUE, "aila"), "length.unit", "unit lengths: the scene's largest side is 1"),
        (out.join("timings.parquet"), "ns.unit", "nanoseconds"),
        (out.join("summaries.parquet"), "capsule_area.unit", "unit lengths squared"),
    ] {
        let reader = reader(&file);
        let metadata = reader.metadata().file_metadata();
        let known = metadata.key_value_metadata().unwrap();
        let value =
            |key: &str| known.iter().find(|known| known.key == key).and_then(|known| known.value.clone());
        assert_eq!(value(unit).as_deref(), Some(expected), "{}", file.display());
        for column in metadata.schema_descr().columns() {
            assert!(value(&format!("{}.about", column.name())).is_some(), "{}", column.name());
        }
    }
}

#[test]
fn exports_are_replaced_only_with_force_and_nothing_else_is() {
    let (folder, path) = written();
    let out = folder.path().join("a/b/out");
    exported(&path, &out, &["--method", "aila"]);
    let files = ray_files(&out).len();
    is_refused(&export(&path, &out, &[]), "holds an export; replace it with --force");
    assert_eq!(ray_files(&out).len(), files);
    exported(&path, &out, &["--force", "--method", "two-point", "--bounce", "0"]);
    assert!(
        ray_files(&out.join("rays")).iter().all(|path| path.to_str().unwrap().contains("method=two-point"))
    );
    is_refused(&export(&path, &out, &["--force", "--bounce", "9"]), "nothing to export");
    assert!(ray_files(&out).len() > 2, "what was there still is");
    fs::write(out.join("rays/notes.txt"), "mine").unwrap();
    is_refused(&export(&path, &out, &["--force"]), "notes.txt was written by no export");
    fs::remove_file(out.join("rays/notes.txt")).unwrap();
    fs::create_dir(out.join("rays/scene=x")).unwrap();
    std::os::unix::fs::symlink("/", out.join("rays/scene=x/scene=y")).unwrap();
    is_refused(&export(&path, &out, &["--force"]), "scene=y was written by no export");
    let left = fs::read_dir(out.parent().unwrap()).unwrap().count();
    assert_eq!(left, 1, "nothing is left beside it");
}

#[test]
fn nothing_is_written_into_a_recording() {
    let (folder, path) = written();
    let before = fs::read_dir(&path).unwrap().count();
    for out in [path.clone(), path.join("out"), path.join("pass-001/a/b")] {
        is_refused(&export(&path, &out, &["--force"]), "lies in the recording");
    }
    assert_eq!(fs::read_dir(&path).unwrap().count(), before);
    assert!(!path.join("pass-001/a").exists());
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    is_refused(&export(&path, &file, &[]), "is no folder");
    is_refused(&export(&path, &folder.path().join("x"), &["--filter", "hit"]), "a query does");
}

#[test]
fn scenes_of_any_name_have_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = sample::header();
    header.scene.name = "a=b/c d%".to_owned();
    let mut writer = DumpWriter::create(&folder.path().join("odd"), header, false).unwrap();
    let end = sample::write_all(&mut writer).unwrap();
    let path = writer.finish(end).unwrap();
    let out = folder.path().join("out");
    exported(&path, &out, &["--method", "aila", "--bounce", "0"]);
    assert!(out.join("rays/scene=a%3Db%2Fc%20d%25").is_dir());
    assert_eq!(rows(&out.join("timings.parquet"))[0]["scene"], Field::Str("a=b/c d%".to_owned()));
}

#[test]
fn a_study_is_one_dataset_and_what_cannot_be_read_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let job = |name: &str, recordings: &[&str]| {
        let job = study.join("jobs").join(name);
        fs::create_dir_all(&job).unwrap();
        let record = JobRecord {
            rayscope_job: JOB_VERSION,
            content_hash: String::new(),
            scene: "sample".into(),
            camera: "front".into(),
            seed: 1,
            commands: Vec::new(),
            recordings: recordings.iter().map(|&name| name.to_owned()).collect(),
            host: "here".into(),
            seconds: 1.0,
            bytes: 1,
            failure: None,
        };
        record.write(&job).unwrap();
        job
    };
    fs::create_dir_all(study.join("jobs")).unwrap();
    fs::write(study.join("study.toml"), "").unwrap();
    let out = folder.path().join("out");
    is_refused(&export(&study, &out, &[]), "none is finished");
    for name in ["one", "two"] {
        sample::write(&job(name, &["sample.raydump"]));
    }
    job("three", &["gone.raydump"]);
    let written =
        exported(&study, &out, &["--bounce", "1", "--kind", "closest", "--method", "aila", "--pass", "1"]);
    assert_eq!((&written["recordings"], &written["ray_files"]), (&2.into(), &2.into()));
    assert!(written["left_out"][0].as_str().unwrap().contains("gone.raydump"), "{written}");
    let names: Vec<Field> =
        ray_files(&out.join("rays")).iter().map(|path| rows(path)[0]["recording"].clone()).collect();
    let named = |job: &str| Field::Str(format!("{job}/sample.raydump"));
    assert_eq!(names, [named("one"), named("two")]);
}
