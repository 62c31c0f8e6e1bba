//! The sample's recording cut to a few rays, one method and a table of few cells: right in
//! every respect, and small enough to be edited and read a thousand times a second.

use std::path::{Path, PathBuf};

use formats::key::{Encoder, Facts, Method};
use formats::length_table::{LengthTable, TABLE_BITS_MIN};
use formats::manifest::{
    End, Header, MethodRecord, Mismatches, Outcome, Place, QueueArray, QueueId, QueueRecord, Record,
    SceneArray, Stage,
};
use formats::npy::Element;
use formats::ray::{Hit, Kind, Ray};
use formats::reader::Dump;
use formats::traced::Traced;
use formats::unit_space::UnitSpace;
use formats::writer::DumpWriter;

use super::dump::sample;

/// Rays of each queue.
const RAYS: usize = 6;

/// Writes a recording of one queue of this kind into a folder, beside the whole sample.
pub(super) fn write(folder: &Path, kind: Kind) -> PathBuf {
    let whole = Dump::open(&sample::write(folder)).unwrap();
    let mut header = sample::header();
    // Keys of 32 bits by the length table, and keys of 64 bits by lights.
    let name = match kind {
        Kind::Closest => "two-point-adaptive",
        Kind::Shadow => "light-octahedron",
    };
    header.options.table_bits = TABLE_BITS_MIN;
    header.options.methods = vec!["unsorted".to_owned(), name.to_owned()];
    header
        .options
        .keep
        .retain(|word| !matches!(word.as_str(), "image" | "caches" | "work" | "hierarchy" | "throughput"));
    header.options.keep_passes = "measured".to_owned();
    let mut writer = DumpWriter::create(&folder.join("original"), header.clone(), false).unwrap();
    for array in [SceneArray::Positions, SceneArray::Triangles, SceneArray::Materials, SceneArray::Colours] {
        let record = whole.record(&Place::Scene(array)).unwrap();
        let mut file = writer.array(&record.place, record.dtype, &record.shape).unwrap();
        file.write(&whole.bytes(record).unwrap()).unwrap();
        file.finish().unwrap();
    }
    let method = whole.manifest().methods.iter().find(|method| method.name == name).unwrap();
    writer.record(&Record::Method(method.clone())).unwrap();
    write_queue(&mut writer, &whole, &header, kind, method);
    writer.finish(End { outcome: Outcome::Complete, image: None, wall_ns: 1 }).unwrap()
}

fn write_queue(writer: &mut DumpWriter, whole: &Dump, header: &Header, kind: Kind, method: &MethodRecord) {
    let id = QueueId { pass: 1, bounce: 1, kind };
    let place = |array| Place::Queue(id, array);
    let rays = cut::<Ray>(writer, whole, &place(QueueArray::Rays));
    cut::<u32>(writer, whole, &place(QueueArray::PathIds));
    let lights = match kind {
        Kind::Closest => {
            cut::<Hit>(writer, whole, &place(QueueArray::Hits));
            vec![0; RAYS]
        }
        Kind::Shadow => {
            cut::<f32>(writer, whole, &place(QueueArray::Distances));
            cut::<u32>(writer, whole, &place(QueueArray::Lights))
        }
    };
    let (traced, cells) = (Traced::open(whole, id).unwrap(), header.cell_encoder().unwrap());
    let table = LengthTable::new(header.options.table_bits);
    let cell = |ray: &Ray| cells.encode(ray, Facts::default()) as u32;
    let add_all = || rays.iter().enumerate().for_each(|(i, ray)| table.add(cell(ray), traced.length(i)));
    // As if the same rays had been traced before.
    add_all();
    let write_table = |writer: &mut DumpWriter, array| {
        let touched = table.touched();
        writer.whole_array(&place(array), &[touched.len() as u64], &touched).unwrap();
    };
    write_table(writer, QueueArray::Lengths);
    let unit = UnitSpace::from_bounds(header.scene.bounds_min, header.scene.bounds_max);
    let layout = Method::builtin(&method.name).unwrap().layout.expand(header.extent()).unwrap();
    let encoder = Encoder::new(&layout, method.key_bits, unit, &header.lights);
    let keys: Vec<u64> = rays
        .iter()
        .zip(&lights)
        .map(|(ray, &light)| encoder.encode(ray, Facts { length: table.mean(cell(ray)), light, path: 0 }))
        .collect();
    sample::write_order(writer, id, &method.name, method.key_bits, &keys).unwrap();
    add_all();
    write_table(writer, QueueArray::FinalLengths);
    let methods = vec!["unsorted".to_owned(), method.name.clone()];
    for method in &methods {
        let samples_ns = vec![9; header.options.repeats as usize];
        writer.record(&sample::timing(id, method, Stage::Trace, samples_ns)).unwrap();
    }
    let mismatches = methods.iter().map(|method| Mismatches { method: method.clone(), rays: 0 }).collect();
    writer.record(&Record::Queue(QueueRecord { id, rays: RAYS as u64, methods, mismatches })).unwrap();
}

/// Copies the first entries of an array; returns them.
fn cut<T: Element>(writer: &mut DumpWriter, whole: &Dump, place: &Place) -> Vec<T> {
    let entries = whole.array::<T>(place).unwrap()[..RAYS].to_vec();
    writer.whole_array(place, &[RAYS as u64], &entries).unwrap();
    entries
}
