//! Keys, permutations and length tables of recordings from both backends, against their definition.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use formats::key::LightSite;
use formats::length_table::LengthCell;
use formats::manifest::{MethodArray, Place, QueueArray, QueueId, QueueRecord};
use formats::ray::{Hit, Kind, Ray};
use formats::reader::Dump;
use serde_json::json;
use tempfile::tempdir;
use tests::keys::{Facts, Space, applies, layout, mean_length, summed};
use tests::programs::{Program, finish};
use tests::recordings::record;
use tests::sources::root;

const TABLE_BITS: usize = 20;

/// One queue of a recording, read whole.
struct Queue {
    id: QueueId,
    rays: Vec<Ray>,
    /// Traced lengths, unit lengths.
    traced: Vec<f32>,
    lights: Vec<(u32, LightSite)>,
    table: BTreeMap<u32, LengthCell>,
}

/// Cells by address.
fn cells(dump: &Dump, id: QueueId, array: QueueArray) -> BTreeMap<u32, LengthCell> {
    let cells = dump.array::<LengthCell>(&Place::Queue(id, array)).unwrap();
    assert!(cells.windows(2).all(|pair| pair[0].cell < pair[1].cell), "cells of {id} do not ascend");
    cells.iter().map(|cell| (cell.cell, *cell)).collect()
}

fn read(dump: &Dump, space: &Space, queue: &QueueRecord) -> Queue {
    let id = queue.id;
    let place = |array| Place::Queue(id, array);
    let rays = dump.array::<Ray>(&place(QueueArray::Rays)).unwrap().to_vec();
    assert_eq!(rays.len() as u64, queue.rays, "rays of {id}");
    let (traced, lights) = match id.kind {
        Kind::Closest => {
            let hits = dump.array::<Hit>(&place(QueueArray::Hits)).unwrap();
            (
                rays.iter().zip(hits.iter()).map(|(ray, hit)| space.closest_length(ray, hit)).collect(),
                Vec::new(),
            )
        }
        Kind::Shadow => {
            let distances = dump.array::<f32>(&place(QueueArray::Distances)).unwrap();
            let sites = &dump.manifest().header.lights;
            let lights = dump.array::<u32>(&place(QueueArray::Lights)).unwrap();
            (
                rays.iter()
                    .zip(distances.iter())
                    .map(|(ray, distance)| space.shadow_length(ray, *distance))
                    .collect(),
                lights.iter().map(|light| (*light, sites[*light as usize])).collect(),
            )
        }
    };
    Queue { id, rays, traced, lights, table: cells(dump, id, QueueArray::Lengths) }
}

impl Queue {
    fn facts<'a>(&'a self, space: &'a Space, ray: usize, length: f32) -> Facts<'a> {
        Facts { space, ray: &self.rays[ray], length, light: self.lights.get(ray).copied() }
    }

    /// The length that a method takes a ray to have.
    fn length(&self, space: &Space, method: &str, ray: usize) -> f32 {
        match method {
            "two-point-adaptive" => {
                let cell = self.table.get(&self.facts(space, ray, 0.0).table_cell(TABLE_BITS));
                cell.map_or(0.25, |cell| mean_length(cell.sum, cell.count))
            }
            "two-point-real" => self.traced[ray],
            _ => 0.25,
        }
    }

    /// The table after this queue's lengths were added.
    fn accumulated(&self, space: &Space) -> BTreeMap<u32, LengthCell> {
        let mut table = self.table.clone();
        for ray in 0..self.rays.len() {
            let address = self.facts(space, ray, 0.0).table_cell(TABLE_BITS);
            // A cell begins with one dummy ray of length 0.25.
            let cell = table.entry(address).or_insert(LengthCell { cell: address, count: 1, sum: 1 << 22 });
            cell.count += 1;
            cell.sum += summed(self.traced[ray]);
        }
        table
    }
}

fn stored_keys(dump: &Dump, place: &Place, key_bits: u32) -> Vec<u64> {
    if key_bits <= 32 {
        dump.array::<u32>(place).unwrap().iter().map(|key| u64::from(*key)).collect()
    } else {
        dump.array::<u64>(place).unwrap().to_vec()
    }
}

fn check_methods(dump: &Dump, space: &Space, queue: &Queue, names: &[String], key_bits: u32) -> usize {
    let lights = dump.manifest().header.lights.len();
    let mut checked = 0;
    // The orders of `auto` are those of other methods: `replay` and `verify` have them.
    for name in names.iter().filter(|name| !["unsorted", "auto"].contains(&name.as_str())) {
        assert!(applies(name, queue.id.kind), "{name} makes no sense for {}", queue.id);
        let bits = layout(name, lights);
        let place = |array| Place::Method(queue.id, name.clone(), array);
        let keys = stored_keys(dump, &place(MethodArray::Keys), key_bits);
        assert_eq!(keys.len(), queue.rays.len(), "keys of {name} in {}", queue.id);
        for (ray, &key) in keys.iter().enumerate() {
            let facts = queue.facts(space, ray, queue.length(space, name, ray));
            if let Err(wrong) = facts.check(&bits, key_bits as usize, key) {
                panic!("{name}, ray {ray} of {}: {wrong}", queue.id);
            }
        }
        let mut expected: Vec<u32> = (0..keys.len() as u32).collect();
        expected.sort_by_key(|&ray| keys[ray as usize]);
        let order = dump.array::<u32>(&place(MethodArray::Permutation)).unwrap();
        assert_eq!(order.to_vec(), expected, "permutation of {name} in {}", queue.id);
        checked += 1;
    }
    checked
}

