// Traces a picture of spheres with Embree 3, and prints the times of building and tracing as JSON.
//
//   embree_spheres SPHERES.npy --size 1280x720 --position X,Y,Z --look-at X,Y,Z --up X,Y,Z --fov DEGREES
//                  [--mode packet16|single] [--geometry point|user] [--relative] [--robust] [--isa NAME]
//                  [--repeat N] [--threads N] [-o HITS.npy]
//
// SPHERES.npy: float64 of shape (N, 4) or wider, whose first columns are x, y, z, radius. The rays are those of
// docs/contract.md, one through the centre of each pixel. HITS.npy: a structured array (height, width) of id (u4, from 1,
// 0 is the background), t (f4) and normal (3f4), as `kugelblitz judge` reads it.
//
// Embree reads spheres and rays as float32. Directions are computed in float64 and rounded once. `--relative` subtracts the
// camera's position in float64 first, as a careful user does. `--geometry user` replaces Embree's own spheres by callbacks
// that the compiler vectorises. As Embree's guide recommends, rays are marked as coherent and subnormal numbers are zero.
#include <embree3/rtcore.h>
#include <immintrin.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <vector>

constexpr int TILE = 32, LANES = 16, BLOCK = 4;  // a packet has 4 × 4 pixels
constexpr float INFINITE = std::numeric_limits<float>::infinity();

[[noreturn]] static void fail(const std::string &message) {
    fprintf(stderr, "embree_spheres: %s\n", message.c_str());
    exit(2);
}

struct Vec { double x, y, z; };
static Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
static Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static Vec unit(Vec a) { return 1 / std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z) * a; }

// Camera, scene and the picture of the last run.
static int width = 1280, height = 720;
static Vec position{0, 0, 0}, forward, right, up;  // right and up end at the picture's edges
static RTCScene scene;
static bool is_user = false;         // whether spheres are callbacks
static std::vector<float> vertices;  // x, y, z, radius of each sphere
static std::vector<uint32_t> ids;
static std::vector<float> ts, normals[3];

static double milliseconds() {
    using namespace std::chrono;
    return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}

static Vec read_vec(const char *text) {
    Vec v;
    if (sscanf(text, "%lf,%lf,%lf", &v.x, &v.y, &v.z) != 3) fail(std::string("expected X,Y,Z, found ") + text);
    return v;
}

// Returns the rows of an .npy file and sets their number of columns.
static std::vector<double> read_npy(const char *path, size_t &columns) {
    FILE *file = fopen(path, "rb");
    unsigned char head[12];
    if (!file || fread(head, 1, 12, file) != 12 || memcmp(head, "\x93NUMPY", 6)) fail(std::string(path) + ": expected a .npy file");
    size_t version_1 = head[6] == 1, length = head[8] | head[9] << 8 | (version_1 ? 0 : head[10] << 16);
    std::string header(length, ' ');
    fseek(file, version_1 ? 10 : 12, SEEK_SET);
    size_t rows = 0, shape = 0;
    if (fread(&header[0], 1, length, file) == length) shape = header.find("'shape': (");
    if (header.find("'<f8'") == std::string::npos || header.find("False") == std::string::npos ||
        sscanf(header.c_str() + shape, "'shape': (%zu, %zu)", &rows, &columns) != 2 || columns < 4)
        fail(std::string(path) + ": expected float64 of shape (N, 4) or wider");
    std::vector<double> values(rows * columns);
    if (fread(values.data(), sizeof(double), values.size(), file) != values.size()) fail(std::string(path) + ": truncated");
    fclose(file);
    return values;
}

static void write_npy(const char *path) {
    std::string header = "{'descr': [('id', '<u4'), ('t', '<f4'), ('normal', '<f4', (3,))], 'fortran_order': False, 'shape': (" +
                         std::to_string(height) + ", " + std::to_string(width) + ")}";
    header.resize((10 + header.size() + 64) / 64 * 64 - 11, ' ');
    header += '\n';
    FILE *file = fopen(path, "wb");
    if (!file) fail(std::string("cannot write ") + path);
    uint16_t length = uint16_t(header.size());
    fwrite("\x93NUMPY\x01\x00", 1, 8, file);
    fwrite(&length, 2, 1, file);
    fwrite(header.data(), 1, header.size(), file);
    for (size_t i = 0; i < ids.size(); i++) {
        float numbers[4] = {ts[i], normals[0][i], normals[1][i], normals[2][i]};
        fwrite(&ids[i], 4, 1, file);
        fwrite(numbers, 4, 4, file);
    }
    if (fclose(file)) fail(std::string("cannot write ") + path);
}

