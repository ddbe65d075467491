/* Skeletons and their registration: a known answer, files, poll, cancel, mistakes. */
#include "shapes.h"

static MlgError error;

#define SIDE 9
#define BLOCK_POINTS (6 * SIDE * SIDE)
#define BLOCK_TRIANGLES (12 * (SIDE - 1) * (SIDE - 1))

/* A box around (x, 0, 0) whose faces are grids. */
static void make_block(double x, const double *half, double *points, uint32_t *triangles) {
    uint32_t face, i, j, first = 0;
    for (face = 0; face < 6; face++, first += SIDE * SIDE) {
        const uint32_t axis = face / 2;
        const double side = face % 2 ? -1 : 1;
        for (i = 0; i < SIDE; i++)
            for (j = 0; j < SIDE; j++, points += 3) {
                points[axis] = side * half[axis];
                points[(axis + 1) % 3] = side * (2.0 * i / (SIDE - 1) - 1) * half[(axis + 1) % 3];
                points[(axis + 2) % 3] = (2.0 * j / (SIDE - 1) - 1) * half[(axis + 2) % 3];
                points[0] += x;
            }
        for (i = 0; i + 1 < SIDE; i++)
            for (j = 0; j + 1 < SIDE; j++) {
                const uint32_t a = first + i * SIDE + j;
                *triangles++ = a, *triangles++ = a + SIDE, *triangles++ = a + SIDE + 1;
                *triangles++ = a, *triangles++ = a + SIDE + 1, *triangles++ = a + 1;
            }
    }
}

static const double LONG[] = {10, 2, 3}, SHORT[] = {7, 1.5, 2.5};
static double points[6 * BLOCK_POINTS];
static uint32_t triangles[6 * BLOCK_TRIANGLES];

static MlgTriMesh *block(double x, const double *half) {
    MlgTriMesh *mesh = NULL;
    make_block(x, half, points, triangles);
    CHECK(mlg_tri_mesh_new(points, BLOCK_POINTS, triangles, BLOCK_TRIANGLES, &mesh, &error) == MLG_STATUS_OK);
    return mesh;
}

/* Both bones 1.2 times as long and moved: a surface without a hint where one bone ends. */
static void target_point(const double *from, double *to) {
    to[0] = 1.2 * from[0] + 3, to[1] = from[1] - 2, to[2] = from[2] + 1;
}

static MlgTriMesh *target(void) {
    MlgTriMesh *mesh = NULL;
    size_t i;
    make_block(0, LONG, points, triangles);
    make_block(18, SHORT, points + 3 * BLOCK_POINTS, triangles + 3 * BLOCK_TRIANGLES);
    for (i = 0; i < 3 * BLOCK_TRIANGLES; i++) triangles[3 * BLOCK_TRIANGLES + i] += BLOCK_POINTS;
    for (i = 0; i < 2 * BLOCK_POINTS; i++) target_point(points + 3 * i, points + 3 * i);
    CHECK(mlg_tri_mesh_new(points, 2 * BLOCK_POINTS, triangles, 2 * BLOCK_TRIANGLES, &mesh, &error) == MLG_STATUS_OK);
    return mesh;
}

