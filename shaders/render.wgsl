// Bindings and the entry point. Bindings are numbered when the parts are put together.

@group(0) @binding(next) var<storage, read_write> ids: array<u32>;
//#if surface
@group(0) @binding(next) var<storage, read_write> ts: array<f32>;
@group(0) @binding(next) var<storage, read_write> normals: array<f32>;
//#end
//#if free
@group(0) @binding(next) var<storage, read> rays: array<RayRecord>;
//#end

// Straight-line up to the stores, without an early return: a software device takes its quick path
// for loads with one address only where no lane can be switched off. A tree comes last.
@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn render(@builtin(global_invocation_id) pixel: vec3u) {
    let index = pixel.y * params.width + pixel.x;
    //#if free
    let record = rays[min(index, params.n_rays - 1u)];
    //#if certified
    let ray = ray_from(record.origin, record.direction);
    //#else
    let ray = ray_from_parts(record.origin, record.origin_low, record.direction);
    //#end
    //#else
    let ray = ray_at(pixel.xy);
    //#end
    //#if certified
    let id = id_of(ray);
    //#else
    let hit = closest(ray);
    // What f32 can't hold of f64 is a miss.
    let t = f32(hit.t);
    let id = select(0u, hit.id, t < f32(params.infinity));
    //#end
    if pixel.x < params.width && index < params.n_rays {
        ids[index] = id;
        //#if surface
        ts[index] = t;
        var normal = vec3f(0.0);
        if id != 0u {
            normal = vec3f(normal_at(ray, hit));
        }
        normals[3u * index] = normal.x;
        normals[3u * index + 1u] = normal.y;
        normals[3u * index + 2u] = normal.z;
        //#end
    }
}
