// A small ray tracer that writes its queues by rayscope_capture.h: camera rays of a box, shadow rays to its light
// and one bounce, with two orders of its own. Arguments: folder of the scene's arrays, folder to write.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "rayscope_capture.h"

struct Vector { double x, y, z; };
static Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vector operator*(Vector a, double s) { return {a.x * s, a.y * s, a.z * s}; }
static double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vector cross(Vector a, Vector b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static Vector unit(Vector a) { return a * (1 / std::sqrt(dot(a, a))); }

static void check(int failed) {
    if (failed) { std::perror("capture"); std::exit(1); }
}

// The elements of an NPY file of version 1.0.
template <typename T> static std::vector<T> read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (bytes.size() < 10) { std::fprintf(stderr, "cannot read %s\n", path.c_str()); std::exit(1); }
    size_t start = 10 + (unsigned char)bytes[8] + 256 * (unsigned char)bytes[9];
    std::vector<T> elements((bytes.size() - start) / sizeof(T));
    std::memcpy(elements.data(), bytes.data() + start, elements.size() * sizeof(T));
    return elements;
}

static std::vector<float> positions;
static std::vector<uint32_t> corners;

static Vector corner(size_t triangle, int number) {
    const float *p = &positions[3 * corners[3 * triangle + number]];
    return {p[0], p[1], p[2]};
}

static rayscope_hit trace(const rayscope_ray &ray) {
    rayscope_hit best = {INFINITY, UINT32_MAX, 0, 0};
    Vector o = {ray.origin[0], ray.origin[1], ray.origin[2]};
    Vector d = {ray.direction[0], ray.direction[1], ray.direction[2]};
    for (size_t triangle = 0; triangle < corners.size() / 3; triangle++) {
        Vector a = corner(triangle, 0), e = corner(triangle, 1) - a, f = corner(triangle, 2) - a;
        Vector p = cross(d, f), s = o - a, q = cross(s, e);
        double det = dot(e, p), u = dot(s, p) / det, v = dot(d, q) / det, t = dot(f, q) / det;
        if (det != 0 && u >= 0 && v >= 0 && u + v <= 1 && t >= ray.t_min && t <= ray.t_max && t < best.t)
            best = {(float)t, (uint32_t)triangle, (float)u, (float)v};
    }
    return best;
}

static rayscope_ray ray_of(Vector o, Vector d, float t_min, float t_max) {
    return {{(float)o.x, (float)o.y, (float)o.z}, t_min, {(float)d.x, (float)d.y, (float)d.z}, t_max};
}

// Ten bits of each axis of the origin within the scene's box, interleaved.
static uint32_t morton(const rayscope_ray &ray, const float least[3], float scale) {
    uint32_t key = 0;
    for (int level = 9; level >= 0; level--)
        for (int axis = 0; axis < 3; axis++) {
            float inside = std::min(std::max((ray.origin[axis] - least[axis]) * scale, 0.0f), 0.9999999f);
            key = key << 1 | ((uint32_t)(inside * 1024) >> level & 1);
        }
    return key;
}

template <typename K> static std::vector<uint32_t> sorted(const std::vector<K> &keys) {
    std::vector<uint32_t> order(keys.size());
    for (size_t at = 0; at < order.size(); at++) order[at] = (uint32_t)at;
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return keys[a] < keys[b]; });
    return order;
}

static void write(const char *folder, int bounce, const char *kind, const std::vector<rayscope_ray> &rays,
                  const std::vector<uint32_t> &paths, const float least[3], float scale) {
    check(rayscope_rays(folder, bounce, kind, rays.data(), rays.size()));
    check(rayscope_path_ids(folder, bounce, kind, paths.data(), paths.size()));
    std::vector<uint32_t> codes;
    std::vector<uint64_t> octants;
    for (const rayscope_ray &ray : rays) {
        codes.push_back(morton(ray, least, scale));
        octants.push_back((ray.direction[0] < 0) << 2 | (ray.direction[1] < 0) << 1 | (ray.direction[2] < 0));
    }
    check(rayscope_keys(folder, bounce, kind, "morton", 32, codes.data(), codes.size()));
    check(rayscope_order(folder, bounce, kind, "morton", sorted(codes).data(), codes.size()));
    check(rayscope_keys(folder, bounce, kind, "octants", 64, octants.data(), octants.size()));
    check(rayscope_order(folder, bounce, kind, "octants", sorted(octants).data(), octants.size()));
}

int main(int, char **arguments) {
    const std::string scene = arguments[1];
    const char *folder = arguments[2];
    positions = read<float>(scene + "/positions.npy");
    corners = read<uint32_t>(scene + "/triangles.npy");
    float least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY}, extent = 0;
    for (size_t at = 0; at < positions.size(); at++) {
        least[at % 3] = std::min(least[at % 3], positions[at]);
        most[at % 3] = std::max(most[at % 3], positions[at]);
    }
    for (int axis = 0; axis < 3; axis++) extent = std::max(extent, most[axis] - least[axis]);

    const int width = 64, height = 48;
    std::vector<rayscope_ray> camera, shadow, next;
    std::vector<rayscope_hit> hits, next_hits;
    std::vector<uint32_t> paths, alive;
    std::vector<float> distances;
    for (int pixel = 0; pixel < width * height; pixel++) {
        double x = (pixel % width + 0.37) / width - 0.5, y = 0.5 - (pixel / width + 0.61) / height;
        camera.push_back(ray_of({0.278, 0.273, -0.8}, unit({x, 0.75 * y, 1.1}), 0, INFINITY));
        hits.push_back(trace(camera.back()));
        paths.push_back((uint32_t)pixel);
        if (hits.back().triangle == UINT32_MAX) continue;
        const rayscope_ray &ray = camera.back();
        Vector d = {ray.direction[0], ray.direction[1], ray.direction[2]};
        Vector n = unit(cross(corner(hits.back().triangle, 1) - corner(hits.back().triangle, 0),
                              corner(hits.back().triangle, 2) - corner(hits.back().triangle, 0)));
        if (dot(n, d) > 0) n = n * -1;
        Vector at = Vector{ray.origin[0], ray.origin[1], ray.origin[2]} + d * hits.back().t + n * 1e-4;
        alive.push_back((uint32_t)pixel);
        // To the light as a whole: the direction is as long as the way there.
        shadow.push_back(ray_of(at, Vector{0.278, 0.54, 0.2795} - at, 0, 0.99f));
        distances.push_back(trace(shadow.back()).t);
        uint32_t random = (uint32_t)pixel * 2654435761u;
        Vector any = {(random & 1023) / 512.0 - 1, (random >> 10 & 1023) / 512.0 - 1, (random >> 20 & 1023) / 512.0 - 1};
        next.push_back(ray_of(at, unit(n * 1.8 + any), 0, INFINITY));
        next_hits.push_back(trace(next.back()));
    }
    write(folder, 0, "closest", camera, paths, least, 1 / extent);
    check(rayscope_hits(folder, 0, hits.data(), hits.size()));
    write(folder, 0, "shadow", shadow, alive, least, 1 / extent);
    check(rayscope_distances(folder, 0, distances.data(), distances.size()));
    write(folder, 1, "closest", next, alive, least, 1 / extent);
    check(rayscope_hits(folder, 1, next_hits.data(), next_hits.size()));
    std::ofstream(std::string(folder) + "/orders.txt") << "# What the keys are.\nmorton = (ox oy oz)*10 @ 30\n";
    return 0;
}
