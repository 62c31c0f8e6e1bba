// The GGX lobe, composed in where a scene has surfaces that are not purely diffuse.

fn fresnel(f0: vec3<f32>, cosine: f32) -> vec3<f32> {
    let m = clamp(1.0 - cosine, 0.0, 1.0);
    let m2 = m * m;
    return f0 + (vec3(1.0) - f0) * (m2 * m2 * m);
}

fn specular_probability(surface: Bsdf, cos_out: f32) -> f32 {
    let specular = luminance(fresnel(surface.f0, cos_out));
    let diffuse = luminance(surface.diffuse);
    return specular / max(specular + diffuse, 1e-8);
}

fn ggx_distribution(alpha: f32, cosine: f32) -> f32 {
    let alpha2 = alpha * alpha;
    let spread = max(1.0 - cosine * cosine, 0.0) + alpha2 * cosine * cosine;
    return alpha2 * FRAC_1_PI / max(spread * spread, 1e-20);
}

fn smith_lambda(alpha: f32, cosine: f32) -> f32 {
    let cosine2 = cosine * cosine;
    let tangent2 = max(1.0 - cosine2, 0.0) / max(cosine2, 1e-12);
    return 0.5 * (sqrt(1.0 + alpha * alpha * tangent2) - 1.0);
}

fn visible_normal(alpha: f32, out_direction: vec3<f32>, a: f32, b: f32) -> vec3<f32> {
    let stretched = normalize3(vec3(out_direction.x * alpha, out_direction.y * alpha, out_direction.z));
    let turn = sine_cosine(a);
    let z = (1.0 - b) * (1.0 + stretched.z) - stretched.z;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    let cap = vec3(radius * turn.y, radius * turn.x, z) + stretched;
    return normalize3(vec3(cap.x * alpha, cap.y * alpha, max(cap.z, 1e-6)));
}

fn bsdf_evaluate(surface: Bsdf, out_direction: vec3<f32>, incident: vec3<f32>) -> BsdfValue {
    let matt = diffuse_evaluate(surface, out_direction, incident);
    if !surface.is_glossy || matt.density <= 0.0 {
        return matt;
    }
    let diffuse = matt.value;
    let diffuse_density = matt.density;
    let probability = specular_probability(surface, out_direction.z);
    let diffuse_probability = 1.0 - probability;
    let through = diffuse * (vec3(1.0) - fresnel(surface.f0, out_direction.z)) * (vec3(1.0) - fresnel(surface.f0, incident.z));
    if surface.alpha < MIRROR_ALPHA {
        return BsdfValue(through, diffuse_density * diffuse_probability);
    }
    let half_vector = normalize3(out_direction + incident);
    let reflected = fresnel(surface.f0, dot3(out_direction, half_vector));
    let distribution = ggx_distribution(surface.alpha, half_vector.z);
    let shadowing_out = smith_lambda(surface.alpha, out_direction.z);
    let shadowing = 1.0 / (1.0 + shadowing_out + smith_lambda(surface.alpha, incident.z));
    let specular = reflected * (distribution * shadowing / (4.0 * out_direction.z));
    let specular_density = distribution / ((1.0 + shadowing_out) * 4.0 * out_direction.z);
    return BsdfValue(
        specular + through,
        specular_density * probability + diffuse_density * diffuse_probability,
    );
}

fn bsdf_sample(surface: Bsdf, out_direction: vec3<f32>, random: ptr<function, u32>) -> BsdfSample {
    let choice = random_next(random);
    let a = random_next(random);
    let b = random_next(random);
    if !surface.is_glossy {
        return diffuse_sample(surface, out_direction, a, b);
    }
    let none = BsdfSample(vec3(0.0), vec3(0.0), -1.0);
    if out_direction.z <= 0.0 {
        return none;
    }
    let probability = specular_probability(surface, out_direction.z);
    let is_specular = choice < probability;
    if is_specular && surface.alpha < MIRROR_ALPHA {
        let weight = fresnel(surface.f0, out_direction.z) * (1.0 / probability);
        return BsdfSample(vec3(-out_direction.x, -out_direction.y, out_direction.z), weight, 0.0);
    }
    var direction: vec3<f32>;
    if is_specular {
        let half_vector = visible_normal(surface.alpha, out_direction, a, b);
        direction = half_vector * (2.0 * dot3(out_direction, half_vector)) - out_direction;
    } else {
        direction = cosine_hemisphere(a, b);
    }
    if direction.z <= 0.0 {
        return none;
    }
    let found = bsdf_evaluate(surface, out_direction, direction);
    if found.density <= 1e-12 {
        return none;
    }
    return BsdfSample(direction, found.value * (1.0 / found.density), found.density);
}
