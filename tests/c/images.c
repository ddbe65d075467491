/* Images: one written here, read back, cut, outlined and marked; and what a caller can do wrong. */
#include "answers.h"
#include "shapes.h"

enum { SIDE = 24 };

/* A ball of radius 16 mm around (-2, -4, 6) RAS with value 3, in voxels of 2 mm. MetaImage is LPS. */
static void write_ball(const char *path) {
    FILE *file = fopen(path, "wb");
    int i, j, k;
    CHECK(file != NULL);
    fprintf(file, "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementSpacing = 2 2 2\n"
                  "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -21 -19 -17\nDimSize = 24 24 24\n"
                  "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n");
    for (k = 0; k < SIDE; k++)
        for (j = 0; j < SIDE; j++)
            for (i = 0; i < SIDE; i++) {
                const double x = 2 * i - 23, y = 2 * j - 23, z = 2 * k - 23;
                CHECK(fputc(x * x + y * y + z * z < 256 ? 3 : 0, file) != EOF);
            }
    CHECK(fclose(file) == 0);
}

/* The same ball from memory, in LPS as the file. */
static void from_memory(const MlgVolume *read) {
    static float values[SIDE * SIDE * SIDE];
    MlgVolumeGrid grid;
    MlgVolume *made = NULL;
    MlgVolumeInfo info, as_read;
    size_t count = 0, n;
    int i, j, k;
    CHECK(mlg_volume_grid_init(&grid, sizeof grid) == MLG_STATUS_OK && grid.spacing[1] == 1);
    for (i = 0; i < 3; i++) grid.size[i] = SIDE, grid.spacing[i] = 2, grid.origin[i] = 2 * i - 21;
    grid.lps = 1;
    for (n = 0, k = 0; k < SIDE; k++)
        for (j = 0; j < SIDE; j++)
            for (i = 0; i < SIDE; i++, n++) {
                const int x = 2 * i - 23, y = 2 * j - 23, z = 2 * k - 23;
                values[n] = x * x + y * y + z * z < 256 ? 3 : 0;
            }
    CHECK(mlg_volume_new(values, &grid, &made, &error) == MLG_STATUS_OK);
    CHECK(memcmp(mlg_volume_values(made, &count), values, sizeof values) == 0 && count == n);
    CHECK(memcmp(mlg_volume_values(read, &count), values, sizeof values) == 0 && count == n);
    info.struct_size = as_read.struct_size = sizeof info;
    CHECK(mlg_volume_info(made, &info, NULL) == MLG_STATUS_OK && mlg_volume_info(read, &as_read, NULL) == MLG_STATUS_OK);
    for (i = 0; i < 12; i++) CHECK(info.world_from_voxel[i] == as_read.world_from_voxel[i]);
    for (i = 0; i < 3; i++) CHECK(info.size[i] == SIDE && info.box_low[i] == as_read.box_low[i]);
    mlg_volume_free(made);
    CHECK(mlg_volume_values(made, &count) == NULL && count == 0);

    expect(mlg_volume_new(NULL, &grid, &made, &error), MLG_STATUS_NULL_ARGUMENT, "values");
    expect(mlg_volume_new(values, NULL, &made, &error), MLG_STATUS_NULL_ARGUMENT, "grid");
    grid.spacing[2] = -2;
    expect(mlg_volume_new(values, &grid, &made, &error), MLG_STATUS_INVALID_ARGUMENT, "grid.spacing[2] is -2");
    grid.spacing[2] = 2, grid.directions[0] = 0;
    expect(mlg_volume_new(values, &grid, &made, &error), MLG_STATUS_INVALID_ARGUMENT, "do not span space");
    grid.size[0] = SIZE_MAX, grid.size[1] = 2;
    expect(mlg_volume_new(values, &grid, &made, &error), MLG_STATUS_INVALID_ARGUMENT, "crop or resample");
    grid.size[0] = 0;
    expect(mlg_volume_new(values, &grid, &made, &error), MLG_STATUS_INVALID_ARGUMENT, "none");
}

static double off_ball(const double *p) {
    const double x = p[0] + 2, y = p[1] + 4, z = p[2] - 6;
    return fabs(sqrt(x * x + y * y + z * z) - 16);
}

