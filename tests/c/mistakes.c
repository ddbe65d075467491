/* Everything a caller can do wrong gives a status and a sentence, never a crash. */
#include "answers.h"
#include "shapes.h"

static void meshes(void) {
    const double points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const double bad_points[] = {0, 0, 0, 1, 0, 0, 0, NAN, 0};
    const uint32_t triangle[] = {0, 1, 2}, bad_triangle[] = {0, 1, 3}, flat_tet[] = {0, 1, 2, 2};
    MlgTriMesh *mesh = NULL, *untouched = NULL;
    MlgTetMesh *tets = NULL;
    size_t count = 7;
    char text[16];

    expect(mlg_tri_mesh_new(NULL, 3, triangle, 1, &mesh, &error), MLG_STATUS_NULL_ARGUMENT, "points");
    expect(mlg_tri_mesh_new(points, 3, NULL, 1, &mesh, &error), MLG_STATUS_NULL_ARGUMENT, "triangles");
    expect(mlg_tri_mesh_new(points, 3, triangle, 1, NULL, &error), MLG_STATUS_NULL_ARGUMENT, "out_mesh");
    expect(mlg_tri_mesh_new(bad_points, 3, triangle, 1, &mesh, &error), MLG_STATUS_INVALID_ARGUMENT,
           "point 2");
    expect(mlg_tri_mesh_new(points, 3, bad_triangle, 1, &mesh, &error), MLG_STATUS_INVALID_ARGUMENT,
           "vertex 3");
    expect(mlg_tri_mesh_new(points, SIZE_MAX, triangle, 1, &mesh, &error),
           MLG_STATUS_INVALID_ARGUMENT, "memory");
    expect(mlg_tet_mesh_new(points, 3, flat_tet, 1, &tets, &error), MLG_STATUS_INVALID_ARGUMENT,
           "no volume");
    expect(mlg_tri_mesh_load("no_such.obj", &mesh, &error), MLG_STATUS_IO, "no_such.obj");
    expect(mlg_tri_mesh_load("\xff.obj", &mesh, &error), MLG_STATUS_INVALID_ARGUMENT, "UTF-8");
    CHECK(mesh == untouched && tets == NULL);

    CHECK(mlg_tri_mesh_new(points, 3, triangle, 1, &mesh, NULL) == MLG_STATUS_OK);
    CHECK(mlg_tri_mesh_points(mesh, NULL)[3] == 1 && mlg_tri_mesh_triangles(mesh, &count)[2] == 2);
    CHECK(count == 1);
    CHECK(mlg_tri_mesh_check(mesh, text, sizeof text, &count, NULL) == MLG_STATUS_OK);
    CHECK(strlen(text) == sizeof text - 1 && count > sizeof text);
    expect(mlg_tri_mesh_check(mesh, NULL, 5, NULL, &error), MLG_STATUS_NULL_ARGUMENT, "buffer");
    expect(mlg_tri_mesh_save(mesh, points, 2, "x.obj", &error), MLG_STATUS_INVALID_ARGUMENT, "2 given");
    expect(mlg_tri_mesh_save(mesh, NULL, 0, "no_such/folder/x.obj", &error), MLG_STATUS_IO,
           "there is no folder no_such");

    /* Freed handles, handles of another type and pointers from nowhere. */
    count = 12345;
    CHECK(mlg_tet_mesh_points((const MlgTetMesh *)mesh, &count) == NULL && count == 0);
    mlg_tet_mesh_free((MlgTetMesh *)mesh);
    CHECK(mlg_tri_mesh_points(mesh, NULL) != NULL);
    mlg_tri_mesh_free(mesh);
    mlg_tri_mesh_free(mesh);
    mlg_tri_mesh_free(NULL);
    count = 12345;
    CHECK(mlg_tri_mesh_points(mesh, &count) == NULL && count == 0);
    expect(mlg_tri_mesh_check(mesh, NULL, 0, NULL, &error), MLG_STATUS_INVALID_ARGUMENT, "freed");
    expect(mlg_tri_mesh_check((const MlgTriMesh *)&error, NULL, 0, NULL, &error),
           MLG_STATUS_INVALID_ARGUMENT, "mesh");
    expect(mlg_tri_mesh_check(NULL, NULL, 0, NULL, &error), MLG_STATUS_NULL_ARGUMENT, "mesh");
}

