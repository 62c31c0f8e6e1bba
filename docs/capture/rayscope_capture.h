/* Writes queues of rays as `recorder import --queues FOLDER` reads them. C99 and C++, little-endian
   machines; README.md beside this file says what is what.

   Each function gives 0, or -1 with errno set; a queue is named by its bounce and its kind, "closest" or
   "shadow". Arrays have an entry for each ray of the queue, in the order of their path indices. */
#ifndef RAYSCOPE_CAPTURE_H
#define RAYSCOPE_CAPTURE_H

#include <errno.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#ifdef _WIN32
#include <direct.h>
#define RAYSCOPE_MKDIR(path) _mkdir(path)
#else
#include <sys/stat.h>
#define RAYSCOPE_MKDIR(path) mkdir(path, 0777)
#endif

/* World space. Hits lie between t_min and t_max, in lengths of the direction; t_max of a ray without an end
   is INFINITY. */
typedef struct { float origin[3], t_min, direction[3], t_max; } rayscope_ray;

/* t in lengths of the direction; u and v are the weights of the triangle's second and third corner. A ray that
   hits nothing has t INFINITY, triangle UINT32_MAX, u 0, v 0. */
typedef struct { float t; uint32_t triangle; float u, v; } rayscope_hit;

#define RAYSCOPE_RAY \
    "[('origin', '<f4', (3,)), ('t_min', '<f4'), ('direction', '<f4', (3,)), ('t_max', '<f4')]"
#define RAYSCOPE_HIT "[('t', '<f4'), ('triangle', '<u4'), ('u', '<f4'), ('v', '<f4')]"

static inline int rayscope_folder(const char *path) {
    return RAYSCOPE_MKDIR(path) == 0 || errno == EEXIST ? 0 : -1;
}

/* An NPY file of version 1.0: magic, length, a description padded to a multiple of 64 bytes, the elements. */
static inline int rayscope_npy(const char *path, const char *descr, const void *data, size_t size, size_t count) {
    char text[256];
    unsigned char start[10] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, 0, 0};
    int used = snprintf(text, sizeof text, "{'descr': %s, 'fortran_order': False, 'shape': (%llu,), }", descr,
                        (unsigned long long)count);
    size_t length = (sizeof start + (size_t)used + 1 + 63) / 64 * 64 - sizeof start;
    FILE *file;
    int failed;
    if (used < 0 || length > sizeof text) { errno = EINVAL; return -1; }
    memset(text + used, ' ', length - (size_t)used);
    text[length - 1] = '\n';
    start[8] = (unsigned char)(length & 255);
    start[9] = (unsigned char)(length >> 8);
    file = fopen(path, "wb");
    if (!file) return -1;
    failed = fwrite(start, 1, sizeof start, file) != sizeof start || fwrite(text, 1, length, file) != length ||
             fwrite(data, size, count, file) != count;
    return fclose(file) != 0 || failed ? -1 : 0;
}

/* Writes FOLDER/bounce-BB/KIND/NAME.npy, or with an order FOLDER/bounce-BB/KIND/ORDER/NAME.npy. */
static inline int rayscope_array(const char *folder, int bounce, const char *kind, const char *order,
                                 const char *name, const char *descr, const void *data, size_t size, size_t count) {
    char path[4096];
    int used = snprintf(path, sizeof path, "%s", folder);
    const char *parts[3];
    char numbered[16];
    snprintf(numbered, sizeof numbered, "bounce-%02d", bounce);
    parts[0] = numbered, parts[1] = kind, parts[2] = order;
    for (int part = 0;; part++) {
        if (used < 0 || (size_t)used >= sizeof path) { errno = ENAMETOOLONG; return -1; }
        if (rayscope_folder(path)) return -1;
        if (part == 3 || !parts[part]) break;
        used += snprintf(path + used, sizeof path - (size_t)used, "/%s", parts[part]);
    }
    used += snprintf(path + used, sizeof path - (size_t)used, "/%s.npy", name);
    if ((size_t)used >= sizeof path) { errno = ENAMETOOLONG; return -1; }
    return rayscope_npy(path, descr, data, size, count);
}

static inline int rayscope_rays(const char *folder, int bounce, const char *kind, const rayscope_ray *rays,
                                size_t count) {
    return rayscope_array(folder, bounce, kind, NULL, "rays", RAYSCOPE_RAY, rays, sizeof *rays, count);
}

/* Ascending, y * width + x of each path's pixel; 0 to count - 1 if not written. */
static inline int rayscope_path_ids(const char *folder, int bounce, const char *kind, const uint32_t *ids,
                                    size_t count) {
    return rayscope_array(folder, bounce, kind, NULL, "path_ids", "'<u4'", ids, sizeof *ids, count);
}

static inline int rayscope_hits(const char *folder, int bounce, const rayscope_hit *hits, size_t count) {
    return rayscope_array(folder, bounce, "closest", NULL, "hits", RAYSCOPE_HIT, hits, sizeof *hits, count);
}

/* To any occluder between t_min and t_max of each shadow ray; INFINITY where the light is seen. */
static inline int rayscope_distances(const char *folder, int bounce, const float *distances, size_t count) {
    return rayscope_array(folder, bounce, "shadow", NULL, "distances", "'<f4'", distances, sizeof *distances, count);
}

/* An order of yours: the index of the ray at each place. Names have small letters, digits and dashes. */
static inline int rayscope_order(const char *folder, int bounce, const char *kind, const char *name,
                                 const uint32_t *permutation, size_t count) {
    return rayscope_array(folder, bounce, kind, name, "permutation", "'<u4'", permutation, 4, count);
}

/* The key of each ray, not sorted; bits is 32 or 64 and says what keys points to. */
static inline int rayscope_keys(const char *folder, int bounce, const char *kind, const char *name, int bits,
                                const void *keys, size_t count) {
    if (bits != 32 && bits != 64) { errno = EINVAL; return -1; }
    return rayscope_array(folder, bounce, kind, name, "keys", bits == 32 ? "'<u4'" : "'<u8'", keys,
                          (size_t)bits / 8, count);
}

#endif
