//! WGSL from layouts: the key kernel of a method, and the cell function of the length table.

use std::fmt::Write;

use formats::key::coordinates::INVERSE_SQRT_3;
use formats::key::layout::{Coordinate, Share};
use formats::key::{COORDINATE_BITS, Layout, LightSite, Termination, Tiles, angle, termination};
use formats::length_table::{LENGTH_FRACTION_BITS, LONGEST_SUMMED};
use formats::unit_space::UnitSpace;

use crate::stages::wgsl::{wgsl_f32, wgsl_f32_array};

/// The constants of `kernel.wgsl` and `lengths.wgsl`, written once in `formats`.
pub fn constants(unit: &UnitSpace) -> String {
    let mut text = String::new();
    let one = (1u32 << COORDINATE_BITS) as f32;
    for (name, value) in [
        ("QUANTISE_SCALE", one),
        ("QUANTISE_LAST", one - 1.0),
        ("PI", std::f32::consts::PI),
        ("FRAC_PI_2", std::f32::consts::FRAC_PI_2),
        ("FRAC_1_PI", std::f32::consts::FRAC_1_PI),
        ("LONGEST", termination::LONGEST),
        ("STEP_ONE", (1u32 << termination::STEP_BITS) as f32),
        ("INVERSE_SQRT_3", INVERSE_SQRT_3),
        ("LONGEST_SUMMED", LONGEST_SUMMED),
        ("FIXED_POINT_ONE", (1u32 << LENGTH_FRACTION_BITS) as f32),
        ("MEAN_SCALE", 2.0 / (1u32 << LENGTH_FRACTION_BITS) as f32),
    ] {
        let _ = writeln!(text, "const {name} = {};", wgsl_f32(value));
    }
    let _ = writeln!(text, "const STEP_SHIFT = {}u;", 2 * termination::STEP_BITS - COORDINATE_BITS);
    text.push_str(&wgsl_f32_array("ARCTANGENT", &angle::ARCTANGENT));
    text.push_str(&wgsl_f32_array("ARCCOSINE", &angle::ARCCOSINE));
    let vector = |v: [f32; 3]| format!("vec3({})", v.map(wgsl_f32).join(", "));
    let _ = writeln!(text, "struct UnitSpace {{ min: vec3<f32>, scale: f32, sides: vec3<f32> }}");
    let _ = writeln!(
        text,
        "const unit = UnitSpace({}, {}, {});",
        vector(unit.min),
        wgsl_f32(unit.scale),
        vector(unit.sides)
    );
    text
}

/// `fn NAME(ray: UnitRay, facts: Facts) -> vec2<u32>`: the k-bit prefix of a layout,
/// low word first.
pub fn encode_function(name: &str, layout: &Layout, key_bits: u32, lights: &[LightSite]) -> String {
    let shares = layout.shares(key_bits);
    let axes: Vec<Coordinate> = shares.iter().flat_map(|share| share.source.axes().to_vec()).collect();
    let uses = |list: &[Coordinate]| axes.iter().any(|axis| list.contains(axis));
    let mut text = String::new();
    if uses(&[Coordinate::LightU, Coordinate::LightV, Coordinate::LightR]) {
        text.push_str(&from_light_function(lights));
    }
    let _ = writeln!(text, "fn {name}(ray: UnitRay, facts: Facts) -> vec2<u32> {{");
    if uses(&[Coordinate::EndX, Coordinate::EndY, Coordinate::EndZ]) {
        text.push_str("    let end_length = bounded_length(ray, facts.length);\n");
    }
    if uses(&[Coordinate::OctahedralU, Coordinate::OctahedralV]) {
        text.push_str("    let square = octahedral(ray.direction);\n");
    }
    if uses(&[Coordinate::ParaboloidU, Coordinate::ParaboloidV]) {
        text.push_str("    let halves = paraboloid(ray.direction);\n");
    }
    if uses(&[Coordinate::LightU, Coordinate::LightV, Coordinate::LightR]) {
        text.push_str("    let seen = from_light(facts.light, ray);\n");
    }
    if let Some(tiles) = layout.tiles().filter(|_| uses(&[Coordinate::Tile])) {
        let (Tiles { tile: [across, down], width }, in_row) = (tiles, tiles.across());
        let _ = writeln!(
            text,
            "    let tile = facts.path / {width}u / {down}u * {in_row}u + facts.path % {width}u / {across}u;"
        );
    }
    text.push_str("    var low = 0u;\n    var high = 0u;\n");
    for (number, share) in shares.iter().enumerate() {
        let name = |axis: usize| format!("c{number}_{axis}");
        for (axis, &coordinate) in share.source.axes().iter().enumerate() {
            let _ = writeln!(text, "    var {} = {};", name(axis), quantised(coordinate));
        }
        if share.positions.len() > 1 {
            to_curve(&mut text, name, share);
        }
        for (axis, positions) in share.positions.iter().enumerate() {
            spread(&mut text, &name(axis), share.width, positions);
        }
    }
    text.push_str("    return vec2(low, high);\n}\n");
    text
}

