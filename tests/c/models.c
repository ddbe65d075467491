/* Shape models: learnt from skeletons, saved and read, shapes made from them, a person registered.
 *   models FOLDER */
#include "answers.h"
#include "shapes.h"

#define PERSONS 5
/* Two causes: all bones grow in length (x), or in width (y). */
static const double SIZES[PERSONS][2] = {{0.9, 1}, {1.1, 1.04}, {1, 0.92}, {0.97, 1.09}, {1.05, 0.95}};
static const double NOBODY[2] = {1.06, 1.03};

/* An ellipsoid of three different radii around (x, 0, 0), so that it can be placed in one way only. */
static MlgTriMesh *bone(const double *size, double x) {
    static const double radii[3] = {3, 1.2, 0.8};
    double points[3 * POINTS];
    uint32_t triangles[3 * TRIANGLES];
    MlgTriMesh *mesh = NULL;
    size_t i;
    make_sphere(points, triangles);
    for (i = 0; i < POINTS; i++) {
        points[3 * i] = size[0] * (radii[0] * points[3 * i] + x);
        points[3 * i + 1] *= size[1] * radii[1];
        points[3 * i + 2] *= radii[2];
    }
    check(mlg_tri_mesh_new(points, POINTS, triangles, TRIANGLES, &mesh, &error));
    return mesh;
}

static MlgSkeleton *person(const double *size, const char *first_name) {
    MlgTriMesh *meshes[2];
    MlgBone bones[2];
    MlgJoint joint;
    MlgSkeleton *skeleton = NULL;
    meshes[0] = bone(size, 0);
    meshes[1] = bone(size, 6.5);
    bones[0].struct_size = bones[1].struct_size = sizeof *bones;
    bones[0].name = first_name, bones[0].surface = meshes[0];
    bones[1].name = "shank", bones[1].surface = meshes[1];
    CHECK(mlg_joint_init(&joint, sizeof joint) == MLG_STATUS_OK);
    joint.name = "knee", joint.child = 1;
    check(mlg_skeleton_new(bones, 2, &joint, 1, &skeleton, &error));
    mlg_tri_mesh_free(meshes[0]);
    mlg_tri_mesh_free(meshes[1]);
    return skeleton;
}

/* How long and wide the bones of a shape are, as shares of the template's. */
static void size_of_shape(const MlgShapeModel *model, const double *coefficients, size_t count, double *size) {
    MlgSkeleton *shape = NULL;
    MlgJoint joint;
    const double *points;
    double most[2] = {0, 0}, gap = 0;
    size_t i, k, point_count = 0;
    check(mlg_shape_model_shape(model, coefficients, count, &shape, &error));
    points = mlg_skeleton_bone_points(shape, 0, &point_count);
    CHECK(point_count == POINTS && strcmp(mlg_skeleton_bone_name(shape, 1), "shank") == 0);
    for (i = 0; i < POINTS; i++)
        for (k = 0; k < 2; k++) most[k] = fmax(most[k], fabs(points[3 * i + k]));
    size[0] = most[0] / 3, size[1] = most[1] / 1.2;
    joint.struct_size = sizeof joint;
    check(mlg_skeleton_joint(shape, 0, &joint, &error));
    for (k = 3; k < 12; k += 4) gap += fabs(joint.world_from_parent_frame[k] - joint.world_from_child_frame[k]);
    CHECK(gap < 1e-6); /* the joint is closed */
    mlg_skeleton_free(shape);
}

