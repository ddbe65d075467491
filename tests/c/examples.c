/* Does from C what the command line does with the examples, and writes the same files.
 *   examples EXAMPLES OUT */
#include "answers.h"

static const char *in(const char *folder, const char *name) {
    static char path[4][500];
    static int next;
    next = (next + 1) % 4;
    sprintf(path[next], "%s/%s", folder, name);
    return path[next];
}

/* moulage reshape EXAMPLES/liver/job.toml --tolerance 3 -o OUT/liver.obj */
static void liver(const char *examples, const char *out) {
    MlgTriMesh *surface = NULL;
    MlgMarkers *markers = NULL;
    MlgPairs *landmarks = NULL;
    MlgTetrahedralization *tets = NULL;
    MlgReshaping *problem = NULL;
    MlgReshapingOptions options;
    MlgReshapingResult *result = NULL;
    const double *points;
    size_t count = 0;
    check(mlg_tri_mesh_load(in(examples, "liver/template.obj"), &surface, &error));
    check(mlg_markers_load(in(examples, "liver/markers.csv"), &markers, &error));
    check(mlg_pairs_load_landmarks(surface, in(examples, "liver/landmarks.csv"), NULL, &landmarks, &error));
    check(mlg_tetrahedralization_run(surface, NULL, &tets, &error));
    check(mlg_reshaping_new(tets, &problem, &error));
    mlg_markers_points(markers, &count);
    check(mlg_reshaping_set_markers(problem, mlg_markers_points(markers, NULL),
                                    mlg_markers_weights(markers, NULL), count, &error));
    check(mlg_reshaping_set_landmark_pairs(problem, landmarks, &error));
    check(mlg_reshaping_options_init(&options, sizeof options));
    options.tolerance = 3; /* soon ended */
    options.landmark_tolerance = 15;
    check(mlg_reshaping_run(problem, &options, &result, &error));
    points = mlg_reshaping_result_points(result, &count);
    check(mlg_tri_mesh_save(surface, points, count, in(out, "liver.obj"), &error));
    check(mlg_reshaping_result_save_tets(result, in(out, "liver.vtu"), &error));
    mlg_reshaping_result_free(result);
    mlg_reshaping_free(problem);
    mlg_tetrahedralization_free(tets);
    mlg_pairs_free(landmarks);
    mlg_markers_free(markers);
    mlg_tri_mesh_free(surface);
}

/* moulage register EXAMPLES/hand/skeleton.json --target EXAMPLES/hand/target_surface.ply -o OUT/hand */
static void hand(const char *examples, const char *out) {
    MlgSkeleton *skeleton = NULL, *person = NULL;
    MlgTriMesh *target = NULL;
    MlgRegistration *problem = NULL;
    MlgRegistrationResult *result = NULL;
    check(mlg_skeleton_load(in(examples, "hand/skeleton.json"), &skeleton, &error));
    check(mlg_tri_mesh_load(in(examples, "hand/target_surface.ply"), &target, &error));
    check(mlg_registration_new(skeleton, &problem, &error));
    check(mlg_registration_set_target(problem, target, &error));
    check(mlg_registration_run(problem, NULL, &result, &error));
    check(mlg_registration_result_skeleton(result, &person, &error));
    check(mlg_skeleton_save(person, in(out, "hand/result.skeleton.json"), &error));
    mlg_skeleton_free(person);
    mlg_registration_result_free(result);
    mlg_registration_free(problem);
    mlg_tri_mesh_free(target);
    mlg_skeleton_free(skeleton);
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    liver(argv[1], argv[2]);
    hand(argv[1], argv[2]);
    return 0;
}
