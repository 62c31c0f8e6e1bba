//! FORMAT.md says what is true: its Python reader reads a dump, its table lists the arrays as written. So does the table
//! of layouts in docs/keys.md.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod sample;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use formats::key::method::BUILTIN;
use formats::manifest::{ArrayRecord, Record};
use formats::reader::Dump;

const READER_LINES_MAX: usize = 70;

fn format_md() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../FORMAT.md")).unwrap()
}

/// The Python reader, exactly as it stands in FORMAT.md.
fn python_reader() -> String {
    let text = format_md();
    let (_, after) = text.split_once("```python\n").unwrap();
    after.split_once("```").unwrap().0.to_owned()
}

/// Runs Python on a script in `folder`; NumPy is a test dependency.
fn python(folder: &Path, arguments: &[&str]) -> String {
    let program = std::env::var_os("PYTHON").unwrap_or("python3".into());
    let output = Command::new(&program).current_dir(folder).args(arguments).output();
    let output =
        output.unwrap_or_else(|error| panic!("{}: {error}; install Python 3 and NumPy", program.display()));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "the Python reader failed (it needs NumPy):\n{errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// The sample dump with the reader beside it.
fn sample_and_reader() -> (tempfile::TempDir, PathBuf) {
    let (folder, dump) = sample::in_memory();
    fs::write(folder.path().join("reader.py"), python_reader()).unwrap();
    (folder, dump)
}

/// A shape as Python writes a tuple.
fn tuple(shape: &[u64]) -> String {
    match shape {
        [length] => format!("({length},)"),
        _ => format!("({})", shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}

#[test]
fn the_python_reader_opens_every_array_with_its_documented_type() {
    assert!(python_reader().lines().count() < READER_LINES_MAX);
    let (folder, path) = sample_and_reader();
    let found = python(folder.path(), &["reader.py", "sample.raydump"]);
    let line = |array: &ArrayRecord| format!("{}\t{}\t{}\n", array.place, array.dtype, tuple(&array.shape));
    let expected: String = Dump::open(&path).unwrap().manifest().arrays.iter().map(line).collect();
    assert_eq!(found, expected);
}

/// Every record and every byte of every array arrive in Python.
#[test]
fn the_python_reader_reads_what_was_written() {
    let script = "
import numpy, reader
records, arrays = reader.open_recording('sample.raydump')
for kind, fields in records:
    what = '' if kind == 'timing' else fields.get('method', '')
    print(kind, fields.get('path', fields.get('name', fields.get('rays', what))))
header, end = records[0][1], records[-1][1]
print(header['options']['table_layout'], header['options']['russian_roulette'], header['scene']['vertices'])
print([kind for kind, _ in header['lights']], header['notices'][-1], header['limits'][0]['value'])
caches = [fields for kind, fields in records if kind == 'cache']
print(caches[0]['method'], caches[0]['accesses'], caches[0]['l2_hits'], header['source'])
print(end['outcome'], end['image']['sha256'], end['wall_ns'])
timing = next(fields for kind, fields in records if kind == 'timing')
print(timing['pass'], timing['bounce'], timing['kind'], timing['method'], timing['stage'], timing['samples_ns'])
for path, array in arrays.items():
    assert isinstance(array, numpy.memmap) and array.offset % 64 == 0, path
    data = numpy.frombuffer(array.tobytes(), numpy.uint8).astype(numpy.uint64)
    print(path, (data * (numpy.arange(data.size, dtype=numpy.uint64) % 251 + 1)).sum())
";
    let (folder, path) = sample_and_reader();
    fs::write(folder.path().join("script.py"), script).unwrap();
    let found = python(folder.path(), &["script.py"]);

    let dump = Dump::open(&path).unwrap();
    let manifest = dump.manifest();
    let mut expected: Vec<String> = sample::records(&path).iter().map(kind_and_name).collect();
    let header = &manifest.header;
    expected.push(format!("{} False {}", header.options.table_layout, header.scene.vertices));
    expected.push(format!("['placed', 'directional', 'environment'] {} 134217728", header.notices[0]));
    let cache = &manifest.caches[0];
    expected.push(format!("{} {} {} ('traced', {{}})", cache.method, cache.accesses, cache.l2_hits));
    let image = manifest.end.unwrap().image.unwrap();
    expected.push(format!("complete {} 1500000000", formats::summary::hexadecimal(&image.sha256)));
    expected.push("1 0 closest unsorted trace [10020, 9990, 10000, 10005, 9995, 10010, 9980]".to_owned());
    for array in &manifest.arrays {
        let data = dump.bytes(array).unwrap();
        let sum: u64 = data.iter().zip(0u64..).map(|(&byte, at)| u64::from(byte) * (at % 251 + 1)).sum();
        expected.push(format!("{} {sum}", array.place));
    }
    let found: Vec<&str> = found.lines().map(str::trim_end).collect();
    assert_eq!(found, expected);
}

fn kind_and_name(record: &Record) -> String {
    match record {
        Record::Header(_) => "header".to_owned(),
        Record::Method(method) => format!("method {}", method.name),
        Record::Array(array) => format!("array {}", array.place),
        Record::Queue(queue) => format!("queue {}", queue.rays),
        Record::Timing(_) => "timing".to_owned(),
        Record::End(_) => "end".to_owned(),
        Record::Cache(cache) => format!("cache {}", cache.rays),
        Record::Disturbed(disturbed) => format!("disturbed {}", disturbed.method),
        Record::Way(way) => format!("way {}", way.method),
        Record::Calibration(calibration) => format!("calibration {}", calibration.rays),
        Record::Decision(_) => "decision".to_owned(),
    }
}

/// The rows of the table of arrays: path pattern, element types.
fn documented_arrays() -> Vec<(String, String)> {
    let text = format_md();
    let (_, section) = text.split_once("## The arrays").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let rows = section.lines().filter_map(|line| {
        let (path, rest) = line.strip_prefix("| `")?.split_once("` | ")?;
        let (dtypes, _) = rest.split_once(" | (")?;
        Some((path.to_owned(), dtypes.replace("\\|", "|")))
    });
    rows.collect()
}

/// Whether a path is one of those that a pattern of FORMAT.md stands for.
fn fits(path: &str, pattern: &str) -> bool {
    let parts: Vec<(&str, &str)> = path.split('/').zip(pattern.split('/')).collect();
    path.split('/').count() == pattern.split('/').count()
        && parts.iter().all(|(part, pattern)| match *pattern {
            "pass-PPP" => part.starts_with("pass-"),
            "bounce-BB" => part.starts_with("bounce-"),
            "KIND" => matches!(*part, "closest" | "shadow"),
            "METHOD" => true,
            "mask-NNN.npy" => part.starts_with("mask-"),
            _ => part == pattern,
        })
}

#[test]
fn the_table_lists_every_array_with_its_type() {
    let folder = tempfile::tempdir().unwrap();
    let dump = Dump::open(&sample::write(folder.path())).unwrap();
    let documented = documented_arrays();
    assert_eq!(documented.len(), 22);
    let mut seen = BTreeSet::new();
    for array in &dump.manifest().arrays {
        let path = array.place.to_string();
        let row = documented.iter().find(|(pattern, _)| fits(&path, pattern));
        let (pattern, dtypes) = row.unwrap_or_else(|| panic!("{path} is not documented"));
        let dtype = format!("`{}`", array.dtype);
        assert!(
            dtypes.split(" or ").any(|documented| documented == dtype),
            "{path}: {dtypes} against {dtype}"
        );
        seen.insert(pattern.clone());
    }
    let all: BTreeSet<String> = documented.into_iter().map(|(pattern, _)| pattern).collect();
    assert_eq!(seen, all, "the sample has every documented array");
}

#[test]
fn keys_md_has_the_layouts() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/keys.md")).unwrap();
    let (_, table) = text.split_once("## Layouts\n").unwrap();
    let rows =
        table.lines().take_while(|line| !line.starts_with("## ")).filter(|line| line.starts_with("| `"));
    let written: Vec<[&str; 2]> = rows
        .map(|row| {
            let mut words = row.split('`').skip(1).step_by(2);
            std::array::from_fn(|_| words.next().unwrap())
        })
        .collect();
    let expected: Vec<[&str; 2]> = BUILTIN.iter().map(|&(name, layout, _)| [name, layout]).collect();
    assert_eq!(written, expected);
}