static void slices(const MlgVolume *volume) {
    const double axial[] = {0, 0, 1}, none[] = {0, 0, 0};
    const double window[] = {2, 2}, bad_window[] = {-2, 2};
    MlgVolumeInfo info;
    MlgSlicePlane plane;
    unsigned char pixels[4 * SIDE * SIDE];
    size_t row, column, bright = 0;

    info.struct_size = sizeof info;
    CHECK(mlg_volume_info(volume, &info, NULL) == MLG_STATUS_OK);
    CHECK(info.size[2] == SIDE && info.spacing[1] == 2 && info.range[1] == 3);
    CHECK(info.world_from_voxel[0] == -2 && info.world_from_voxel[3] == 21);
    CHECK(info.box_low[0] == -26 && info.box_high[2] == 30);

    plane.struct_size = sizeof plane;
    CHECK(mlg_volume_plane(volume, axial, 6, 0, &plane, NULL) == MLG_STATUS_OK);
    CHECK(plane.width == SIDE && plane.height == SIDE && plane.right[0] == -2 && plane.down[1] == -2);
    CHECK(mlg_volume_slice(volume, &plane, window, 1, pixels, sizeof pixels, NULL) == MLG_STATUS_OK);
    for (row = 0; row < SIDE; row++)
        for (column = 0; column < SIDE; column++) bright += pixels[row * SIDE + column] > 127;
    CHECK(bright > 180 && bright < 220); /* a disc of radius 8 pixels has 201 */
    CHECK(mlg_volume_slice(volume, &plane, NULL, 4, pixels, sizeof pixels, NULL) == MLG_STATUS_OK);
    CHECK(pixels[3] == 255);

    expect(mlg_volume_slice(volume, &plane, window, 1, pixels, 10, &error), MLG_STATUS_INVALID_ARGUMENT,
           "the buffer 10");
    expect(mlg_volume_slice(volume, &plane, window, 3, pixels, 10, &error), MLG_STATUS_INVALID_ARGUMENT,
           "1 or 4");
    expect(mlg_volume_slice(volume, &plane, bad_window, 1, pixels, sizeof pixels, &error),
           MLG_STATUS_INVALID_ARGUMENT, "the width");
    expect(mlg_volume_slice(volume, NULL, window, 1, pixels, sizeof pixels, &error),
           MLG_STATUS_NULL_ARGUMENT, "plane");
    expect(mlg_volume_plane(volume, none, 6, 0, &plane, &error), MLG_STATUS_INVALID_ARGUMENT, "0,0,0");
    expect(mlg_volume_plane(volume, axial, 600, 0, &plane, &error), MLG_STATUS_INVALID_ARGUMENT,
           "misses the image");
    plane.width = (size_t)-1;
    expect(mlg_volume_slice(volume, &plane, window, 1, pixels, sizeof pixels, &error),
           MLG_STATUS_INVALID_ARGUMENT, "too many");
    plane.width = SIDE;
    plane.down[1] = 0;
    expect(mlg_volume_slice(volume, &plane, window, 1, pixels, sizeof pixels, &error),
           MLG_STATUS_INVALID_ARGUMENT, "span a plane");
}

