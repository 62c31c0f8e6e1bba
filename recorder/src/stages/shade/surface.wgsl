// The surface at each hit of a dispatch: the same on threads is `stages::shade::surface`.

fn hit_surface(direction: vec3<f32>, hit: vec4<u32>) -> SurfaceData {
    let u = bitcast<f32>(hit.z);
    let v = bitcast<f32>(hit.w);
    let triangle = triangles[hit.y];
    let material = load_material(params.first_material + triangle.w * MATERIAL_WORDS);
    let p = positions[triangle.x].xyz;
    let pq = positions[triangle.y].xyz - p;
    let pr = positions[triangle.z].xyz - p;
    var geometric_normal = normalize3(cross3(pq, pr));
    if dot3(geometric_normal, direction) > 0.0 {
        geometric_normal = -geometric_normal;
    }
    let point = p + pq * u + pr * v;
    var surface: SurfaceData;
    surface.origin = offset_origin(point, geometric_normal, pq, pr);
    surface.t = bitcast<f32>(hit.x);
    surface.geometric_normal = geometric_normal;
    surface.metallic = material.metallic;
    surface.shading_normal = shading_normal(triangle, u, v, geometric_normal, direction);
    surface.roughness = material.roughness;
    surface.base_color = material.base_color * texture_factor(triangle, material, u, v);
    surface.emission = material.emission;
    return surface;
}

fn run_item(index: u32) {
    let hit = hits[index];
    if hit.y == NO_TRIANGLE {
        surfaces[index - params.first].t = bitcast<f32>(infinity_bits);
        return;
    }
    surfaces[index - params.first] = hit_surface(directions[index].xyz, hit);
}