static MlgSkeleton *two_bones(void) {
    MlgTriMesh *meshes[2];
    MlgBone bones[2];
    MlgJoint joint;
    MlgSkeleton *skeleton = NULL;
    meshes[0] = block(0, LONG);
    meshes[1] = block(18, SHORT);
    bones[0].struct_size = bones[1].struct_size = sizeof *bones;
    bones[0].name = "thigh", bones[0].surface = meshes[0];
    bones[1].name = "shank", bones[1].surface = meshes[1];
    CHECK(mlg_joint_init(&joint, sizeof joint) == MLG_STATUS_OK);
    joint.name = "knee", joint.child = 1;
    joint.negative_limits[0] = joint.positive_limits[0] = 0.3;
    joint.negative_limits[1] = joint.positive_limits[1] = 0.1;
    joint.negative_limits[2] = 0.2, joint.positive_limits[2] = 1.2;
    CHECK(mlg_skeleton_new(bones, 2, &joint, 1, &skeleton, &error) == MLG_STATUS_OK);

    /* Mistakes. */
    joint.child = 2;
    CHECK(mlg_skeleton_new(bones, 2, &joint, 1, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "joint knee: there is no bone 2") != NULL);
    joint.child = 1, joint.has_frames = 1, joint.world_from_child_frame[0] = 2;
    CHECK(mlg_skeleton_new(bones, 2, &joint, 1, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "without scale") != NULL);
    joint.has_frames = 0, joint.negative_limits[0] = NAN;
    CHECK(mlg_skeleton_new(bones, 2, &joint, 1, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    joint.name = NULL;
    CHECK(mlg_skeleton_new(bones, 2, &joint, 1, &skeleton, &error) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_skeleton_new(bones, 0, NULL, 0, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    bones[1].name = "thigh";
    CHECK(mlg_skeleton_new(bones, 2, NULL, 0, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    bones[1].struct_size += 8;
    CHECK(mlg_skeleton_new(bones, 2, NULL, 0, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    mlg_tri_mesh_free(meshes[0]);
    CHECK(mlg_skeleton_new(bones, 1, NULL, 0, &skeleton, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "freed already") != NULL);
    mlg_tri_mesh_free(meshes[1]);
    return skeleton;
}

static void files(const MlgSkeleton *skeleton, const char *folder) {
    char path[300];
    MlgSkeleton *again = NULL;
    MlgJoint own, read;
    size_t count = 0, k;
    sprintf(path, "%s/two.skeleton.json", folder);
    CHECK(mlg_skeleton_save(skeleton, path, &error) == MLG_STATUS_OK);
    CHECK(mlg_skeleton_load(path, &again, &error) == MLG_STATUS_OK);
    CHECK(mlg_skeleton_bone_count(again) == 2 && mlg_skeleton_joint_count(again) == 1);
    CHECK(strcmp(mlg_skeleton_bone_name(again, 1), "shank") == 0 && mlg_skeleton_bone_name(again, 2) == NULL);
    CHECK(memcmp(mlg_skeleton_bone_points(again, 1, &count), mlg_skeleton_bone_points(skeleton, 1, NULL), 24 * BLOCK_POINTS) == 0);
    CHECK(count == BLOCK_POINTS && mlg_skeleton_bone_triangles(again, 1, &count)[0] == 0 && count == BLOCK_TRIANGLES);
    own.struct_size = read.struct_size = sizeof own;
    CHECK(mlg_skeleton_joint(skeleton, 0, &own, &error) == MLG_STATUS_OK);
    CHECK(mlg_skeleton_joint(again, 0, &read, &error) == MLG_STATUS_OK);
    for (k = 0; k < 16; k++) CHECK(fabs(own.world_from_child_frame[k] - read.world_from_child_frame[k]) < 1e-12);
    CHECK(fabs(own.world_from_parent_frame[3] - 10.5) < 0.6 && strcmp(read.name, "knee") == 0);
    CHECK(fabs(read.positive_limits[2] - 1.2) < 1e-12 && read.shift_limit > 0);
    CHECK(mlg_skeleton_joint(again, 1, &read, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strcmp(mlg_skeleton_notes(again), "") == 0 && mlg_skeleton_angles(again, NULL) == NULL);
    sprintf(path, "%s/two.glb", folder);
    CHECK(mlg_skeleton_save(again, path, &error) == MLG_STATUS_OK);
    CHECK(mlg_skeleton_save(again, "two.stl", &error) == MLG_STATUS_UNSUPPORTED);
    mlg_skeleton_free(again);
    CHECK(mlg_skeleton_load("no such.skeleton.json", &again, &error) == MLG_STATUS_IO);
}

static MlgRegistrationSummary summary_of(const MlgRegistrationResult *result) {
    MlgRegistrationSummary summary;
    summary.struct_size = sizeof summary;
    CHECK(mlg_registration_result_summary(result, &summary, &error) == MLG_STATUS_OK);
    return summary;
}

static void known_answer(MlgRegistration *problem, const MlgSkeleton *template_skeleton) {
    MlgRegistrationOptions options;
    MlgRegistrationResult *one = NULL, *two = NULL;
    MlgSkeleton *person = NULL;
    MlgRegistrationSummary summary;
    MlgJointPose pose;
    MlgBoneFit fit;
    MlgTriMesh *skin = block(0, LONG);
    double carried[3 * BLOCK_POINTS], wanted[3], worst = 0;
    const double *before, *after;
    char text[200];
    size_t i, k, count = 0, length = 1;
    CHECK(mlg_registration_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.align = 0;
    options.thread_count = 1;
    CHECK(mlg_registration_run(problem, &options, &one, &error) == MLG_STATUS_OK);
    options.thread_count = 2;
    CHECK(mlg_registration_run(problem, &options, &two, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_result_skeleton(two, &person, &error) == MLG_STATUS_OK);
    mlg_registration_result_free(two);
    before = mlg_skeleton_points(person, NULL);
    CHECK(mlg_registration_result_skeleton(one, &person, &error) == MLG_STATUS_OK);
    after = mlg_skeleton_points(person, &count);
    CHECK(count == 2 * BLOCK_POINTS && memcmp(before, after, 3 * count * sizeof *after) == 0);

    before = mlg_skeleton_points(template_skeleton, NULL);
    for (i = 0; i < count; i++) {
        target_point(before + 3 * i, wanted);
        for (k = 0; k < 3; k++) worst = fmax(worst, fabs(after[3 * i + k] - wanted[k]));
    }
    summary = summary_of(one);
    printf("worst %.4f, residual %.4f, %u iterations, %.2f s\n", worst, summary.mean_residual,
           (unsigned)summary.iterations, summary.seconds);
    CHECK(worst < 0.5 && summary.mean_residual < 0.05 && summary.cancelled == 0);
    pose.struct_size = sizeof pose, fit.struct_size = sizeof fit;
    CHECK(mlg_registration_result_joint_pose(one, 0, &pose, &error) == MLG_STATUS_OK && pose.usage <= 1.001);
    CHECK(mlg_registration_result_bone_fit(one, 1, &fit, &error) == MLG_STATUS_OK && fit.seen > 0.5);
    CHECK(mlg_registration_result_bone_fit(one, 2, &fit, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_registration_result_seen(one, &length) != NULL && length == count);
    CHECK(mlg_registration_result_seen(NULL, &length) == NULL && length == 0);
    CHECK(mlg_registration_result_warnings(one, text, sizeof text, &length, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_result_carry(one, skin, carried, &error) == MLG_STATUS_OK);
    CHECK(fabs(carried[0] - after[0]) < 1);
    mlg_tri_mesh_free(skin);
    mlg_skeleton_free(person);
    mlg_registration_result_free(one);
    CHECK(mlg_registration_result_summary(one, &summary, &error) == MLG_STATUS_INVALID_ARGUMENT);
}

static void runs(const MlgRegistration *problem, int times) {
    double *preview = malloc(6 * BLOCK_POINTS * sizeof *preview);
    int i;
    CHECK(preview != NULL);
    for (i = 0; i < times; i++) {
        MlgRun *run = NULL;
        MlgRegistrationResult *result = NULL;
        MlgReshapingResult *wrong = NULL;
        MlgProgress progress;
        size_t count = 0;
        long wait = 0;
        progress.struct_size = sizeof progress;
        CHECK(mlg_registration_start(problem, NULL, &run, &error) == MLG_STATUS_OK);
        do {
            CHECK(mlg_run_poll(run, &progress, &error) == MLG_STATUS_OK);
            CHECK(mlg_run_preview_points(run, preview, 2 * BLOCK_POINTS, &count, &error) == MLG_STATUS_OK);
            CHECK(count == 0 || count == 2 * BLOCK_POINTS);
        } while (wait++ < 200L * i && progress.state == MLG_RUN_RUNNING);
        mlg_run_cancel(run);
        CHECK(mlg_run_wait_reshaping(run, &wrong, &error) == MLG_STATUS_INVALID_ARGUMENT);
        CHECK(mlg_run_wait_registration(run, &result, &error) == MLG_STATUS_OK);
        CHECK(summary_of(result).cancelled == 1 || progress.fraction > 0.1);
        mlg_registration_result_free(result);
        mlg_run_free(run);
    }
    free(preview);
}

int main(int argc, char **argv) {
    MlgSkeleton *skeleton = two_bones();
    MlgTriMesh *whole = target(), *one_bone = block(3, LONG), *cloud = NULL;
    MlgRegistration *problem = NULL;
    MlgRegistrationOptions options;
    MlgRegistrationResult *result = NULL;
    const double radii[] = {INFINITY, -3};
    CHECK(argc > 1);
    files(skeleton, argv[1]);
    CHECK(mlg_registration_new(skeleton, &problem, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_run(problem, NULL, &result, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "has no target") != NULL);
    CHECK(mlg_registration_set_bone_target(problem, 7, one_bone, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_registration_set_bone_target(problem, 0, one_bone, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.align = 2;
    CHECK(mlg_registration_run(problem, &options, &result, &error) == MLG_STATUS_INVALID_ARGUMENT);
    options.align = 0;
    options.radii = radii, options.radius_count = 2;
    CHECK(mlg_registration_run(problem, &options, &result, &error) == MLG_STATUS_INVALID_ARGUMENT);
    options.radius_count = 0;
    CHECK(mlg_registration_run(problem, &options, &result, &error) == MLG_STATUS_OK);
    mlg_registration_result_free(result);
    CHECK(mlg_tri_mesh_new(points, BLOCK_POINTS, NULL, 0, &cloud, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_set_target(problem, cloud, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_registration_set_target(problem, whole, &error) == MLG_STATUS_OK);
    mlg_tri_mesh_free(whole);
    mlg_tri_mesh_free(cloud);
    mlg_tri_mesh_free(one_bone);
    known_answer(problem, skeleton);
    mlg_skeleton_free(skeleton);
    runs(problem, argc > 2 ? 2 : 12);
    mlg_registration_free(problem);
    CHECK(mlg_registration_run(problem, NULL, &result, &error) == MLG_STATUS_INVALID_ARGUMENT);
    puts("register: good");
    return 0;
}