static void options(void) {
    double points[3 * POINTS];
    MlgTriMesh *mesh = sphere_mesh(points);
    MlgTetrahedralization *tets = NULL;
    MlgTetrahedralizationOptions options;
    MlgTetQuality quality;

    CHECK(mlg_tetrahedralization_options_init(NULL, sizeof options) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_tetrahedralization_options_init(&options, sizeof options + 8) ==
          MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_tetrahedralization_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.method = 77;
    expect(mlg_tetrahedralization_run(mesh, &options, &tets, &error), MLG_STATUS_INVALID_ARGUMENT, "77");
    options.method = MLG_TETS_LATTICE;
    options.tet_count = 1;
    expect(mlg_tetrahedralization_run(mesh, &options, &tets, &error), MLG_STATUS_INVALID_ARGUMENT,
           "tet count");
    options.tet_count = 500;
    options.struct_size += 8;
    expect(mlg_tetrahedralization_run(mesh, &options, &tets, &error), MLG_STATUS_INVALID_ARGUMENT,
           "newer");
    options.struct_size = 0;
    expect(mlg_tetrahedralization_run(mesh, &options, &tets, &error), MLG_STATUS_INVALID_ARGUMENT,
           "struct_size");
    options.struct_size = sizeof options;
    options.method = MLG_TETS_TETGEN;
    options.tetgen_path = "/no/such/tetgen";
    expect(mlg_tetrahedralization_run(mesh, &options, &tets, &error), MLG_STATUS_INVALID_ARGUMENT,
           "no such file");
    /* An older caller, whose struct ended before the path. */
    options.method = MLG_TETS_LATTICE;
    options.struct_size = offsetof(MlgTetrahedralizationOptions, tetgen_path);
    CHECK(mlg_tetrahedralization_run(mesh, &options, &tets, &error) == MLG_STATUS_OK);
    quality.struct_size = offsetof(MlgTetQuality, min_dihedral);
    quality.min_dihedral = -1;
    CHECK(mlg_tetrahedralization_quality(tets, &quality, &error) == MLG_STATUS_OK);
    CHECK(quality.tet_count > 400 && quality.min_dihedral == -1);
    CHECK(mlg_tetrahedralization_method(tets) == MLG_TETS_LATTICE);
    CHECK(mlg_tetrahedralization_warning(tets, 99) == NULL);
    mlg_tetrahedralization_free(tets);
    mlg_tri_mesh_free(mesh);
}

static void problems(void) {
    double points[3 * POINTS];
    MlgReshaping *problem = sphere_problem(points, 500);
    MlgReshapingOptions options;
    MlgReshapingResult *result = NULL;
    MlgRun *run = NULL;
    const uint32_t vertices[] = {0, POINTS};
    const double weights[] = {1, -1}, infinite[] = {0, 0, INFINITY}, none[3 * POINTS] = {0};
    const double place[] = {1e6, 0, 0}, target[] = {1, 0, 0};

    expect(mlg_reshaping_set_markers(problem, infinite, NULL, 1, &error),
           MLG_STATUS_INVALID_ARGUMENT, "point 0");
    expect(mlg_reshaping_set_markers(problem, points, weights, 2, &error),
           MLG_STATUS_INVALID_ARGUMENT, "number 1");
    expect(mlg_reshaping_set_fixed(problem, vertices, 2, &error), MLG_STATUS_INVALID_ARGUMENT,
           "does not exist");
    expect(mlg_reshaping_set_landmarks_at_vertices(problem, vertices, points, NULL, 2, &error),
           MLG_STATUS_INVALID_ARGUMENT, "does not exist");
    expect(mlg_reshaping_set_landmarks(problem, points, NULL, NULL, 2, &error),
           MLG_STATUS_NULL_ARGUMENT, "targets");
    CHECK(mlg_reshaping_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.poisson = NAN;
    expect(mlg_reshaping_start(problem, &options, &run, &error), MLG_STATUS_INVALID_ARGUMENT, "Poisson");
    options.poisson = 0.3;
    options.tolerance = -1;
    expect(mlg_reshaping_start(problem, &options, &run, &error), MLG_STATUS_INVALID_ARGUMENT,
           "tolerance");
    options.tolerance = 0;
    options.thread_count = 5000;
    expect(mlg_reshaping_start(problem, &options, &run, &error), MLG_STATUS_INVALID_ARGUMENT,
           "5000 threads are too many");
    options.thread_count = UINT32_MAX;
    expect(mlg_reshaping_run(problem, &options, &result, &error), MLG_STATUS_INVALID_ARGUMENT,
           "4294967295 threads are too many");
    options.thread_count = 0;
    options.reserved = 1;
    expect(mlg_reshaping_run(problem, &options, &result, &error), MLG_STATUS_INVALID_ARGUMENT,
           "reserved");
    CHECK(mlg_reshaping_check(problem, NULL, 0, NULL, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_set_landmarks(problem, place, target, NULL, 1, &error) == MLG_STATUS_OK);
    expect(mlg_reshaping_check(problem, NULL, 0, NULL, &error), MLG_STATUS_INVALID_ARGUMENT,
           "not on the template");
    CHECK(mlg_reshaping_set_landmarks(problem, NULL, NULL, NULL, 0, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_set_markers(problem, points, none, POINTS, &error) == MLG_STATUS_OK);
    expect(mlg_reshaping_check(problem, NULL, 0, NULL, &error), MLG_STATUS_INVALID_ARGUMENT,
           "weight above 0");
    expect(mlg_reshaping_set_marker_sigmas(problem, points, 2, &error), MLG_STATUS_INVALID_ARGUMENT, "2 sigmas for");
    expect(mlg_reshaping_set_marker_sigmas(problem, infinite, 3, &error), MLG_STATUS_INVALID_ARGUMENT, "sigmas are 0 or more");
    CHECK(mlg_reshaping_set_markers(problem, NULL, NULL, 0, &error) == MLG_STATUS_OK);
    expect(mlg_reshaping_run(problem, NULL, &result, &error), MLG_STATUS_INVALID_ARGUMENT,
           "at least three");
    CHECK(run == NULL && result == NULL);
    mlg_run_cancel(NULL);
    mlg_run_free(NULL);
    expect(mlg_run_wait_reshaping(NULL, &result, &error), MLG_STATUS_NULL_ARGUMENT, "run");
    mlg_reshaping_free(problem);
    expect(mlg_reshaping_run(problem, NULL, &result, &error), MLG_STATUS_INVALID_ARGUMENT, "freed");
}

int main(void) {
    CHECK(mlg_abi_version() == MLG_ABI_VERSION);
    CHECK(strcmp(mlg_status_name(MLG_STATUS_PARSE), "PARSE") == 0);
    meshes();
    options();
    problems();
    puts("mistakes: good");
    return 0;
}