static MlgShapeModel *learnt(const MlgSkeleton *template_skeleton, const char *folder) {
    MlgSkeleton *samples[PERSONS], *other = person(NOBODY, "hand");
    MlgSkeleton *one_bone = NULL;
    MlgTriMesh *surface = bone(NOBODY, 0);
    MlgBone alone;
    MlgShapeModel *model = NULL, *again = NULL;
    double distances[PERSONS], mean[2], more[2], less[2];
    const double one = 1, minus_one = -1, nan[] = {0, NAN}, many[9] = {0};
    const double *deviations, *explained, *read;
    char path[300];
    size_t i, count = 0, modes = 0;
    alone.struct_size = sizeof alone, alone.name = "thigh", alone.surface = surface;
    check(mlg_skeleton_new(&alone, 1, NULL, 0, &one_bone, &error));
    mlg_tri_mesh_free(surface);
    for (i = 0; i < PERSONS; i++) samples[i] = person(SIZES[i], "thigh");
    expect(mlg_shape_model_fit(template_skeleton, (const MlgSkeleton *const *)samples, 1, &model, &error),
           MLG_STATUS_INVALID_ARGUMENT, "two or more");
    expect(mlg_shape_model_fit(template_skeleton, NULL, 3, &model, &error), MLG_STATUS_NULL_ARGUMENT, "samples");
    expect(mlg_shape_model_fit(NULL, (const MlgSkeleton *const *)samples, 3, &model, &error),
           MLG_STATUS_NULL_ARGUMENT, "template_skeleton");
    expect(mlg_shape_model_fit(other, (const MlgSkeleton *const *)samples, 3, &model, &error),
           MLG_STATUS_INVALID_ARGUMENT, "samples[0] is not of this template");
    expect(mlg_shape_model_left_out(template_skeleton, (const MlgSkeleton *const *)samples, 2, distances, &error),
           MLG_STATUS_INVALID_ARGUMENT, "three or more");
    CHECK(model == NULL);
    check(mlg_shape_model_fit(template_skeleton, (const MlgSkeleton *const *)samples, PERSONS, &model, &error));
    check(mlg_shape_model_left_out(template_skeleton, (const MlgSkeleton *const *)samples, PERSONS, distances, &error));
    deviations = mlg_shape_model_deviations(model, &modes);
    explained = mlg_shape_model_explained(model, &count);
    CHECK(modes == count && modes >= 2 && deviations[0] >= deviations[1]);
    CHECK(explained[1] > 0.999 && fabs(explained[count - 1] - 1) < 1e-12);
    for (i = 0; i < PERSONS; i++) {
        CHECK(distances[i] >= 0 && distances[i] < 0.02);
        mlg_skeleton_free(samples[i]);
    }

    size_of_shape(model, NULL, 0, mean);
    size_of_shape(model, &one, 1, more);
    size_of_shape(model, &minus_one, 1, less);
    printf("mean %.3f x %.3f, first mode to %.3f x %.3f and %.3f x %.3f\n", mean[0], mean[1], more[0],
           more[1], less[0], less[1]);
    CHECK(fabs(mean[0] - 1.004) < 0.01 && fabs(mean[1] - 1) < 0.01);
    CHECK(fabs(more[0] + less[0] - 2 * mean[0]) < 0.01 && fabs(more[0] - less[0]) > 0.05);
    expect(mlg_shape_model_shape(model, many, modes + 1, &other, &error), MLG_STATUS_INVALID_ARGUMENT, "modes");
    expect(mlg_shape_model_shape(model, nan, 2, &other, &error), MLG_STATUS_INVALID_ARGUMENT, "number 1");

    sprintf(path, "%s/bones.h5.json", folder);
    check(mlg_shape_model_save(model, path, &error));
    check(mlg_shape_model_load(template_skeleton, path, &again, &error));
    read = mlg_shape_model_deviations(again, &count);
    CHECK(count >= 2 && fabs(read[0] - deviations[0]) < 1e-4 * deviations[0]);
    mlg_shape_model_free(again);
    expect(mlg_shape_model_load(one_bone, path, &again, &error), MLG_STATUS_PARSE, "another template");
    mlg_skeleton_free(one_bone);
    expect(mlg_shape_model_load(template_skeleton, "no such.h5.json", &again, &error), MLG_STATUS_IO, "no such");
    mlg_skeleton_free(other);
    expect(mlg_shape_model_save((const MlgShapeModel *)template_skeleton, path, &error),
           MLG_STATUS_INVALID_ARGUMENT, "model");
    return model;
}