// Offsets of a pixel's centre from the picture's centre, from -1 to 1.
static double across(int x) { return 2 * (x + 0.5) / width - 1; }
static double upward(int y) { return 1 - 2 * (y + 0.5) / height; }

// Stores a hit: a unit normal that faces the ray, as Kugelblitz returns it. User geometry has no normal yet.
static void store(size_t pixel, uint32_t id, float t, float nx, float ny, float nz, float dx, float dy, float dz) {
    if (is_user && id != RTC_INVALID_GEOMETRY_ID) {
        const float *sphere = &vertices[4 * id];
        nx = float(position.x) - sphere[0] + t * dx;
        ny = float(position.y) - sphere[1] + t * dy;
        nz = float(position.z) - sphere[2] + t * dz;
    }
    float scale = 1 / std::sqrt(nx * nx + ny * ny + nz * nz);
    scale = nx * dx + ny * dy + nz * dz > 0 ? -scale : scale;
    ids[pixel] = id == RTC_INVALID_GEOMETRY_ID ? 0 : id + 1;
    ts[pixel] = t;
    normals[0][pixel] = nx * scale, normals[1][pixel] = ny * scale, normals[2][pixel] = nz * scale;
}

// Returns the box of a sphere, a few rounding errors larger.
static void sphere_bounds(const RTCBoundsFunctionArguments *args) {
    const float *sphere = &vertices[4 * args->primID];
    float *lower = &args->bounds_o->lower_x, *upper = &args->bounds_o->upper_x;
    for (int axis = 0; axis < 3; axis++) {
        float margin = 4 * std::numeric_limits<float>::epsilon() * (std::abs(sphere[axis]) + sphere[3]);
        lower[axis] = sphere[axis] - sphere[3] - margin;
        upper[axis] = sphere[axis] + sphere[3] + margin;
    }
}

// Intersects N rays with a sphere: the point of the ray next to the centre, then half of the chord.
template <int N> static void intersect_sphere(const RTCIntersectFunctionNArguments *args) {
    const float *sphere = &vertices[4 * args->primID];
    RTCRayN *ray = RTCRayHitN_RayN(args->rayhit, N);
    RTCHitN *hit = RTCRayHitN_HitN(args->rayhit, N);
    float t[N];
    int is_hit[N], any = 0;
    for (int i = 0; i < N; i++) {
        float dx = RTCRayN_dir_x(ray, N, i), dy = RTCRayN_dir_y(ray, N, i), dz = RTCRayN_dir_z(ray, N, i);
        float cx = sphere[0] - RTCRayN_org_x(ray, N, i), cy = sphere[1] - RTCRayN_org_y(ray, N, i);
        float cz = sphere[2] - RTCRayN_org_z(ray, N, i), scale = 1 / (dx * dx + dy * dy + dz * dz);
        float middle = (cx * dx + cy * dy + cz * dz) * scale;
        float px = middle * dx - cx, py = middle * dy - cy, pz = middle * dz - cz;
        float rest = sphere[3] * sphere[3] - (px * px + py * py + pz * pz);
        float half = std::sqrt(std::max(rest, 0.0f) * scale), near = RTCRayN_tnear(ray, N, i);
        t[i] = middle - half > near ? middle - half : middle + half;
        is_hit[i] = (args->valid[i] != 0) & (rest >= 0) & (t[i] > near) & (t[i] < RTCRayN_tfar(ray, N, i));
        any |= is_hit[i];
    }
    if (!any) return;
    for (int i = 0; i < N; i++) {
        RTCRayN_tfar(ray, N, i) = is_hit[i] ? t[i] : RTCRayN_tfar(ray, N, i);
        RTCHitN_primID(hit, N, i) = is_hit[i] ? args->primID : RTCHitN_primID(hit, N, i);
        RTCHitN_geomID(hit, N, i) = is_hit[i] ? args->geomID : RTCHitN_geomID(hit, N, i);
    }
}

