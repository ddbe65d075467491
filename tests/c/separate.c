/* Bodies pushed apart: balls that overlap, a reshaped one beside a bone, cancel, mistakes.
 *   separate FOLDER            all of it; leaves left and right there, .vtu and .obj
 *   separate FOLDER quick      the same with few tets, for sanitizers
 *   separate FOLDER APART      what the command line made of the two, compared bit by bit */
#include "answers.h"
#include "shapes.h"

typedef struct {
    MlgTriMesh *surface;
    MlgTetMesh *tets;
} Ball;

/* A ball of radius 1 around (x, 0, 0), its surface inside lattice tets. */
static Ball ball(double x, uint32_t tet_count) {
    double points[3 * POINTS];
    uint32_t triangles[3 * TRIANGLES];
    MlgTetrahedralizationOptions options;
    MlgTetrahedralization *made = NULL;
    Ball ball = {NULL, NULL};
    const double *corners;
    const uint32_t *tets;
    size_t i, corner_count, count;
    make_sphere(points, triangles);
    for (i = 0; i < POINTS; i++) points[3 * i] += x;
    check(mlg_tri_mesh_new(points, POINTS, triangles, TRIANGLES, &ball.surface, &error));
    CHECK(mlg_tetrahedralization_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.method = MLG_TETS_LATTICE;
    options.tet_count = tet_count;
    check(mlg_tetrahedralization_run(ball.surface, &options, &made, &error));
    corners = mlg_tetrahedralization_points(made, &corner_count);
    tets = mlg_tetrahedralization_tets(made, &count);
    check(mlg_tet_mesh_new(corners, corner_count, tets, count, &ball.tets, &error));
    mlg_tetrahedralization_free(made);
    return ball;
}

static void free_ball(Ball ball) {
    mlg_tri_mesh_free(ball.surface);
    mlg_tet_mesh_free(ball.tets);
}

/* Two balls, 0.3 of each inside the other. */
static MlgSeparation *two_balls(uint32_t tet_count) {
    Ball left = ball(0, tet_count), right = ball(1.7, tet_count);
    MlgSeparation *problem = NULL;
    check(mlg_separation_new(&problem, &error));
    check(mlg_separation_add_body(problem, "left", left.tets, left.surface, &error));
    check(mlg_separation_add_body(problem, "right", right.tets, right.surface, &error));
    free_ball(left);
    free_ball(right);
    return problem;
}

static MlgSeparationSummary summary_of(const MlgSeparationResult *result) {
    MlgSeparationSummary summary;
    summary.struct_size = sizeof summary;
    check(mlg_separation_result_summary(result, &summary, &error));
    return summary;
}

static MlgOverlap overlap_of(const MlgSeparationResult *result, size_t number) {
    MlgOverlap overlap;
    overlap.struct_size = sizeof overlap;
    check(mlg_separation_result_overlap(result, number, &overlap, &error));
    return overlap;
}

static MlgSeparatedBody body_of(const MlgSeparationResult *result, size_t number) {
    MlgSeparatedBody body;
    body.struct_size = sizeof body;
    check(mlg_separation_result_body(result, number, &body, &error));
    return body;
}

/* How often a sphere's surface goes around p, by the solid angles of its triangles. */
static double winding(const double *points, const double *p) {
    double unused[3 * POINTS], total = 0;
    uint32_t triangles[3 * TRIANGLES];
    int t, k, c;
    make_sphere(unused, triangles);
    for (t = 0; t < TRIANGLES; t++) {
        double v[3][3], length[3], dot[3], volume;
        for (k = 0; k < 3; k++) {
            for (c = 0; c < 3; c++) v[k][c] = points[3 * triangles[3 * t + k] + (uint32_t)c] - p[c];
            length[k] = sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
        }
        for (k = 0; k < 3; k++)
            for (dot[k] = 0, c = 0; c < 3; c++) dot[k] += v[k][c] * v[(k + 1) % 3][c];
        volume = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                 v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                 v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        total += 2 * atan2(volume, length[0] * length[1] * length[2] + dot[0] * length[2] +
                                       dot[1] * length[0] + dot[2] * length[1]);
    }
    return total / (4 * 3.14159265358979323846);
}

static size_t inside(const double *points, const double *of) {
    size_t i, count = 0;
    for (i = 0; i < POINTS; i++) count += fabs(winding(of, points + 3 * i)) > 0.5;
    return count;
}

static void balls_part(uint32_t tet_count) {
    MlgSeparation *problem = two_balls(tet_count);
    MlgSeparationResult *one = NULL, *two = NULL;
    MlgSeparationOptions options;
    MlgSeparationSummary summary;
    MlgOverlap overlap;
    double before[3 * POINTS], shifted[3 * POINTS];
    uint32_t triangles[3 * TRIANGLES];
    const double *left, *right;
    size_t i, count = 0, more = 0;
    CHECK(mlg_separation_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.rings = 2;
    options.thread_count = 1;
    check(mlg_separation_run(problem, &options, &one, &error));
    options.thread_count = 2;
    check(mlg_separation_run(problem, &options, &two, &error));
    mlg_separation_free(problem);
    left = mlg_separation_result_points(one, 0, &count);
    right = mlg_separation_result_points(one, 1, &more);
    CHECK(count == POINTS && more == POINTS && mlg_separation_result_points(one, 2, NULL) == NULL);
    CHECK(memcmp(left, mlg_separation_result_points(two, 0, NULL), 3 * count * sizeof *left) == 0);
    CHECK(memcmp(right, mlg_separation_result_points(two, 1, NULL), 3 * count * sizeof *left) == 0);

    summary = summary_of(one);
    CHECK(summary.separated == 1 && summary.ending == MLG_ENDING_PARTED && summary.rounds > 0);
    CHECK(summary.overlap_count == 1);
    overlap = overlap_of(one, 0);
    printf("balls: %.3f deep, %u crossings, parted after %u rounds, %.2f s\n", overlap.depth[0],
           (unsigned)overlap.crossings[0], (unsigned)summary.rounds, summary.seconds);
    CHECK(overlap.first == 0 && overlap.second == 1 && overlap.depth[0] > 0.2 && overlap.depth[0] < 0.31);
    CHECK(overlap.vertices_inside[0] > 0 && overlap.crossings[0] > 0);
    CHECK(overlap.depth[1] == 0 && overlap.vertices_inside[1] == 0 && overlap.crossings[1] == 0);

    /* The same by other means. */
    make_sphere(before, triangles);
    for (i = 0; i < 3 * POINTS; i++) shifted[i] = before[i] + (i % 3 == 0 ? 1.7 : 0);
    CHECK(inside(before, shifted) > 0 && inside(left, right) == 0 && inside(right, left) == 0);
    for (i = 0; i < 2; i++) {
        const MlgSeparatedBody body = body_of(one, i);
        CHECK(body.inverted_tets == 0 && body.moved_vertices > 0 && body.moved_vertices < POINTS);
        CHECK(body.largest_move > 0.08 && body.largest_move < 0.3 && isnan(body.mean_marker_distance[0]));
    }
    CHECK(mlg_separation_result_tet_points(one, 1, &count) != NULL && count > 8);
    expect(mlg_separation_result_overlap(one, 1, &overlap, &error), MLG_STATUS_INVALID_ARGUMENT,
           "overlap 1 does not exist");
    mlg_separation_result_free(two);
    mlg_separation_result_free(one);
    expect(mlg_separation_result_summary(one, &summary, &error), MLG_STATUS_INVALID_ARGUMENT, "freed");
}

/* A sphere reshaped to an ellipsoid whose end, at x = 1.5, is inside a bone that reaches to 1.3. */
static void a_result_leaves_a_bone(uint32_t tet_count) {
    double points[3 * POINTS], bone_points[3 * POINTS];
    uint32_t triangles[3 * TRIANGLES];
    MlgReshaping *reshaping = sphere_problem(points, tet_count);
    MlgReshapingResult *reshaped = NULL;
    MlgTriMesh *bone = NULL;
    MlgSeparation *problem = NULL;
    MlgSeparationResult *result = NULL;
    MlgSeparatedBody body;
    MlgOverlap overlap;
    const double *moved;
    size_t i;
    check(mlg_reshaping_run(reshaping, NULL, &reshaped, &error));
    make_sphere(bone_points, triangles);
    for (i = 0; i < POINTS; i++) bone_points[3 * i] += 2.3;
    check(mlg_tri_mesh_new(bone_points, POINTS, triangles, TRIANGLES, &bone, &error));
    check(mlg_separation_new(&problem, &error));
    check(mlg_separation_add_result(problem, "muscle", reshaped, &error));
    check(mlg_separation_add_obstacle(problem, "bone", bone, &error));
    CHECK(inside(mlg_reshaping_result_points(reshaped, NULL), bone_points) > 0);
    mlg_reshaping_result_free(reshaped);
    mlg_reshaping_free(reshaping);
    mlg_tri_mesh_free(bone);
    check(mlg_separation_run(problem, NULL, &result, &error));
    mlg_separation_free(problem);
    moved = mlg_separation_result_points(result, 0, NULL);
    overlap = overlap_of(result, 0);
    body = body_of(result, 0);
    printf("bone: %.3f deep, markers %.4f before, %.4f after, %u inside it\n", overlap.depth[0],
           body.mean_marker_distance[0], body.mean_marker_distance[1],
           (unsigned)body.markers_inside_obstacles);
    CHECK(summary_of(result).separated == 1 && overlap.second == 1 && overlap.depth[0] > 0.1);
    CHECK(inside(moved, bone_points) == 0 && inside(bone_points, moved) == 0);
    CHECK(body.inverted_tets == 0 && body.largest_move > 0.1 && body.markers_inside_obstacles > 0);
    CHECK(body.mean_marker_distance[0] < 0.02 && body.mean_marker_distance[1] < 0.1);
    mlg_separation_result_free(result);
}

static void runs(int times, uint32_t tet_count) {
    MlgSeparation *problem = two_balls(tet_count);
    double preview[6 * POINTS];
    int i, cancelled = 0, previews = 0;
    for (i = 0; i < times; i++) {
        MlgRun *run = NULL, *freed = NULL;
        MlgSeparationResult *result = NULL;
        MlgReshapingResult *wrong = NULL;
        MlgProgress progress;
        MlgStatus status;
        size_t count = 0;
        progress.struct_size = sizeof progress;
        check(mlg_separation_start(problem, NULL, &run, &error));
        check(mlg_separation_start(problem, NULL, &freed, &error));
        mlg_run_free(freed); /* while it runs */
        do {
            check(mlg_run_poll(run, &progress, &error));
            check(mlg_run_preview_points(run, preview, 2 * POINTS, &count, &error));
            CHECK(count == 0 || count == 2 * POINTS);
            previews += count > 0;
        } while (progress.iteration < (uint32_t)i && progress.state == MLG_RUN_RUNNING);
        mlg_run_cancel(run);
        expect(mlg_run_wait_reshaping(run, &wrong, &error), MLG_STATUS_INVALID_ARGUMENT, "a separation");
        status = mlg_run_wait_separation(run, &result, &error);
        CHECK(status == MLG_STATUS_OK || (status == MLG_STATUS_CANCELLED && i == 0));
        if (status == MLG_STATUS_OK) {
            const MlgSeparationSummary summary = summary_of(result);
            const MlgOverlap overlap = overlap_of(result, 0);
            cancelled += summary.ending == MLG_ENDING_CANCELLED;
            CHECK((summary.separated == 1) == (overlap.crossings[1] + overlap.vertices_inside[1] == 0));
            CHECK(overlap.depth[1] <= overlap.depth[0] && body_of(result, 0).inverted_tets == 0);
            CHECK(mlg_run_wait_separation(run, &result, &error) == MLG_STATUS_INVALID_ARGUMENT);
        }
        mlg_separation_result_free(result);
        mlg_run_free(run);
    }
    printf("%d of %d cancelled runs kept their best shape\n", cancelled, times);
    CHECK(cancelled > 0 && previews > 0);
    mlg_separation_free(problem);
}

static void mistakes(void) {
    MlgSeparation *problem = NULL;
    MlgSeparationResult *result = NULL;
    MlgRun *run = NULL;
    MlgSeparationOptions options;
    Ball one = ball(0, 300);
    const double place[] = {0, 0, NAN};
    expect(mlg_separation_new(NULL, &error), MLG_STATUS_NULL_ARGUMENT, "out_problem");
    check(mlg_separation_new(&problem, &error));
    expect(mlg_separation_run(problem, NULL, &result, &error), MLG_STATUS_INVALID_ARGUMENT,
           "nothing to separate");
    expect(mlg_separation_add_body(problem, NULL, one.tets, NULL, &error), MLG_STATUS_NULL_ARGUMENT, "name");
    expect(mlg_separation_add_body(problem, "a", NULL, NULL, &error), MLG_STATUS_NULL_ARGUMENT, "tets");
    expect(mlg_separation_add_body(problem, "a", (const MlgTetMesh *)one.surface, NULL, &error),
           MLG_STATUS_INVALID_ARGUMENT, "tets");
    check(mlg_separation_add_body(problem, "a", one.tets, NULL, &error));
    expect(mlg_separation_add_obstacle(problem, "a", one.surface, &error), MLG_STATUS_INVALID_ARGUMENT,
           "'a' already");
    expect(mlg_separation_add_body(problem, "a", one.tets, one.surface, &error),
           MLG_STATUS_INVALID_ARGUMENT, "'a' already");
    expect(mlg_separation_add_result(problem, "b", NULL, &error), MLG_STATUS_NULL_ARGUMENT, "result");
    expect(mlg_separation_set_markers(problem, 1, place, 0, &error), MLG_STATUS_INVALID_ARGUMENT,
           "body 1 does not exist");
    expect(mlg_separation_set_markers(problem, 0, place, 1, &error), MLG_STATUS_INVALID_ARGUMENT,
           "point 0");
    CHECK(mlg_separation_options_init(&options, sizeof options + 8) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_separation_options_init(&options, sizeof options) == MLG_STATUS_OK);
    CHECK(options.rings == 5 && options.gap == 0);
    options.rings = 0;
    expect(mlg_separation_start(problem, &options, &run, &error), MLG_STATUS_INVALID_ARGUMENT, "ring");
    options.rings = 5;
    options.gap = -1;
    expect(mlg_separation_start(problem, &options, &run, &error), MLG_STATUS_INVALID_ARGUMENT, "gap");
    options.gap = NAN;
    expect(mlg_separation_run(problem, &options, &result, &error), MLG_STATUS_INVALID_ARGUMENT, "gap");
    CHECK(run == NULL && result == NULL);
    /* A body by itself is apart already, and stays bit by bit. */
    check(mlg_separation_run(problem, NULL, &result, &error));
    CHECK(summary_of(result).separated == 1 && summary_of(result).overlap_count == 0);
    CHECK(body_of(result, 0).moved_vertices == 0);
    mlg_separation_result_free(result);
    free_ball(one);
    mlg_separation_free(problem);
    mlg_separation_free(problem);
    expect(mlg_separation_run(problem, NULL, &result, &error), MLG_STATUS_INVALID_ARGUMENT, "freed");
}

static char *in(const char *folder, const char *name) {
    static char path[500];
    sprintf(path, "%s/%s", folder, name);
    return path;
}

/* The same two bodies through files, as the command line has them. */
static void files(const char *folder, const char *apart) {
    static const char *const names[] = {"left.vtu", "right.vtu"};
    static const char *const surfaces[] = {"left.obj", "right.obj"};
    MlgSeparation *problem = NULL;
    MlgSeparationResult *result = NULL;
    size_t b, count = 0, more = 0;
    check(mlg_separation_new(&problem, &error));
    for (b = 0; b < 2; b++) {
        MlgTetMesh *tets = NULL;
        MlgTriMesh *surface = NULL;
        check(mlg_tet_mesh_load(in(folder, names[b]), &tets, &error));
        check(mlg_tri_mesh_load(in(folder, surfaces[b]), &surface, &error));
        check(mlg_separation_add_body(problem, names[b], tets, surface, &error));
        mlg_tri_mesh_free(surface);
        mlg_tet_mesh_free(tets);
    }
    check(mlg_separation_run(problem, NULL, &result, &error));
    for (b = 0; b < 2; b++) {
        MlgTetMesh *tets = NULL;
        const double *own = mlg_separation_result_tet_points(result, b, &count), *theirs;
        check(mlg_tet_mesh_load(in(apart, names[b]), &tets, &error));
        theirs = mlg_tet_mesh_points(tets, &more);
        CHECK(count == more && memcmp(own, theirs, 3 * count * sizeof *own) == 0);
        mlg_tet_mesh_free(tets);
    }
    CHECK(overlap_of(result, 0).depth[0] > 0.1 && summary_of(result).separated == 1);
    mlg_separation_result_free(result);
    mlg_separation_free(problem);
}

int main(int argc, char **argv) {
    const int quick = argc > 2 && strcmp(argv[2], "quick") == 0;
    const uint32_t tet_count = quick ? 600 : 2000;
    CHECK(argc > 1);
    if (argc > 2 && !quick) {
        files(argv[1], argv[2]);
    } else {
        Ball left = ball(0, tet_count), right = ball(1.7, tet_count);
        check(mlg_tet_mesh_save(left.tets, in(argv[1], "left.vtu"), &error));
        check(mlg_tet_mesh_save(right.tets, in(argv[1], "right.vtu"), &error));
        check(mlg_tri_mesh_save(left.surface, NULL, 0, in(argv[1], "left.obj"), &error));
        check(mlg_tri_mesh_save(right.surface, NULL, 0, in(argv[1], "right.obj"), &error));
        free_ball(left);
        free_ball(right);
        mistakes();
        balls_part(tet_count);
        a_result_leaves_a_bone(tet_count);
        runs(quick ? 4 : 8, tet_count);
    }
    puts("separate: good");
    return 0;
}