/// Records and compares every key, permutation and table of it.
fn check(scene: &str, options: &str, key_bits: u32) {
    let folder = tempdir().unwrap();
    record(folder.path(), "keys", scene, &format!("--repeats 1 --key-bits {key_bits} {options}"));
    Program::Inspector.run(folder.path(), "verify keys.raydump").succeeded();
    let dump = Dump::open(&folder.path().join("keys.raydump")).unwrap();
    let manifest = dump.manifest();
    let space = Space::new(manifest.header.scene.bounds_min, manifest.header.scene.bounds_max);
    let mut checked = 0;
    let mut expected_tables = BTreeMap::new();
    for record in &manifest.queues {
        let queue = read(&dump, &space, record);
        checked += check_methods(&dump, &space, &queue, &record.methods, key_bits);
        if let Some(expected) = expected_tables.insert(queue.id.kind, queue.accumulated(&space)) {
            assert!(
                queue.table == expected,
                "the table that {} reads is not what the queues before it left",
                queue.id
            );
        }
    }
    for (kind, expected) in expected_tables {
        let last = manifest.queues.iter().rfind(|queue| queue.id.kind == kind).unwrap().id;
        assert!(cells(&dump, last, QueueArray::FinalLengths) == expected, "the last table of {kind} rays");
    }
    // Three bounces of both kinds with eight methods each, and two for shadow rays alone.
    assert!(checked >= 3 * (8 + 10), "only {checked} orders were checked");
}

/// Rows of others, which `all` does not stand for, against NumPy.
fn check_others(scene: &str, options: &str, key_bits: u32) {
    let folder = tempdir().unwrap();
    let methods = "paraboloid,hilbert-origin,hilbert-two-point,two-point-xor,grid-spherical,tiled-octahedron";
    // The picture of this recording is smaller than a tile of that row.
    let small_tiles = "small-tiles=tile(7x10)(u(v))*4";
    record(
        folder.path(),
        "others",
        scene,
        &format!("--repeats 1 --key-bits {key_bits} --methods {methods} --method {small_tiles} {options}"),
    );
    Program::Inspector.run(folder.path(), "verify others.raydump").succeeded();
    let dump = Dump::open(&folder.path().join("others.raydump")).unwrap();
    let header = &dump.manifest().header;
    let (min, max) = (header.scene.bounds_min, header.scene.bounds_max);
    let [width, height] = header.extent().picture;
    let facts = json!({
        "min": min, "max": max, "length": 0.25, "key_bits": key_bits, "width": width, "height": height
    });
    let file = folder.path().join("facts.json");
    fs::write(&file, facts.to_string()).unwrap();
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.arg(root().join("tests/check_keys.py")).arg(dump.root()).arg(file);
    let compared = finish(&mut command).succeeded().json();
    for method in methods.split(',').chain(["small-tiles"]) {
        assert!(compared[method].as_u64().unwrap() > 5000, "{method}: {compared}");
    }
}

#[test]
fn rows_of_others_on_threads() {
    check_others("builtin:atrium?triangles=4000", "--backend cpu", 32);
    check_others("builtin:terrain?triangles=4000", "--backend cpu", 64);
}

#[test]
fn rows_of_others_on_the_gpu() {
    check_others("builtin:atrium?triangles=4000", "--backend gpu", 32);
    check_others("builtin:terrain?triangles=4000", "--backend gpu", 64);
}

#[test]
fn of_16_bits_on_threads() {
    check("builtin:atrium?triangles=4000", "--backend cpu", 16);
}

#[test]
fn of_32_bits_on_threads() {
    check("builtin:atrium?triangles=4000", "--backend cpu", 32);
}

#[test]
fn of_64_bits_on_threads() {
    check("builtin:terrain?triangles=4000", "--backend cpu", 64);
}

#[test]
fn of_16_bits_on_the_gpu() {
    check("builtin:atrium?triangles=4000", "--backend gpu", 16);
}

#[test]
fn of_32_bits_on_the_gpu() {
    check("builtin:atrium?triangles=4000", "--backend gpu", 32);
}

#[test]
fn of_64_bits_on_the_gpu() {
    check("builtin:terrain?triangles=4000", "--backend gpu --trace bvh2", 64);
}
