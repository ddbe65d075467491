/* Inputs from arrays and files: markers, pairs, fixed points, placing, distances, tets. */
#include "shapes.h"

static MlgError error;

static void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    CHECK(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void marker_files(const char *folder) {
    const double points[] = {1, 2, 3, 4, 5, 6}, weights[] = {0.5, 2};
    const char *labels[] = {"tip", NULL};
    MlgMarkers *made = NULL, *read = NULL;
    char path[300];
    size_t count = 0;
    sprintf(path, "%s/a.mrk.json", folder);
    CHECK(mlg_markers_new(points, weights, labels, 2, &made, &error) == MLG_STATUS_OK);
    CHECK(mlg_markers_save(made, path, &error) == MLG_STATUS_OK);
    CHECK(mlg_markers_load(path, &read, &error) == MLG_STATUS_OK);
    CHECK(memcmp(mlg_markers_points(read, &count), points, sizeof points) == 0 && count == 2);
    CHECK(strcmp(mlg_markers_label(read, 0), "tip") == 0);
    CHECK(mlg_markers_label(read, 2) == NULL && mlg_markers_label(NULL, 0) == NULL);
    CHECK(memcmp(mlg_markers_weights(made, NULL), weights, sizeof weights) == 0);
    CHECK(mlg_markers_save(made, "a.docx", &error) == MLG_STATUS_UNSUPPORTED);
    CHECK(mlg_markers_new(NULL, NULL, NULL, 1, &read, &error) == MLG_STATUS_NULL_ARGUMENT);
    mlg_markers_free(made);
    mlg_markers_free(read);
}

static void pairs_and_fixed(const char *folder) {
    double points[3 * POINTS], moved[3 * POINTS], matrix[16], turned[3], *p = NULL;
    uint32_t triangles[3 * TRIANGLES], one_triangle[] = {0, 1, 2}, none = MLG_NO_VERTEX;
    char path[300], text[2000];
    MlgTriMesh *mesh = sphere_mesh(points), *bone = NULL, *bone_there = NULL;
    MlgReshaping *problem = sphere_problem(points, 200);
    const double places[15] = {-0.9, 0, 0, 0.9, 0.1, 0, 0, 0.8, 0.3, 0.2, 0, -0.9, 0.1, -0.7, 0.5};
    const char *const names[5] = {"left", "right", NULL, NULL, NULL};
    const uint32_t missing = 4294967295u;
    const double no_pins[2] = {-1, -1};
    MlgReshapingResult *result = NULL;
    int exchanges = 0;
    MlgFindings *findings = NULL;
    MlgFinding finding;
    MlgPairs *pairs = NULL;
    size_t count = 0, length = 0, i;
    make_sphere(points, triangles);

    sprintf(path, "%s/landmarks.csv", folder);
    write_file(path, "label,vertex,template_x,template_y,template_z,target_x,target_y,target_z\n"
                     "top,0,0,0,1,0,0,0.8\nright,999,1,0,0,1.5,0,0\n");
    CHECK(mlg_pairs_load_landmarks(mesh, path, NULL, &pairs, &error) == MLG_STATUS_OK);
    CHECK(mlg_pairs_template_vertices(pairs, &count)[0] == 0 && count == 2);
    CHECK(mlg_pairs_template_vertices(pairs, NULL)[1] == MLG_NO_VERTEX);
    CHECK(mlg_pairs_targets(pairs, NULL)[2] == 0.8 && mlg_pairs_weights(pairs, NULL)[1] == 1);
    CHECK(strcmp(mlg_pairs_label(pairs, 1), "right") == 0 && mlg_pairs_label(pairs, 2) == NULL);
    CHECK(mlg_pairs_warning(pairs) == NULL);
    CHECK(mlg_reshaping_set_landmark_pairs(problem, pairs, &error) == MLG_STATUS_OK);
    mlg_pairs_free(pairs);
    CHECK(mlg_reshaping_set_landmark_pairs(problem, pairs, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_reshaping_check(problem, text, sizeof text, &length, &error) == MLG_STATUS_OK);
    CHECK(length == 0 && text[0] == 0);

    /* Markers in another unit: what mends it is told, row by row. */
    count = ellipsoid_markers(points, moved);
    for (i = 0; i < 3 * count; ++i) moved[i] *= 1000;
    CHECK(mlg_tri_mesh_inspect(mesh, moved, count, NULL, NULL, NULL, 0, &findings, &error) == MLG_STATUS_OK);
    CHECK(mlg_findings_count(findings) == 1);
    finding.struct_size = sizeof finding;
    CHECK(mlg_findings_get(findings, 0, &finding, &error) == MLG_STATUS_OK);
    CHECK(strcmp(mlg_concern_name(finding.concern), "UNIT") == 0);
    CHECK(strcmp(mlg_severity_name(finding.severity), "REFUSED") == 0);
    CHECK(finding.distance > 500 && finding.mended_distance < 500 && finding.has_exchange == 0);
    CHECK(finding.has_motion == 1 && finding.motion[0] == 1000 && finding.motion[15] == 1);
    CHECK(strstr(mlg_findings_text(findings, 0), "metres beside millimetres") != NULL);
    CHECK(mlg_findings_text(findings, 1) == NULL);
    CHECK(mlg_findings_get(findings, 1, &finding, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strcmp(mlg_concern_name(99), "UNKNOWN") == 0 && strcmp(mlg_severity_name(9), "UNKNOWN") == 0);
    mlg_findings_free(findings);
    CHECK(mlg_findings_count(findings) == 0);

    /* Two landmarks with each other's targets are named, and how they are mended. */
    memcpy(moved, places, sizeof places);
    memcpy(moved, places + 3, 3 * sizeof *moved);
    memcpy(moved + 3, places, 3 * sizeof *moved);
    CHECK(mlg_pairs_new(places, moved, NULL, names, 5, &pairs, &error) == MLG_STATUS_OK);
    CHECK(strcmp(mlg_pairs_label(pairs, 0), "left") == 0 && strcmp(mlg_pairs_label(pairs, 2), "2") == 0);
    CHECK(mlg_tri_mesh_inspect(mesh, NULL, 0, pairs, NULL, NULL, 0, &findings, &error) == MLG_STATUS_OK);
    for (i = 0; i < mlg_findings_count(findings); ++i) {
        CHECK(mlg_findings_get(findings, i, &finding, &error) == MLG_STATUS_OK);
        exchanges += finding.concern == MLG_CONCERN_EXCHANGE && finding.has_exchange == 1 &&
                     finding.first == 0 && finding.second == 1 &&
                     strstr(mlg_findings_text(findings, i), "'left' and 'right'") != NULL;
    }
    CHECK(exchanges == 1);
    mlg_findings_free(findings);
    CHECK(mlg_tri_mesh_inspect(mesh, NULL, 0, NULL, pairs, &missing, 1, &findings, &error) == MLG_STATUS_INVALID_ARGUMENT);
    mlg_pairs_free(pairs);

    /* A landmark of a file may be a pin, or be made one. */
    write_file(path, "vertex,target_x,target_y,target_z,within\n0,0,0,1.2,0\n1,0,0,-1,\n");
    CHECK(mlg_pairs_load_landmarks(mesh, path, NULL, &pairs, &error) == MLG_STATUS_OK);
    CHECK(mlg_pairs_within(pairs, &count)[0] == 0 && mlg_pairs_within(pairs, NULL)[1] < 0 && count == 2);
    CHECK(mlg_reshaping_set_landmark_pairs(problem, pairs, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_run(problem, NULL, &result, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_result_landmark_distances(result, NULL)[0] < 0.01);
    mlg_reshaping_result_free(result);
    CHECK(mlg_reshaping_set_pins(problem, no_pins, 2, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_run(problem, NULL, &result, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_result_landmark_distances(result, NULL)[0] > 0.05);
    mlg_reshaping_result_free(result);
    CHECK(mlg_reshaping_set_pins(problem, no_pins, 1, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "1 lengths for 2 landmarks") != NULL);
    mlg_pairs_free(pairs);

    /* The same places with other targets cannot be. */
    write_file(path, "vertex,target_x,target_y,target_z\n0,0,0,0.8\n0,0,1,0\n");
    CHECK(mlg_pairs_load_landmarks(mesh, path, NULL, &pairs, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_set_landmark_pairs(problem, pairs, &error) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_check(problem, NULL, 0, &length, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "same place") != NULL);
    mlg_pairs_free(pairs);
    write_file(path, "vertex,target_x,target_y,target_z\n999,0,0,0.8\n");
    CHECK(mlg_pairs_load_landmarks(mesh, path, NULL, &pairs, &error) == MLG_STATUS_PARSE);
    CHECK(strstr(error.message, "landmarks.csv, line 2: vertex 999") != NULL);

    /* Pairs read for a larger template are not taken over. */
    CHECK(mlg_tri_mesh_new(points, 3, one_triangle, 1, &bone, &error) == MLG_STATUS_OK);
    write_file(path, "vertex,target_x,target_y,target_z\n100,0,0,0.8\n");
    CHECK(mlg_pairs_load_landmarks(bone, path, NULL, &pairs, &error) == MLG_STATUS_PARSE);

    /* A bone near the sphere that moves up by 1. */
    for (i = 0; i < 9; i++) moved[i] = points[i] + (i % 3 == 2 ? 1 : 0);
    CHECK(mlg_tri_mesh_new(moved, 3, one_triangle, 1, &bone_there, &error) == MLG_STATUS_OK);
    CHECK(mlg_pairs_from_bone(mesh, bone, bone_there, 0.1, &pairs, &error) == MLG_STATUS_OK);
    p = (double *)mlg_pairs_template_points(pairs, &count);
    CHECK(count == 3 && fabs(mlg_pairs_targets(pairs, NULL)[2] - p[2] - 1) < 1e-9);
    CHECK(mlg_reshaping_set_attachment_pairs(problem, pairs, &error) == MLG_STATUS_OK);
    mlg_pairs_free(pairs);
    CHECK(mlg_pairs_from_vertices(mesh, one_triangle, 2, bone, bone_there, &pairs, &error) == MLG_STATUS_OK);
    p = (double *)mlg_pairs_template_points(pairs, &count);
    CHECK(count == 2 && fabs(mlg_pairs_targets(pairs, NULL)[5] - p[5] - 1) < 1e-9);
    mlg_pairs_free(pairs);
    CHECK(mlg_pairs_from_vertices(mesh, &none, 1, bone, bone, &pairs, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "vertex 4294967295 does not exist: there are ") != NULL);
    CHECK(mlg_pairs_from_bone(mesh, bone, bone, NAN, &pairs, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_pairs_from_bone(mesh, bone_there, bone, 1e-9, &pairs, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "no vertex of the bone") != NULL);
    mlg_tri_mesh_free(bone_there);

    sprintf(path, "%s/attachments.csv", folder);
    write_file(path, "template_x,template_y,template_z,target_x,target_y,target_z\n0,0,1,0,0,2\n");
    CHECK(mlg_pairs_load_attachments(mesh, path, 1, &pairs, &error) == MLG_STATUS_OK);
    mlg_pairs_free(pairs);
    CHECK(mlg_pairs_load_attachments(mesh, path, 7, &pairs, &error) == MLG_STATUS_INVALID_ARGUMENT);
    write_file(path, "vertex\n5\n6\n");
    CHECK(mlg_reshaping_load_fixed(problem, path, &error) == MLG_STATUS_OK);
    write_file(path, "vertex\nfive\n");
    CHECK(mlg_reshaping_load_fixed(problem, path, &error) == MLG_STATUS_PARSE);

    /* A long box turned and scaled: its landmarks are found again. */
    for (i = 0; i < 12; i += 3) {
        moved[i] = 5 - 2 * points[i + 1];
        moved[i + 1] = 6 + 2 * points[i];
        moved[i + 2] = 7 + 2 * points[i + 2];
    }
    CHECK(mlg_tri_mesh_align(mesh, MLG_ALIGN_SIMILARITY, NULL, 0, points, moved, 4, matrix, &error) == MLG_STATUS_OK);
    for (i = 0; i < 3; i++)
        turned[i] = matrix[4 * i] * points[3] + matrix[4 * i + 1] * points[4] + matrix[4 * i + 2] * points[5] + matrix[4 * i + 3];
    CHECK(fabs(turned[0] - moved[3]) + fabs(turned[1] - moved[4]) + fabs(turned[2] - moved[5]) < 1e-9);
    CHECK(mlg_tri_mesh_align(mesh, 9, points, POINTS, NULL, NULL, 0, matrix, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_tri_mesh_align(mesh, MLG_ALIGN_RIGID, points, 1, NULL, NULL, 0, matrix, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_tri_mesh_align(mesh, MLG_ALIGN_RIGID, points, POINTS, NULL, NULL, 0, NULL, &error) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_points_align(MLG_ALIGN_SIMILARITY, points, moved, 3, matrix, &error) == MLG_STATUS_OK);
    CHECK(fabs(matrix[1] + 2) < 1e-9 && fabs(matrix[11] - 7) < 1e-9 && matrix[15] == 1);
    CHECK(mlg_points_align(MLG_ALIGN_RIGID, points, moved, 0, matrix, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_points_align(9, points, moved, 3, matrix, &error) == MLG_STATUS_INVALID_ARGUMENT);
    mlg_tri_mesh_free(bone);
    mlg_tri_mesh_free(mesh);
    mlg_reshaping_free(problem);
}

static void distances(void) {
    double points[3 * POINTS], to[POINTS], of[2], places[6];
    const double markers[] = {0, 0, 3, 0, 0, -1};
    MlgTriMesh *mesh = sphere_mesh(points), *cloud = NULL;
    CHECK(mlg_tri_mesh_distances_to_points(mesh, markers, 2, to, &error) == MLG_STATUS_OK);
    CHECK(to[0] == 2 && to[POINTS - 1] == 0);
    CHECK(mlg_tri_mesh_distances_of_points(mesh, markers, 2, of, &error) == MLG_STATUS_OK);
    CHECK(of[0] == 2 && of[1] == 0);
    CHECK(mlg_tri_mesh_closest_points(mesh, markers, 2, places, &error) == MLG_STATUS_OK);
    CHECK(places[2] == 1 && places[5] == -1);
    CHECK(mlg_tri_mesh_interpolate(mesh, markers, of, 2, to, &error) == MLG_STATUS_OK);
    CHECK(fabs(to[0] - 1) < 1e-9 && to[POINTS - 1] < 0.1);
    CHECK(mlg_tri_mesh_interpolate(mesh, markers, NULL, 2, to, &error) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_tri_mesh_closest_points(mesh, markers, 2, NULL, &error) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_tri_mesh_distances_to_points(mesh, markers, 0, to, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_tri_mesh_distances_of_points(mesh, markers, 2, NULL, &error) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_tri_mesh_new(points, POINTS, NULL, 0, &cloud, &error) == MLG_STATUS_OK);
    CHECK(mlg_tri_mesh_distances_of_points(cloud, markers, 2, of, &error) == MLG_STATUS_INVALID_ARGUMENT);
    mlg_tri_mesh_free(cloud);
    mlg_tri_mesh_free(mesh);
}

/* Tets by a run, and tets made elsewhere; a run gives only its own kind of result. */
static void tets(void) {
    double points[3 * POINTS], far_away[3 * POINTS];
    MlgTriMesh *mesh = sphere_mesh(points), *other = NULL;
    MlgTetrahedralizationOptions options;
    MlgTetrahedralization *made = NULL, *given = NULL, *cancelled = NULL;
    MlgReshapingResult *wrong = NULL;
    MlgTetMesh *tet_mesh = NULL;
    MlgRun *run = NULL;
    MlgStatus status;
    uint32_t triangles[3 * TRIANGLES];
    size_t point_count = 0, tet_count = 0, i;
    const double *tet_points, *inside;
    CHECK(mlg_tetrahedralization_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.method = MLG_TETS_LATTICE;
    options.tet_count = 300;
    CHECK(mlg_tetrahedralization_start(mesh, &options, &run, &error) == MLG_STATUS_OK);
    CHECK(mlg_run_wait_reshaping(run, &wrong, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "a tetrahedralization") != NULL);
    CHECK(mlg_run_wait_tetrahedralization(run, &made, &error) == MLG_STATUS_OK);
    CHECK(mlg_run_wait_tetrahedralization(run, &given, &error) == MLG_STATUS_INVALID_ARGUMENT);
    mlg_run_free(run);

    tet_points = mlg_tetrahedralization_points(made, &point_count);
    mlg_tetrahedralization_tets(made, &tet_count);
    CHECK(mlg_tet_mesh_new(tet_points, point_count, mlg_tetrahedralization_tets(made, NULL), tet_count, &tet_mesh, &error) == MLG_STATUS_OK);
    CHECK(mlg_tetrahedralization_from_tets(mesh, tet_mesh, &given, &error) == MLG_STATUS_OK);
    inside = mlg_tetrahedralization_inside_fractions(given, &tet_count);
    for (i = 0; i < tet_count; i++) CHECK(inside[i] == 0 || inside[i] == 1);
    for (i = 0; i < 3 * POINTS; i++) far_away[i] = points[i] + 100;
    make_sphere(points, triangles);
    CHECK(mlg_tri_mesh_new(far_away, POINTS, triangles, TRIANGLES, &other, &error) == MLG_STATUS_OK);
    CHECK(mlg_tetrahedralization_from_tets(other, tet_mesh, &made, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "far outside the tets") != NULL);

    options.tet_count = 400000; /* long enough to be cancelled */
    CHECK(mlg_tetrahedralization_start(mesh, &options, &run, &error) == MLG_STATUS_OK);
    mlg_run_cancel(run);
    status = mlg_run_wait_tetrahedralization(run, &cancelled, &error);
    CHECK(status == MLG_STATUS_CANCELLED);
    mlg_run_free(run);
    mlg_tri_mesh_free(mesh);
    mlg_tri_mesh_free(other);
    mlg_tet_mesh_free(tet_mesh);
    mlg_tetrahedralization_free(made);
    mlg_tetrahedralization_free(given);
}

/* inputs FOLDER, an empty folder for files. */
int main(int argc, char **argv) {
    CHECK(argc == 2);
    marker_files(argv[1]);
    pairs_and_fixed(argv[1]);
    distances();
    tets();
    puts("inputs: good");
    return 0;
}
