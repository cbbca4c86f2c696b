// Bytes of pixels in the light of the kernel certified: where bounds in f32 tell one byte of each colour, these, else UNDECIDED.
// The bounds are printed: printed/light.wgsl.

struct Lamp {
    aim: Aim,
    weight: vec3f,
    casts_shadows: f32,
    //#if contacts
    // The ids of objects that it is close to, 0 for none, and its sides of them.
    contacts: vec4u,
    sides: vec4f,
    //#end
}

struct Lighting {
    @align(16) lengths: SurfaceErrorTerms,
    @align(16) ambient: LightBounds,
    @align(16) width: Bounds,
}

@group(0) @binding(next) var<storage, read_write> codes: array<u32>;
@group(0) @binding(next) var<uniform> lighting: Lighting;
//#if tree
struct AnchoredSphere {
    seen: SphereRecord,
    anchor: Anchor,
}
// By ids: of all objects the colours, the background's first, and of all spheres how the eye and shadow rays meet them.
@group(0) @binding(next) var<storage, read> colors: array<vec4f>;
@group(0) @binding(next) var<storage, read> seen_spheres: array<AnchoredSphere>;
//#if lamps
@group(0) @binding(next) var<storage, read> met_in_tree: array<SphereOccluder>;
//#end
//#else
@group(0) @binding(next) var<uniform> colors: array<vec4f, N_COLORS>;
//#end
// Of each byte where its range begins and ends, and where the next one does.
@group(0) @binding(next) var<uniform> ends: array<vec4f, 256>;
//#if lamps
//#each met shape
struct OccludingShape {
    met: ShapeOccluder,
    id: u32,
}
@group(0) @binding(next) var<uniform> met_shapes: array<OccludingShape, N_MET_SHAPES>;
//#end
//#end

//#if tree
fn color_of(id: u32) -> vec3f {
    return colors[select(0u, id, id < arrayLength(&colors))].xyz;
}

fn sphere_of(id: u32) -> AnchoredSphere {
    return seen_spheres[min(id - 1u, params.n_spheres - 1u)];
}
//#else
// Looked for, here and below: a load of each lane's own record is slow.
fn color_of(id: u32) -> vec3f {
    var color = colors[0].xyz;
    for (var k = 1u; k < N_COLORS; k++) {
        color = select(color, colors[k].xyz, id == k);
    }
    return color;
}
//#end

//#each indexed shape
fn shape_of(id: u32) -> ShapeRecord {
    var shape = shapes[0];
    for (var i = 1u; i < N_SHAPES; i++) {
        if id == shape_id(i) {
            shape = shapes[i];
        }
    }
    return shape;
}
//#end

fn sphere_surface(sphere: SphereRecord, ray: Ray, lengths: SurfaceErrorTerms) -> SurfacePoint {
    //#if close
    if sphere.is_close > 0.0 {
        return sphere_surface_close(sphere, ray, lengths);
    }
    //#end
    return sphere_surface_far(sphere, ray, lengths);
}

fn surface_of(id: u32, ray: Ray, steps: vec2f) -> SurfacePoint {
    var surface = SurfacePoint(vec3f(0.0), BEYOND, vec3f(0.0), BEYOND, 1.0);
    //#each indexed shape
    if id - first_shape() < params.n_shapes {
        surface = shape_surface(shape_of(id), ray, lighting.lengths);
    }
    //#end
    //#if tree
    if id - first_sphere() < params.n_spheres {
        let sphere = sphere_of(id);
        let anchor = sphere.anchor;
        let here = anchor_ray(anchor, params.right, params.true_up, steps.x, steps.y, ray);
        surface = sphere_surface(sphere.seen, here, lighting.lengths);
        surface.point = anchor.base + surface.point;
        surface.point_error += anchor.error;
    }
    //#end
    return surface;
}

//#if contacts
// The side of an object that a lamp is on; 2 where the lamp is not close to it.
fn side_at(lamp: Lamp, id: u32) -> f32 {
    let sides = select(vec4f(2.0), lamp.sides, lamp.contacts == vec4u(id));
    return min(min(sides.x, sides.y), min(sides.z, sides.w));
}
//#end

//#if lamps
// With an object that is in the way of no ray that starts on it.
fn with_occluder(verdict: Occlusion, next: Occlusion, is_own: bool) -> Occlusion {
    return verdict_with(
        verdict, Occlusion(select(next.blocked, -1.0, is_own), select(next.clear, 1.0, is_own)));
}

//#if tree
// With the spheres of the tree. What an ended walk has not looked at may be in the way.
fn verdict_in_tree(listed: Occlusion, ray: ShadowRay, lamp: Lamp, own: u32) -> Occlusion {
    let slabs = shadow_slabs(ray);
    var verdict = listed;
    var at = 0u;
    var n_left = select(0u, MOST_BOXES, is_near(ray));
    while at < walk.n_boxes && n_left > 0u && verdict.blocked <= 0.0 {
        n_left -= 1u;
        let step = step_at(at, slabs, ray.last);
        at = step.at;
        if step.place != NO_PLACE {
            let met = met_in_tree[step.id - 1u];
            var next = sphere_occludes(met, ray);
            //#if contacts
            let side = side_at(lamp, step.id);
            if side < 2.0 {
                next = sphere_occludes_beside(met, ray, side);
            }
            //#end
            verdict = with_occluder(verdict, next, own == step.id);
        }
    }
    return Occlusion(verdict.blocked, select(verdict.clear, -1.0, at < walk.n_boxes));
}
//#end

