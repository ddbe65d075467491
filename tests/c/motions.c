/* Motions of a skeleton from arrays and files, and persons written into OpenSim models.
 *   motions EXAMPLES OUT */
#include "answers.h"
#include "shapes.h"

static const char *in(const char *folder, const char *name) {
    static char path[4][500];
    static int next;
    next = (next + 1) % 4;
    sprintf(path[next], "%s/%s", folder, name);
    return path[next];
}

#define ANGLES 3
#define FRAMES 4

/* Leaves walk.mot, walk.bvh and walk.glb; the last two are made from the first, as the command line
 * makes them. */
static void walk(const MlgSkeleton *hand, const char *out) {
    const char *names[ANGLES], *strange[] = {"no such angle"}, *twice[2];
    const double times[FRAMES] = {0, 0.04, 0.08, 0.12}, back[FRAMES] = {0, 1, 0.5, 2};
    const double *read;
    double angles[ANGLES * FRAMES];
    MlgMotion *motion = NULL, *again = NULL;
    size_t k, count = 0;
    for (k = 0; k < ANGLES; k++) {
        names[k] = mlg_skeleton_angle_name(hand, k);
        CHECK(names[k] != NULL);
    }
    for (k = 0; k < ANGLES * FRAMES; k++) angles[k] = 0.3 * sin((double)k);
    check(mlg_motion_new(hand, names, ANGLES, times, angles, FRAMES, &motion, &error));
    CHECK(strcmp(mlg_motion_notes(motion), "") == 0);
    CHECK(strcmp(mlg_motion_angle_name(motion, 2), names[2]) == 0 && mlg_motion_angle_name(motion, ANGLES) == NULL);
    CHECK(memcmp(mlg_motion_angles(motion, &count), angles, sizeof angles) == 0 && count == ANGLES * FRAMES);
    CHECK(memcmp(mlg_motion_times(motion, &count), times, sizeof times) == 0 && count == FRAMES);
    check(mlg_motion_save(motion, in(out, "walk.mot"), &error));
    mlg_motion_free(motion);
    CHECK(mlg_motion_times(motion, NULL) == NULL && mlg_motion_notes(motion) == NULL);

    check(mlg_motion_load(hand, in(out, "walk.mot"), NULL, 0, &motion, &error));
    check(mlg_motion_load(hand, in(out, "walk.mot"), names, 1, &again, &error));
    read = mlg_motion_angles(motion, &count);
    CHECK(count == ANGLES * FRAMES);
    for (k = 0; k < count; k++) {
        const double sign = k % ANGLES == 0 ? -1 : 1;
        CHECK(fabs(read[k] - angles[k]) < 1e-9);
        CHECK(mlg_motion_angles(again, NULL)[k] == sign * read[k]);
    }
    mlg_motion_free(again);
    check(mlg_motion_save(motion, in(out, "walk.bvh"), &error));
    check(mlg_motion_save(motion, in(out, "walk.glb"), &error));
    expect(mlg_motion_save(motion, "walk.txt", &error), MLG_STATUS_UNSUPPORTED, ".bvh");
    check(mlg_motion_load(hand, in(out, "walk.bvh"), NULL, 0, &again, &error));
    CHECK(mlg_motion_times(again, &count) != NULL && count == FRAMES);
    mlg_motion_free(again);
    mlg_motion_free(motion);

    /* Mistakes. */
    motion = NULL;
    expect(mlg_motion_new(hand, NULL, 1, times, angles, FRAMES, &motion, &error), MLG_STATUS_NULL_ARGUMENT, "names");
    expect(mlg_motion_new(hand, names, ANGLES, NULL, angles, 2, &motion, &error), MLG_STATUS_NULL_ARGUMENT, "times");
    expect(mlg_motion_new(hand, names, ANGLES, times, NULL, 2, &motion, &error), MLG_STATUS_NULL_ARGUMENT, "angles");
    expect(mlg_motion_new(hand, names, ANGLES, back, angles, FRAMES, &motion, &error), MLG_STATUS_INVALID_ARGUMENT,
           "number 2");
    expect(mlg_motion_new(hand, names, ANGLES, times, angles, SIZE_MAX, &motion, &error), MLG_STATUS_INVALID_ARGUMENT,
           "memory");
    angles[4] = NAN;
    expect(mlg_motion_new(hand, names, ANGLES, times, angles, FRAMES, &motion, &error), MLG_STATUS_INVALID_ARGUMENT,
           "frame 1");
    twice[0] = twice[1] = names[0];
    expect(mlg_motion_new(hand, twice, 2, times, angles, 2, &motion, &error), MLG_STATUS_INVALID_ARGUMENT, "second");
    expect(mlg_motion_load(hand, "no such.mot", NULL, 0, &motion, &error), MLG_STATUS_IO, "no such");
    expect(mlg_motion_load(hand, in(out, "walk.mot"), strange, 1, &motion, &error), MLG_STATUS_INVALID_ARGUMENT,
           "no such column");
    CHECK(motion == NULL);
    check(mlg_motion_new(hand, strange, 1, times, angles, 2, &motion, &error));
    CHECK(strstr(mlg_motion_notes(motion), "no such angle") != NULL);
    expect(mlg_motion_save(motion, in(out, "strange.bvh"), &error), MLG_STATUS_INVALID_ARGUMENT, "none of");
    mlg_motion_free(motion);
}