static void intersect(const RTCIntersectFunctionNArguments *args) {
    if (args->N == 1) return intersect_sphere<1>(args);
    if (args->N == 4) return intersect_sphere<4>(args);
    if (args->N == 8) return intersect_sphere<8>(args);
    if (args->N == LANES) return intersect_sphere<LANES>(args);
    fail("unexpected packet");
}

static void trace_single(int x0, int y0, int x1, int y1, RTCIntersectContext &context) {
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            double u = across(x), v = upward(y);
            RTCRayHit rh;
            rh.ray.org_x = float(position.x), rh.ray.org_y = float(position.y), rh.ray.org_z = float(position.z);
            rh.ray.dir_x = float(forward.x + u * right.x + v * up.x);
            rh.ray.dir_y = float(forward.y + u * right.y + v * up.y);
            rh.ray.dir_z = float(forward.z + u * right.z + v * up.z);
            rh.ray.tnear = 0, rh.ray.tfar = INFINITE, rh.ray.time = 0, rh.ray.mask = ~0u, rh.ray.id = rh.ray.flags = 0;
            rh.hit.Ng_x = 1, rh.hit.Ng_y = rh.hit.Ng_z = 0;
            rh.hit.geomID = rh.hit.primID = rh.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene, &context, &rh);
            store(size_t(y) * width + x, rh.hit.primID, rh.ray.tfar, rh.hit.Ng_x, rh.hit.Ng_y, rh.hit.Ng_z, rh.ray.dir_x,
                  rh.ray.dir_y, rh.ray.dir_z);
        }
}

static void trace_packets(int x0, int y0, int x1, int y1, RTCIntersectContext &context) {
    alignas(64) RTCRayHit16 rh;
    alignas(64) int valid[LANES];
    for (int y = y0; y < y1; y += BLOCK)
        for (int x = x0; x < x1; x += BLOCK) {
            for (int i = 0; i < LANES; i++) {
                double u = across(x + i % BLOCK), v = upward(y + i / BLOCK);
                valid[i] = x + i % BLOCK < x1 && y + i / BLOCK < y1 ? -1 : 0;
                rh.ray.org_x[i] = float(position.x), rh.ray.org_y[i] = float(position.y), rh.ray.org_z[i] = float(position.z);
                rh.ray.dir_x[i] = float(forward.x + u * right.x + v * up.x);
                rh.ray.dir_y[i] = float(forward.y + u * right.y + v * up.y);
                rh.ray.dir_z[i] = float(forward.z + u * right.z + v * up.z);
                rh.ray.tnear[i] = 0, rh.ray.tfar[i] = INFINITE, rh.ray.time[i] = 0;
                rh.ray.mask[i] = ~0u, rh.ray.id[i] = rh.ray.flags[i] = 0;
                rh.hit.Ng_x[i] = 1, rh.hit.Ng_y[i] = rh.hit.Ng_z[i] = 0;
                rh.hit.geomID[i] = rh.hit.primID[i] = rh.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
            }
            rtcIntersect16(valid, scene, &context, &rh);
            for (int i = 0; i < LANES; i++)
                if (valid[i])
                    store(size_t(y + i / BLOCK) * width + x + i % BLOCK, rh.hit.primID[i], rh.ray.tfar[i], rh.hit.Ng_x[i],
                          rh.hit.Ng_y[i], rh.hit.Ng_z[i], rh.ray.dir_x[i], rh.ray.dir_y[i], rh.ray.dir_z[i]);
        }
}

// Traces the picture, in tiles that the threads take one after the other. Returns the milliseconds.
static double trace(bool packets, int n_threads) {
    int columns = (width + TILE - 1) / TILE, rows = (height + TILE - 1) / TILE;
    std::atomic<int> next{0};
    auto work = [&] {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _mm_setcsr(_mm_getcsr() | 0x40);  // subnormal operands are zero
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        for (int tile; (tile = next++) < columns * rows;) {
            int x = tile % columns * TILE, y = tile / columns * TILE;
            (packets ? trace_packets : trace_single)(x, y, std::min(x + TILE, width), std::min(y + TILE, height), context);
        }
    };
    double start = milliseconds();
    std::vector<std::thread> threads;
    for (int i = 1; i < n_threads; i++) threads.emplace_back(work);
    work();
    for (auto &thread : threads) thread.join();
    return milliseconds() - start;
}

