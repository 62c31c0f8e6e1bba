//! Holds that every WGSL file is part of a module that naga accepts, and that the structs which the CPU
//! and WGSL share have one layout.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::{BTreeMap, BTreeSet};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Expression, Literal, Module, TypeInner};
use recorder::backends::gpu::kernels::all_shader_sources;
use recorder::stages::shared_structs;
use recorder::stages::wgsl::wgsl_f32;
use tests::sources::{Source, files};

/// Every composed module with its label, parsed.
fn modules() -> Vec<(String, String, Module)> {
    let sources = all_shader_sources();
    assert!(!sources.is_empty(), "the recorder names no shader, expected at least one");
    let parse = |(label, text): (String, String)| {
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{label}: {}", error.emit_to_string(&text)));
        (label, text, module)
    };
    sources.into_iter().map(parse).collect()
}

#[test]
fn every_module_is_valid() {
    let mut labels = BTreeSet::new();
    for (label, text, module) in modules() {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        if let Err(error) = validator.validate(&module) {
            panic!("{label}: {}", error.emit_to_string(&text));
        }
        assert!(!module.entry_points.is_empty(), "{label} has no entry point");
        assert!(labels.insert(label.clone()), "two modules are called {label}");
    }
}

/// Whether the file's text stands in one of the composed modules. Lines that carry a name to be filled
/// in are left out of the comparison, since they look different there.
fn is_part_of(file: &Source, modules: &[(String, String, Module)]) -> bool {
    let lines: Vec<&str> = file.text.lines().map(str::trim).filter(|line| is_plain(line)).collect();
    assert!(!lines.is_empty(), "{} has no line to recognise it by", file.path);
    modules.iter().any(|(_, text, _)| {
        let present: BTreeSet<&str> = text.lines().map(str::trim).collect();
        lines.iter().all(|line| present.contains(line))
    })
}

/// A line of code long enough to be recognised, without a placeholder.
fn is_plain(line: &str) -> bool {
    line.len() > 12 && !line.starts_with("//") && !line.contains("{{") && !line.contains('$')
}

#[test]
fn every_wgsl_file_is_part_of_a_module() {
    let modules = modules();
    for file in files("recorder/src", "wgsl") {
        assert!(is_part_of(&file, &modules), "{} is in no module of all_shader_sources()", file.path);
    }
}

#[test]
fn shared_structs_have_one_layout() {
    let described: BTreeMap<&str, _> =
        shared_structs().into_iter().map(|shared| (shared.name, shared)).collect();
    assert!(!described.is_empty(), "the recorder names no shared struct, expected at least one");
    let mut seen = BTreeSet::new();
    for (label, _, module) in modules() {
        for (_, found) in module.types.iter() {
            let (Some(name), TypeInner::Struct { members, span }) = (&found.name, &found.inner) else {
                continue;
            };
            let Some(shared) = described.get(name.as_str()) else { continue };
            seen.insert(shared.name);
            let offsets: Vec<(&str, usize)> = members
                .iter()
                .map(|member| (member.name.as_deref().unwrap_or_default(), member.offset as usize))
                .collect();
            assert_eq!(offsets, shared.fields, "offsets of {name}: in {label} (left), on the CPU (right)");
            assert_eq!(*span as usize, shared.size, "size of {name}: in {label} (left), on the CPU (right)");
        }
    }
    let missing: Vec<&&str> = described.keys().filter(|name| !seen.contains(**name)).collect();
    assert!(missing.is_empty(), "no module has the shared structs {missing:?}");
}

/// The bits of a float that went to WGSL and came back.
fn through_wgsl(value: f32) -> u32 {
    let text = format!("const value = {};", wgsl_f32(value));
    let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let (_, constant) = module.constants.iter().next().unwrap();
    match module.global_expressions[constant.init] {
        Expression::Literal(Literal::F32(read)) => read.to_bits(),
        ref other => panic!("{text} is {other:?}"),
    }
}

#[test]
fn every_finite_float_goes_to_wgsl_and_back() {
    let odd = [0.0, -0.0, 1e-45, -1.1754942e-38, f32::MIN_POSITIVE, f32::MAX, f32::MIN, 16_777_216.0];
    let any = (0..20_000u32).map(|number| f32::from_bits(number.wrapping_mul(0x9e37_79b9)));
    for value in odd.into_iter().chain(any).filter(|value| value.is_finite()) {
        assert_eq!(through_wgsl(value), value.to_bits(), "{value:e}");
    }
}

#[test]
fn what_wgsl_cannot_write_is_never_written() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(std::panic::catch_unwind(|| wgsl_f32(value)).is_err(), "{value}");
    }
}