fn given_of(lamp: Lamp, surface: SurfacePoint, id: u32) -> Bounds {
    let ray = shadow_ray(lamp.aim, surface.point, surface.point_error);
    // From inside a sphere it is left open.
    var verdict = Occlusion(-1.0, surface.front);
    //#each met shape
    for (var i = 0u; i < N_MET_SHAPES; i++) {
        let other = met_shapes[i];
        var next = shape_occludes(other.met, ray);
        //#if contacts
        let side = side_at(lamp, other.id);
        if side < 2.0 {
            next = shape_occludes_beside(other.met, ray, side);
        }
        //#end
        verdict = with_occluder(verdict, next, id == other.id);
    }
    //#end
    let given = cosine(ray, surface.normal, surface.normal_error);
    //#if tree
    if lamp.casts_shadows > 0.0 && given.high > 0.0 {
        verdict = verdict_in_tree(verdict, ray, lamp, id);
    }
    //#end
    if lamp.casts_shadows == 0.0 {
        verdict = Occlusion(-1.0, 1.0);
    }
    return behind(given, verdict);
}
//#end

// About the sRGB byte of a linear value, less a half: whole numbers below are the byte or the one before. No bound, as the
// byte's ends are looked at. (Coefficients: I. Taylor, sRGB approximations for HLSL, 2013.)
fn byte_before(light: f32) -> f32 {
    let linear = min(max(light, 0.0), 1.0);
    let root2 = sqrt(linear);
    let root4 = sqrt(root2);
    let root8 = sqrt(root4);
    let curve =
        0.662002687 * root2 + 0.684122060 * root4 - 0.323583601 * root8 - 0.0225411470 * linear;
    let srgb = select(curve, 12.92 * linear, linear < 0.0031308);
    return min(max(255.0 * srgb, 0.0), 255.0);
}

// The byte whose range holds both bounds; 256 where none does.
fn byte_of(low: f32, high: f32) -> u32 {
    let before = u32(byte_before(low));
    let range = ends[before].xyz;
    let is_next = range.y <= low;
    let is_one = (range.x <= low) & (high < select(range.y, range.z, is_next));
    return select(256u, before + u32(is_next), is_one);
}

// With a sample of a pixel, by its column and row among all samples of the tile. One that is left open may have any colour.
fn with_sample_at(sum: LightBounds, place: vec2u) -> LightBounds {
    let ray = ray_at(place);
    let id = id_of(ray);
    var surface = surface_of(id, ray, steps_at(place));
    let is_none = id == 0u;
    let is_known = !is_none & (id != UNDECIDED) & (surface.point_error < KNOWN);
    // Of what is not known numbers may be huge. A cosine says nothing where a normal is off by 1.
    surface.point = select(vec3f(0.0), surface.point, is_known);
    surface.normal =
        select(vec3f(0.0), surface.normal, is_known & (surface.normal_error < 1.0));
    // Before the lamps: that is a sixth of the time of lavapipe.
    let color = color_of(id);
    var light = lighting.ambient;
    //#each lamp
    light = light_with(light, lamps[INDEX].weight, given_of(lamps[INDEX], surface, id));
    //#end
    let is_open = !is_none & !is_known;
    let one = vec3f(1.0);
    light = LightBounds(select(light.low, one, is_none), select(light.high, one, is_none));
    light = light_on(light, color);
    // Then the mean is beyond the last byte's end.
    let low = select(light.low, vec3f(0.0), is_open);
    return light_plus(sum, LightBounds(low, select(light.high, vec3f(BEYOND), is_open)));
}

@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn render(@builtin(global_invocation_id) pixel: vec3u) {
    let index = pixel.y * params.width + pixel.x;
    var sum = LightBounds(vec3f(0.0), vec3f(0.0));
    // No loop around loops, here and over lamps, where they are few: that takes twice as long on lavapipe.
    //#each sample
    sum = with_sample_at(sum, pixel.xy * N_SAMPLES + vec2u(INDEX % N_SAMPLES, INDEX / N_SAMPLES));
    //#end
    let pixel_light = light_mean(sum, f32(N_SAMPLES * N_SAMPLES), lighting.width);
    let r = byte_of(pixel_light.low.x, pixel_light.high.x);
    let g = byte_of(pixel_light.low.y, pixel_light.high.y);
    let b = byte_of(pixel_light.low.z, pixel_light.high.z);
    let is_open = (r | g | b) > 255u;
    if pixel.x < params.width && index < params.n_rays {
        codes[index] = select(r | g << 8u | b << 16u, UNDECIDED, is_open);
    }
}