static void lines_and_markers(const MlgVolume *volume) {
    const double axes[] = {0, 0, 1, 0, 1, 0}, point[] = {0, 0, 6}, up[] = {0, 0, 2};
    const double corners[] = {-5, -5, 0, 5, -5, 0, 0, 5, 0, 0, 0, 10};
    const uint32_t faces[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    MlgTriMesh *mesh = NULL;
    MlgPolylines *lines = NULL;
    MlgMarkers *markers = NULL;
    MlgSlicePlane plane;
    MlgClicks clicks;
    size_t i, count = 0, starts = 0;
    const double *points;

    plane.struct_size = sizeof plane;
    CHECK(mlg_volume_plane(volume, up, 6, 0, &plane, NULL) == MLG_STATUS_OK);
    CHECK(mlg_volume_outlines(volume, 3, &plane, &lines, NULL) == MLG_STATUS_OK);
    points = mlg_polylines_points(lines, &count);
    CHECK(mlg_polylines_starts(lines, &starts)[1] == count && starts == 2);
    CHECK(mlg_polylines_closed(lines, NULL)[0] == 1);
    for (i = 0; i < count; i++) CHECK(off_ball(points + 3 * i) < 1);
    mlg_polylines_free(lines);
    CHECK(mlg_polylines_points(lines, NULL) == NULL);

    CHECK(mlg_clicks_init(&clicks, sizeof clicks) == MLG_STATUS_OK);
    clicks.spacing = 4;
    CHECK(mlg_volume_label_markers(volume, 3, axes, 2, &clicks, &markers, NULL) == MLG_STATUS_OK);
    points = mlg_markers_points(markers, &count);
    CHECK(count > 60);
    for (i = 0; i < count; i++) CHECK(off_ball(points + 3 * i) < 1);
    mlg_markers_free(markers);
    expect(mlg_volume_label_markers(volume, 4, axes, 2, NULL, &markers, &error),
           MLG_STATUS_INVALID_ARGUMENT, "no voxel of label 4; it has 3");

    CHECK(mlg_tri_mesh_new(corners, 4, faces, 4, &mesh, NULL) == MLG_STATUS_OK);
    CHECK(mlg_tri_mesh_section(mesh, NULL, 0, point, up, &lines, NULL) == MLG_STATUS_OK);
    points = mlg_polylines_points(lines, &count);
    CHECK(count == 3 && mlg_polylines_closed(lines, NULL)[0] == 1 && fabs(points[2] - 6) < 1e-12);
    mlg_polylines_free(lines);
    expect(mlg_tri_mesh_section(mesh, corners, 3, point, up, &lines, &error),
           MLG_STATUS_INVALID_ARGUMENT, "3 given, but the mesh has 4");
    expect(mlg_tri_mesh_section(mesh, NULL, 0, NULL, up, &lines, &error), MLG_STATUS_NULL_ARGUMENT,
           "plane_point");
    mlg_tri_mesh_free(mesh);
}

static void labels(const MlgVolume *volume) {
    MlgTriMesh *surface = NULL;
    MlgSkeleton *skeleton = NULL;
    MlgRegistration *problem = NULL;
    MlgRegistrationResult *result = NULL;
    MlgBone bone;
    uint32_t found[2] = {0, 9};
    const double *points;
    size_t i, count = 0, k;

    CHECK(mlg_volume_labels(volume, NULL, 0, &count, NULL) == MLG_STATUS_OK && count == 1);
    CHECK(mlg_volume_labels(volume, found, 2, &count, NULL) == MLG_STATUS_OK && found[0] == 3 && found[1] == 9);
    expect(mlg_volume_labels(volume, NULL, 2, &count, &error), MLG_STATUS_NULL_ARGUMENT, "out_labels");
    CHECK(mlg_volume_label_surface(volume, 3, &surface, NULL) == MLG_STATUS_OK);
    points = mlg_tri_mesh_points(surface, &count);
    CHECK(count > 600);
    for (i = 0; i < count; i++) CHECK(off_ball(points + 3 * i) < 1.2);
    CHECK(mlg_tri_mesh_check(surface, NULL, 0, &k, NULL) == MLG_STATUS_OK && k == 0);

    /* The same image as reference and person: the bone stays where it is. */
    bone.struct_size = sizeof bone, bone.name = "ball", bone.surface = surface;
    CHECK(mlg_skeleton_new(&bone, 1, NULL, 0, &skeleton, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_new(skeleton, &problem, &error) == MLG_STATUS_OK);
    expect(mlg_registration_set_image(problem, volume, NULL, &error), MLG_STATUS_NULL_ARGUMENT, "reference");
    CHECK(mlg_registration_set_image(problem, volume, volume, &error) == MLG_STATUS_OK);
    CHECK(mlg_registration_run(problem, NULL, &result, &error) == MLG_STATUS_OK);
    mlg_skeleton_free(skeleton);
    CHECK(mlg_registration_result_skeleton(result, &skeleton, &error) == MLG_STATUS_OK);
    points = mlg_skeleton_points(skeleton, &count);
    for (i = 0; i < count; i++) CHECK(off_ball(points + 3 * i) < 2);
    mlg_registration_result_free(result);
    mlg_registration_free(problem);
    mlg_skeleton_free(skeleton);
    mlg_tri_mesh_free(surface);
    expect(mlg_volume_label_surface(volume, 4, &surface, &error), MLG_STATUS_INVALID_ARGUMENT, "no voxel");
}

int main(int argument_count, char **arguments) {
    MlgVolume *volume = NULL;
    char path[300];
    size_t length = 7;

    CHECK(argument_count > 1);
    sprintf(path, "%s/ball.mha", arguments[1]);
    write_ball(path);
    CHECK(mlg_volume_load(path, &volume, &error) == MLG_STATUS_OK);
    CHECK(mlg_volume_notes(volume, NULL, 0, &length, NULL) == MLG_STATUS_OK && length == 0);
    slices(volume);
    from_memory(volume);
    lines_and_markers(volume);
    labels(volume);
    mlg_volume_free(volume);
    mlg_volume_free(volume);
    expect(mlg_volume_notes(volume, NULL, 0, NULL, &error), MLG_STATUS_INVALID_ARGUMENT, "freed");
    expect(mlg_volume_load("a.png", &volume, &error), MLG_STATUS_UNSUPPORTED, "is not a volume");
    expect(mlg_volume_load("no.nii", &volume, &error), MLG_STATUS_IO, "no.nii");
    CHECK(remove(path) == 0);
    puts("images: good");
    return 0;
}
