// Camera rays: the same on threads is `stages::generate::cpu`.

var<private> infinity_bits: u32 = 0x7f800000u;

fn run_item(pixel: u32) {
    var random = random_start(params.seed, pixel, params.pass_index, 0u);
    let x = f32(pixel % params.width) + random_next(&random);
    let y = f32(pixel / params.width) + random_next(&random);
    let sx = 2.0 * x / f32(params.width) - 1.0;
    let sy = 1.0 - 2.0 * y / f32(params.height);
    let direction = normalize3(params.forward + params.right * sx + params.up * sy);
    origins[pixel] = vec4(params.eye, 0.0);
    directions[pixel] = vec4(direction, bitcast<f32>(infinity_bits));
    path_ids[pixel] = pixel;
    states[pixel] = vec4(bitcast<vec3<u32>>(vec3(1.0)), 0u);
}
