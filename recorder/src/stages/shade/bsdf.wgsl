// Metallic-roughness reflection, the diffuse part: the same on threads is `stages::shade::bsdf`.

struct Bsdf {
    diffuse: vec3<f32>,
    f0: vec3<f32>,
    alpha: f32,
    is_glossy: bool,
}

// A density of −1 says that there is no direction.
struct BsdfSample {
    direction: vec3<f32>,
    weight: vec3<f32>,
    density: f32,
}

struct BsdfValue {
    value: vec3<f32>,
    density: f32,
}

fn surface_new(base_color: vec3<f32>, metallic: f32, roughness: f32) -> Bsdf {
    return Bsdf(
        base_color * (1.0 - metallic),
        vec3(DIELECTRIC_F0) * (1.0 - metallic) + base_color * metallic,
        roughness * roughness,
        metallic > 0.0 || roughness < 1.0,
    );
}

fn diffuse_evaluate(surface: Bsdf, out_direction: vec3<f32>, incident: vec3<f32>) -> BsdfValue {
    if out_direction.z <= 0.0 || incident.z <= 0.0 {
        return BsdfValue(vec3(0.0), 0.0);
    }
    return BsdfValue(surface.diffuse * (incident.z * FRAC_1_PI), incident.z * FRAC_1_PI);
}

fn diffuse_sample(surface: Bsdf, out_direction: vec3<f32>, a: f32, b: f32) -> BsdfSample {
    let direction = cosine_hemisphere(a, b);
    if out_direction.z <= 0.0 || direction.z <= 0.0 {
        return BsdfSample(vec3(0.0), vec3(0.0), -1.0);
    }
    return BsdfSample(direction, surface.diffuse, direction.z * FRAC_1_PI);
}