fn quantised(coordinate: Coordinate) -> &'static str {
    use Coordinate as C;
    match coordinate {
        C::OriginX => "quantise(ray.origin.x)",
        C::OriginY => "quantise(ray.origin.y)",
        C::OriginZ => "quantise(ray.origin.z)",
        C::EndX => "end_quantised(ray.origin.x, end_length, ray.direction.x)",
        C::EndY => "end_quantised(ray.origin.y, end_length, ray.direction.y)",
        C::EndZ => "end_quantised(ray.origin.z, end_length, ray.direction.z)",
        C::DirectionX => "quantise(cartesian(ray.direction.x))",
        C::DirectionY => "quantise(cartesian(ray.direction.y))",
        C::DirectionZ => "quantise(cartesian(ray.direction.z))",
        C::OctahedralU => "quantise(square.x)",
        C::OctahedralV => "quantise(square.y)",
        C::ParaboloidU => "quantise(halves.x)",
        C::ParaboloidV => "quantise(halves.y)",
        C::Azimuth => "quantise(azimuth(ray.direction.x, ray.direction.y))",
        C::Polar => "quantise(polar(ray.direction.z))",
        C::Light => "facts.light",
        C::Tile => "tile",
        C::LightU => "quantise(seen.x)",
        C::LightV => "quantise(seen.y)",
        C::LightR => "quantise(seen.z)",
    }
}

/// Turns the coordinates of a curve into the words of the place along it, as `formats::key::hilbert` does.
fn to_curve(text: &mut String, name: impl Fn(usize) -> String, share: &Share) {
    let (first, axes) = (name(0), share.positions.len());
    for axis in 0..axes {
        let _ = writeln!(text, "    {} >>= {}u;", name(axis), COORDINATE_BITS - share.width);
    }
    let _ = writeln!(text, "    for (var level = {}u; level > 0u; level--) {{", share.width - 1);
    let _ = writeln!(text, "        {first} = mirrored({first}, level);\n        var pair = vec2(0u);");
    for other in (1..axes).map(&name) {
        let _ = writeln!(text, "        pair = turned({first}, {other}, level);");
        let _ = writeln!(text, "        {first} = pair.x;\n        {other} = pair.y;");
    }
    text.push_str("    }\n");
    for axis in 1..axes {
        let _ = writeln!(text, "    {} ^= {};", name(axis), name(axis - 1));
    }
    let turns = format!("{first}_turns");
    let _ = writeln!(text, "    let {turns} = parity_above({});", name(axes - 1));
    for axis in 0..axes {
        let _ = writeln!(text, "    {} ^= {turns};", name(axis));
    }
}

/// Adds the bits of a number of `width` bits to the words, by exclusive or. Neighbouring bits that keep their
/// distance move together.
fn spread(text: &mut String, name: &str, width: u32, positions: &[u32]) {
    let bits =
        positions.iter().enumerate().map(|(mention, &position)| (width - 1 - mention as u32, position));
    let mut runs: Vec<(u32, u32, u32)> = Vec::new();
    for (from, to) in bits {
        match runs.last_mut() {
            // One run per distance moved and per word.
            Some((mask, last_from, last_to))
                if *last_from == from + 1 && *last_to == to + 1 && to % 32 != 31 =>
            {
                *mask |= 1 << from;
                (*last_from, *last_to) = (from, to);
            }
            _ => runs.push((1 << from, from, to)),
        }
    }
    for (mask, from, to) in runs {
        let (word, to) = if to < 32 { ("low", to) } else { ("high", to - 32) };
        let bits = format!("{name} & {mask}u");
        let _ = match from.cmp(&to) {
            std::cmp::Ordering::Less => writeln!(text, "    {word} ^= ({bits}) << {}u;", to - from),
            std::cmp::Ordering::Equal => writeln!(text, "    {word} ^= {bits};"),
            std::cmp::Ordering::Greater => writeln!(text, "    {word} ^= ({bits}) >> {}u;", from - to),
        };
    }
}

/// `fn from_light(light: u32, ray: UnitRay) -> vec3<f32>` over the `light_sites` binding.
fn from_light_function(lights: &[LightSite]) -> String {
    let has = |predicate: fn(&LightSite) -> bool| lights.iter().any(predicate);
    let mut text =
        "fn from_light(light: u32, ray: UnitRay) -> vec3<f32> {\n    let site = light_sites[light];\n"
            .to_owned();
    if has(|site| matches!(site, LightSite::Directional { .. })) {
        text.push_str(
            "    if site.shape == SITE_DIRECTIONAL {\n        return vec3(\n            cartesian(rounded(dot3(ray.origin, site.tangent) * INVERSE_SQRT_3)),\n            cartesian(rounded(dot3(ray.origin, site.bitangent) * INVERSE_SQRT_3)),\n            cartesian(rounded(dot3(ray.origin, site.place) * INVERSE_SQRT_3)),\n        );\n    }\n",
        );
    }
    if has(|site| matches!(site, LightSite::Environment)) {
        text.push_str("    if site.shape == SITE_ENVIRONMENT {\n        return vec3(octahedral(ray.direction), 0.0);\n    }\n");
    }
    text.push_str("    let d = ray.origin - site.place;\n    return vec3(octahedral(d), root(dot3(d, d)) * INVERSE_SQRT_3);\n}\n");
    text
}

/// The expression for the length estimate of ray `index` in the key kernel.
pub fn length_expression(termination: Termination, two_point_length: f32) -> String {
    match termination {
        Termination::Unused | Termination::Fixed => wgsl_f32(two_point_length),
        Termination::Adaptive => "table_length(ray)".to_owned(),
        Termination::Real => "traced_length(ray, index)".to_owned(),
    }
}