static const char MODEL[] =
    "<OpenSimDocument Version=\"40000\"><Model><BodySet><objects>"
    "<Body name=\"a\"><Mesh><mesh_file>bone.obj</mesh_file></Mesh><mass>2</mass></Body>"
    "<Body name=\"b\"><Mesh><mesh_file>bone.obj</mesh_file></Mesh></Body></objects></BodySet>"
    "<JointSet><objects><PinJoint name=\"ab\"><socket_parent_frame>f</socket_parent_frame>"
    "<socket_child_frame>/bodyset/b</socket_child_frame>"
    "<coordinates><Coordinate name=\"bend\"><range>-1 1</range></Coordinate></coordinates>"
    "<frames><PhysicalOffsetFrame name=\"f\"><socket_parent>/bodyset/a</socket_parent>"
    "<translation>2 0 0</translation></PhysicalOffsetFrame></frames></PinJoint>"
    "</objects></JointSet><ForceSet><Strange wish=\"kept\"/></ForceSet></Model></OpenSimDocument>";

static void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

/* The mass of the first body that has one. */
static double first_mass(const char *path) {
    static char text[1 << 14];
    FILE *file = fopen(path, "r");
    const char *mass;
    CHECK(file != NULL);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    mass = strstr(text, "<mass>");
    CHECK(mass != NULL);
    return strtod(mass + strlen("<mass>"), NULL);
}

/* An OpenSim model read as a skeleton and written back. */
static void opensim(const MlgSkeleton *hand, const char *out) {
    MlgSkeleton *arm = NULL, *again = NULL;
    const double *before, *after;
    char notes[16];
    size_t i, count = 0, more = 0, length = 0;
    write_file(in(out, "arm.osim"), MODEL);
    write_file(in(out, "bone.obj"), "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    check(mlg_skeleton_load(in(out, "arm.osim"), &arm, &error));
    check(mlg_skeleton_save_osim(arm, in(out, "arm.osim"), in(out, "person.osim"), notes, sizeof notes, &length, &error));
    CHECK(length > sizeof notes && strlen(notes) == sizeof notes - 1);
    check(mlg_skeleton_save_osim_mass(arm, in(out, "arm.osim"), 70.5, in(out, "heavy.osim"), notes, sizeof notes, &length, &error));
    CHECK(length == 0 && fabs(first_mass(in(out, "heavy.osim")) - 70.5) < 1e-9);
    expect(mlg_skeleton_save_osim_mass(arm, in(out, "arm.osim"), -1, in(out, "no.osim"), NULL, 0, NULL, &error),
           MLG_STATUS_INVALID_ARGUMENT, "mass");
    check(mlg_skeleton_load(in(out, "person.osim"), &again, &error));
    before = mlg_skeleton_points(arm, &count);
    after = mlg_skeleton_points(again, &more);
    CHECK(count == more && count == 8);
    for (i = 0; i < 3 * count; i++) CHECK(fabs(before[i] - after[i]) < 1e-6);
    CHECK(strcmp(mlg_skeleton_angle_name(again, 0), "bend") == 0);
    expect(mlg_skeleton_save_osim(hand, in(out, "arm.osim"), in(out, "no.osim"), NULL, 0, NULL, &error),
           MLG_STATUS_INVALID_ARGUMENT, "bone a is not the one");
    expect(mlg_skeleton_save_osim(arm, NULL, in(out, "no.osim"), NULL, 0, NULL, &error), MLG_STATUS_NULL_ARGUMENT,
           "model_path");
    mlg_skeleton_free(arm);
    mlg_skeleton_free(again);
}

int main(int argc, char **argv) {
    MlgSkeleton *hand = NULL;
    CHECK(argc == 3);
    check(mlg_skeleton_load(in(argv[1], "hand/skeleton.json"), &hand, &error));
    walk(hand, argv[2]);
    opensim(hand, argv[2]);
    mlg_skeleton_free(hand);
    puts("motions: good");
    return 0;
}