static double median(std::vector<double> x) {
    std::sort(x.begin(), x.end());
    return (x[(x.size() - 1) / 2] + x[x.size() / 2]) / 2;
}

int main(int argc, char **argv) {
    const char *path = nullptr, *output = nullptr;
    std::string mode = "packet16";
    Vec look_at{0, 0, -1}, camera_up{0, 1, 0};
    double fov = 45;
    int n_repeats = 9, n_threads = int(std::max(1u, std::thread::hardware_concurrency()));
    bool is_relative = false, is_robust = false;
    std::string isa;
    for (int i = 1; i < argc; i++) {
        std::string name = argv[i];
        auto value = [&] { return ++i < argc ? argv[i] : (fail(name + " needs a value"), nullptr); };
        if (name == "--size") { if (sscanf(value(), "%dx%d", &width, &height) != 2) fail("expected --size WxH"); }
        else if (name == "--position") position = read_vec(value());
        else if (name == "--look-at") look_at = read_vec(value());
        else if (name == "--up") camera_up = read_vec(value());
        else if (name == "--fov") fov = atof(value());
        else if (name == "--mode") mode = value();
        else if (name == "--repeat") n_repeats = std::max(1, atoi(value()));
        else if (name == "--threads") n_threads = std::max(1, atoi(value()));
        else if (name == "--geometry") is_user = !strcmp(value(), "user");
        else if (name == "--isa") isa = std::string(",isa=") + value();
        else if (name == "--relative") is_relative = true;
        else if (name == "--robust") is_robust = true;
        else if (name == "-o") output = value();
        else if (name[0] == '-') fail("unknown option " + name);
        else path = argv[i];
    }
    if (!path || (mode != "packet16" && mode != "single")) fail("expected SPHERES.npy, and --mode packet16 or single");
    double h = std::tan(fov * M_PI / 360);
    forward = unit(look_at - position);
    right = unit(cross(forward, camera_up));
    up = h * cross(right, forward);
    right = h * width / height * right;
    Vec origin = is_relative ? position : Vec{0, 0, 0};
    position = position - origin;
    ids.assign(size_t(width) * height, 0);
    for (auto *v : {&ts, &normals[0], &normals[1], &normals[2]}) v->assign(ids.size(), 0);

    size_t columns;
    std::vector<double> spheres = read_npy(path, columns);
    size_t n_spheres = spheres.size() / columns;
    RTCDevice device = rtcNewDevice(("threads=" + std::to_string(n_threads) + isa).c_str());
    double start = milliseconds();
    scene = rtcNewScene(device);
    if (is_robust) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    vertices.resize(4 * n_spheres);
    for (size_t i = 0; i < n_spheres; i++) {
        const double *sphere = &spheres[i * columns];
        vertices[4 * i] = float(sphere[0] - origin.x), vertices[4 * i + 1] = float(sphere[1] - origin.y);
        vertices[4 * i + 2] = float(sphere[2] - origin.z), vertices[4 * i + 3] = float(sphere[3]);
    }
    RTCGeometry geometry = rtcNewGeometry(device, is_user ? RTC_GEOMETRY_TYPE_USER : RTC_GEOMETRY_TYPE_SPHERE_POINT);
    if (is_user) {
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(n_spheres));
        rtcSetGeometryBoundsFunction(geometry, sphere_bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersect);
    } else {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, vertices.data(), 0, 16, n_spheres);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    double build = milliseconds() - start;

    trace(mode == "packet16", n_threads);  // to warm up
    std::vector<double> runs;
    for (int i = 0; i < n_repeats; i++) runs.push_back(trace(mode == "packet16", n_threads));
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("Embree reported an error");
    if (output) write_npy(output);
    size_t hits = ids.size() - size_t(std::count(ids.begin(), ids.end(), 0));
    printf("{\"version\": \"%s\", \"mode\": \"%s\", \"threads\": %d, \"spheres\": %zu, \"rays\": %zu, \"hits\": %zu, "
           "\"build_ms\": %.4f, \"trace_ms\": %.4f}\n",
           RTC_VERSION_STRING, mode.c_str(), n_threads, n_spheres, ids.size(), hits, build, median(runs));
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
