//! Flattening against plain f64 matrices.

use fastrand::Rng;
use serde_json::{Value, json};

use crate::fixture::Fixture;

/// Rows of a 4×4 matrix.
type Matrix = [[f64; 4]; 4];

const SEEDS: u64 = 60;

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let element = |row: usize, column: usize| (0..4).map(|k| a[row][k] * b[k][column]).sum();
    std::array::from_fn(|row| std::array::from_fn(|column| element(row, column)))
}

fn transform(m: &Matrix, [x, y, z]: [f64; 3], w: f64) -> [f64; 3] {
    std::array::from_fn(|row| m[row][0] * x + m[row][1] * y + m[row][2] * z + m[row][3] * w)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| x / dot(v, v).sqrt())
}

/// Multiplies by the inverse transpose: solves `transpose(m)·n = normal` by Cramer's rule.
fn transform_normal(m: &Matrix, normal: [f64; 3]) -> [f64; 3] {
    let column = |column: usize| [m[0][column], m[1][column], m[2][column]];
    let determinant = |a, b, c| dot(a, cross(b, c));
    let transposed: [[f64; 3]; 3] = std::array::from_fn(|row| {
        // Column `row` of the transpose.
        [m[row][0], m[row][1], m[row][2]]
    });
    let whole = determinant(column(0), column(1), column(2));
    let solution = std::array::from_fn(|unknown| {
        let mut columns = transposed;
        columns[unknown] = normal;
        determinant(columns[0], columns[1], columns[2]) / whole
    });
    unit(solution)
}

/// Between −1 and 1.
fn signed(random: &mut Rng) -> f32 {
    2.0 * random.f32() - 1.0
}

/// A random transform, as JSON and as a matrix.
fn random_node(random: &mut Rng) -> (Value, Matrix) {
    let mut three = |scale: f32| -> [f32; 3] { std::array::from_fn(|_| signed(random) * scale) };
    let translation = three(50.0);
    // Away from zero, often negative.
    let scale = three(1.0).map(|x| x + 0.5_f32.copysign(x));
    let axis = unit(three(1.0).map(f64::from));
    let angle = f64::from(signed(random)) * 3.0;
    let rotation = [
        (axis[0] * (angle / 2.0).sin()) as f32,
        (axis[1] * (angle / 2.0).sin()) as f32,
        (axis[2] * (angle / 2.0).sin()) as f32,
        (angle / 2.0).cos() as f32,
    ];
    // Rodrigues' formula.
    let (sin, cos) = angle.sin_cos();
    let skew = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    let mut matrix = [[0.0; 4]; 4];
    for row in 0..3 {
        for column in 0..3 {
            let same = f64::from(u8::from(row == column));
            let turned = cos * same + sin * skew[row][column] + (1.0 - cos) * axis[row] * axis[column];
            matrix[row][column] = turned * f64::from(scale[column]);
        }
        matrix[row][3] = f64::from(translation[row]);
    }
    matrix[3][3] = 1.0;
    if random.bool() {
        return (json!({ "translation": translation, "rotation": rotation, "scale": scale }), matrix);
    }
    // glTF lists columns. The oracle rounds as the file does.
    matrix = matrix.map(|row| row.map(|x| f64::from(x as f32)));
    let columns: Vec<f64> = (0..16).map(|place| matrix[place % 4][place / 4]).collect();
    (json!({ "matrix": columns }), matrix)
}

#[test]
fn flattening_equals_f64_matrices() {
    for seed in 0..SEEDS {
        let mut random = Rng::with_seed(seed);
        let mut fixture = Fixture::new();
        let mut vectors =
            || -> Vec<[f32; 3]> { (0..6).map(|_| std::array::from_fn(|_| signed(&mut random))).collect() };
        let (vertices, directions) = (vectors(), vectors());
        let (positions, normals) = (fixture.vectors(&vertices), fixture.vectors(&directions));
        let primitive = json!({ "attributes": { "POSITION": positions, "NORMAL": normals } });
        fixture.push("meshes", json!({ "primitives": [primitive] }));

        // A chain of nodes with the mesh at every level.
        let mut world: Vec<Matrix> = Vec::new();
        for level in 0..4 {
            let (mut node, matrix) = random_node(&mut random);
            node["mesh"] = json!(0);
            if level < 3 {
                node["children"] = json!([level + 1]);
            }
            fixture.push("nodes", node);
            world.push(world.last().map_or(matrix, |parent| multiply(parent, &matrix)));
        }
        fixture.json["scenes"][0]["nodes"] = json!([0]);

        let scene = fixture.scene();
        assert_eq!(scene.triangles.len(), 2 * world.len());
        for (triangle, &[a, b, c]) in scene.triangles.iter().enumerate() {
            let matrix = &world[triangle / 2];
            let first = 3 * (triangle % 2);
            for (corner, vertex) in [a, b, c].into_iter().enumerate() {
                let local = scene_vertex(vertex) + first;
                let expected = transform(matrix, vertices[local].map(f64::from), 1.0);
                let found = scene.positions[vertex as usize].map(f64::from);
                let reach = expected.iter().fold(1.0_f64, |reach, x| reach.max(x.abs()));
                for (found, expected) in found.iter().zip(expected) {
                    assert!((found - expected).abs() < 2e-7 * reach, "seed {seed}, corner {corner}");
                }
                let expected = transform_normal(matrix, directions[local].map(f64::from));
                let found = scene.normals[vertex as usize].map(f64::from);
                assert!(dot(found, expected) > 1.0 - 1e-6, "seed {seed}: normal {found:?} {expected:?}");
            }
            // The front stays the front: the winding agrees with the transformed face normal.
            let [a, b, c]: [[f64; 3]; 3] =
                std::array::from_fn(|corner| vertices[first + corner].map(f64::from));
            let [ab, ac] = [b, c].map(|end| std::array::from_fn(|axis| end[axis] - a[axis]));
            let expected = transform_normal(matrix, unit(cross(ab, ac)));
            let [a, b, c] = scene.corners(triangle).map(|corner| corner.map(f64::from));
            let [ab, ac] = [b, c].map(|end| std::array::from_fn(|axis| end[axis] - a[axis]));
            assert!(dot(unit(cross(ab, ac)), expected) > 0.99, "seed {seed}: winding of {triangle}");
        }
    }
}

/// Which corner of its triangle a vertex was in the file: without indices, vertices stay in order.
fn scene_vertex(vertex: u32) -> usize {
    vertex as usize % 3
}
