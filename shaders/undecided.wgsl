// Rays of a picture that the certified kernel left undecided: listed for the CPU, and put right
// when it has decided them.

struct Job {
    // Rays of the picture, or decisions.
    n: u32,
    // Workgroups of a row of the dispatch.
    row: u32,
}

struct Found {
    count: atomic<u32>,
    rays: array<u32>,
}

struct Decision {
    ray: u32,
    id: u32,
}

@group(0) @binding(next) var<uniform> job: Job;
@group(0) @binding(next) var<storage, read_write> ids: array<u32>;
@group(0) @binding(next) var<storage, read_write> found: Found;
@group(0) @binding(next) var<storage, read> decisions: array<Decision>;

fn job_index(workgroup: vec3u, lane: u32) -> u32 {
    let lanes = WORKGROUP_WIDTH * WORKGROUP_HEIGHT;
    return (workgroup.y * job.row + workgroup.x) * lanes + lane;
}

// In no particular order.
@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn find(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = job_index(workgroup, lane);
    if index < job.n && ids[index] == UNDECIDED {
        found.rays[atomicAdd(&found.count, 1u)] = index;
    }
}

@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn decide(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = job_index(workgroup, lane);
    if index < job.n {
        ids[decisions[index].ray] = decisions[index].id;
    }
}
