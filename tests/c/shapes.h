/* A sphere and markers on an ellipsoid: a small problem with a known answer. */
#ifndef SHAPES_H
#define SHAPES_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "moulage.h"

#define RINGS 12
#define SIDES 16
#define POINTS (2 + (RINGS - 1) * SIDES)
#define TRIANGLES (2 * SIDES * (RINGS - 1))

#define CHECK(condition)                                                                      \
    do {                                                                                      \
        if (!(condition)) {                                                                   \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);           \
            exit(1);                                                                          \
        }                                                                                     \
    } while (0)

static inline void make_sphere(double *points, uint32_t *triangles) {
    const double pi = 3.14159265358979323846;
    double *p = points;
    uint32_t *t = triangles;
    uint32_t r, s;
    *p++ = 0, *p++ = 0, *p++ = 1;
    for (r = 1; r < RINGS; r++)
        for (s = 0; s < SIDES; s++) {
            const double polar = pi * r / RINGS, turn = 2 * pi * s / SIDES;
            *p++ = sin(polar) * cos(turn), *p++ = sin(polar) * sin(turn), *p++ = cos(polar);
        }
    *p++ = 0, *p++ = 0, *p++ = -1;
#define AT(r, s) (1 + ((r) - 1) * SIDES + (s) % SIDES)
    for (s = 0; s < SIDES; s++) {
        *t++ = 0, *t++ = AT(1, s), *t++ = AT(1, s + 1);
        for (r = 1; r < RINGS - 1; r++) {
            *t++ = AT(r, s), *t++ = AT(r + 1, s), *t++ = AT(r + 1, s + 1);
            *t++ = AT(r, s), *t++ = AT(r + 1, s + 1), *t++ = AT(r, s + 1);
        }
        *t++ = POINTS - 1, *t++ = AT(RINGS - 1, s + 1), *t++ = AT(RINGS - 1, s);
    }
#undef AT
    CHECK(p == points + 3 * POINTS && t == triangles + 3 * TRIANGLES);
}

static inline MlgTriMesh *sphere_mesh(double *points) {
    uint32_t triangles[3 * TRIANGLES];
    MlgTriMesh *mesh = NULL;
    make_sphere(points, triangles);
    CHECK(mlg_tri_mesh_new(points, POINTS, triangles, TRIANGLES, &mesh, NULL) == MLG_STATUS_OK);
    return mesh;
}

static inline MlgTetrahedralization *sphere_tets(double *points, uint32_t tet_count) {
    MlgTetrahedralizationOptions options;
    MlgTetrahedralization *tets = NULL;
    MlgError error;
    MlgTriMesh *mesh = sphere_mesh(points);
    CHECK(mlg_tetrahedralization_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.method = MLG_TETS_LATTICE;
    options.tet_count = tet_count;
    if (mlg_tetrahedralization_run(mesh, &options, &tets, &error) != MLG_STATUS_OK) {
        fprintf(stderr, "%s\n", error.message);
        exit(1);
    }
    mlg_tri_mesh_free(mesh);
    return tets;
}

/* Every third point of the sphere, on an ellipsoid of radii 1.5, 1, 0.8. */
static inline size_t ellipsoid_markers(const double *points, double *markers) {
    size_t i, count = 0;
    for (i = 0; i < POINTS; i += 3, count++) {
        markers[3 * count] = 1.5 * points[3 * i];
        markers[3 * count + 1] = points[3 * i + 1];
        markers[3 * count + 2] = 0.8 * points[3 * i + 2];
    }
    return count;
}

/* The tets of the last call are kept: under valgrind they take seven seconds. */
static inline MlgReshaping *sphere_problem(double *points, uint32_t tet_count) {
    static MlgTetrahedralization *tets;
    static uint32_t kept_count;
    static double kept_points[3 * POINTS];
    double markers[3 * POINTS];
    MlgReshaping *problem = NULL;
    size_t count;
    if (tet_count != kept_count) {
        mlg_tetrahedralization_free(tets);
        tets = sphere_tets(kept_points, kept_count = tet_count);
    }
    memcpy(points, kept_points, sizeof kept_points);
    count = ellipsoid_markers(points, markers);
    CHECK(mlg_reshaping_new(tets, &problem, NULL) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_set_markers(problem, markers, NULL, count, NULL) == MLG_STATUS_OK);
    return problem;
}

#endif