static double mean_distance(const MlgSkeleton *found, const MlgSkeleton *wanted) {
    const double *a = mlg_skeleton_points(found, NULL), *b = mlg_skeleton_points(wanted, NULL);
    double sum = 0;
    size_t i;
    for (i = 0; i < 2 * POINTS; i++)
        sum += sqrt(pow(a[3 * i] - b[3 * i], 2) + pow(a[3 * i + 1] - b[3 * i + 1], 2) +
                    pow(a[3 * i + 2] - b[3 * i + 2], 2));
    return sum / (2 * POINTS);
}

static void registered(const MlgSkeleton *template_skeleton, const MlgShapeModel *model) {
    MlgSkeleton *wanted = person(NOBODY, "thigh"), *other = person(NOBODY, "hand"), *found = NULL;
    MlgTriMesh *surfaces[2];
    MlgRegistration *problem = NULL, *wrong = NULL;
    MlgRegistrationOptions options;
    MlgRegistrationResult *result = NULL;
    const double *coefficients;
    double size[2];
    size_t b, count = 0;
    check(mlg_registration_new(template_skeleton, &problem, &error));
    for (b = 0; b < 2; b++) {
        surfaces[b] = bone(NOBODY, b == 0 ? 0 : 6.5);
        check(mlg_registration_set_bone_target(problem, b, surfaces[b], &error));
        mlg_tri_mesh_free(surfaces[b]);
    }
    check(mlg_registration_new(other, &wrong, &error));
    expect(mlg_registration_set_shape_model(wrong, model, &error), MLG_STATUS_INVALID_ARGUMENT, "another template");
    mlg_registration_free(wrong);
    CHECK(mlg_registration_options_init(&options, sizeof options) == MLG_STATUS_OK);
    options.align = 0;
    check(mlg_registration_run(problem, &options, &result, &error));
    CHECK(mlg_registration_result_coefficients(result, &count) == NULL && count == 0);
    mlg_registration_result_free(result);
    check(mlg_registration_set_shape_model(problem, model, &error));
    check(mlg_registration_run(problem, &options, &result, &error));
    coefficients = mlg_registration_result_coefficients(result, &count);
    CHECK(coefficients != NULL && count >= 2);
    /* The coefficients alone say how long and wide the person's bones are. */
    size_of_shape(model, coefficients, count, size);
    check(mlg_registration_result_skeleton(result, &found, &error));
    printf("registered: %.3f x %.3f, mean distance %.4f\n", size[0], size[1], mean_distance(found, wanted));
    CHECK(fabs(size[0] - NOBODY[0]) < 0.02 && fabs(size[1] - NOBODY[1]) < 0.02);
    CHECK(mean_distance(found, wanted) < 0.05);
    mlg_registration_result_free(result);
    mlg_skeleton_free(found);
    check(mlg_registration_set_shape_model(problem, NULL, &error));
    check(mlg_registration_run(problem, &options, &result, &error));
    CHECK(mlg_registration_result_coefficients(result, NULL) == NULL);
    mlg_registration_result_free(result);
    mlg_registration_free(problem);
    mlg_skeleton_free(wanted);
    mlg_skeleton_free(other);
}

int main(int argc, char **argv) {
    const double size[2] = {1, 1};
    MlgSkeleton *template_skeleton = person(size, "thigh");
    MlgShapeModel *model;
    CHECK(argc > 1);
    model = learnt(template_skeleton, argv[1]);
    registered(template_skeleton, model);
    mlg_skeleton_free(template_skeleton);
    mlg_shape_model_free(model);
    mlg_shape_model_free(model);
    CHECK(mlg_shape_model_deviations(model, NULL) == NULL);
    puts("models: good");
    return 0;
}
