// What raii.cpp leaves: with it every function is called from C++ once (tests/c/run.sh looks), each with an answer that can
// be wrong.
//   reach EXAMPLES FOLDER
#include "moulage.hpp"

#include <fstream>
#include <limits>

extern "C" {
#include "shapes.h"
}

using namespace moulage;

static std::string folder;
static std::string in_folder(const char *name) { return folder + "/" + name; }
static bool near(double a, double b, double by = 1e-9) { return std::fabs(a - b) < by; }
static double distance(const double *a, const double *b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

struct Ball {
    std::vector<double> points = std::vector<double>(3 * POINTS);
    std::vector<std::uint32_t> triangles = std::vector<std::uint32_t>(3 * TRIANGLES);
    explicit Ball(double scale = 1, double x = 0) {
        make_sphere(points.data(), triangles.data());
        for (double &c : points) c *= scale;
        for (std::size_t i = 0; i < points.size(); i += 3) points[i] += x;
    }
    TriMesh mesh() const { return {points, triangles}; }
};

template <class Call> static MlgStatus status_of(Call call) {
    try {
        call();
    } catch (const Error &error) {
        CHECK(!error.status_name().empty() && std::string(error.what()).size() > 10);
        return error.status();
    }
    return MLG_STATUS_OK;
}

static Tetrahedralization meshes() {
    const TriMesh ball = Ball().mesh();
    ball.save(in_folder("ball.obj"));
    const TriMesh again(in_folder("ball.obj"));
    CHECK(again.triangles().size == 3 * TRIANGLES && near(again.points()[2], 1));
    const Polylines ring = again.section({0, 0, 0.1}, {0, 0, 1});
    CHECK(ring.starts().size == 2 && ring.closed()[0] == 1 && 3 * ring.starts()[1] == ring.points().size);

    auto options = tetrahedralization_options();
    options.method = MLG_TETS_LATTICE;
    options.tet_count = 800;
    const Tetrahedralization filled(ball, options);
    CHECK(filled.method() == MLG_TETS_LATTICE && !filled.boundary_kept());
    CHECK(filled.inside_fractions().size == filled.tets().size / 4);
    TetMesh(filled.points(), filled.tets()).save(in_folder("ball.vtu"));
    const TetMesh tets(in_folder("ball.vtu"));
    CHECK(tets.points().size == filled.points().size && tets.tets().size == filled.tets().size);
    Tetrahedralization given(ball, tets);
    CHECK(given.method() == MLG_TETS_GIVEN);
    return given;
}

static void marked() {
    const std::vector<double> places = {0, 0, 1, 0, 0, -1, 1, 0, 0}, weights = {1, 2, 3};
    const std::vector<const char *> labels = {"head", nullptr, "side"};
    const Markers markers(places, weights, labels);
    CHECK(markers.label(0) == "head" && markers.label(1).empty() && markers.weights()[1] == 2);
    markers.save(in_folder("marks.csv"));
    const Markers again(in_folder("marks.csv"));
    CHECK(again.points().size == 9 && again.label(2) == "side");
    std::ofstream(in_folder("noise.csv")) << "x,y,z,sigma\n0,0,1,0.2\n0,0,-1,\n1,0,0,\n";
    const Markers noisy(in_folder("noise.csv"));
    CHECK(noisy.sigmas()[0] == 0.2 && noisy.sigmas()[1] == 0);
}

static Pairs pairs() {
    std::ofstream(in_folder("pairs.csv")) << "label,template_x,template_y,template_z,target_x,target_y,target_z\ntop,0,0,1,0,0,1.5\n";
    Pairs loaded = Pairs::landmarks(Ball().mesh(), in_folder("pairs.csv"));
    CHECK(loaded.template_points()[2] == 1 && loaded.targets()[2] == 1.5 && loaded.weights()[0] == 1);
    CHECK(loaded.label(0) == "top" && loaded.template_vertices().size == 1 && loaded.warning().empty());
    return loaded;
}

static ReshapingResult reshaped(const Tetrahedralization &tets) {
    const Ball ball, larger(1.2);
    Reshaping problem(tets);
    const std::vector<double> noise(POINTS, 0.01);
    problem.set_markers(Markers(larger.points));
    problem.set_marker_sigmas(noise);
    problem.set_markers(larger.points);
    const std::vector<std::uint32_t> vertices = {0, POINTS - 1};
    const std::vector<double> targets = {0, 0, 1.3, 0, 0, -1.1};
    problem.set_landmarks_at_vertices(vertices, targets);
    const std::vector<double> held = {1, 0, 0}, held_at = {1.2, 0, 0};
    problem.set_attachments(held, held_at);
    auto options = reshaping_options();
    options.max_iterations = 4;
    ReshapingResult result = problem.run(options);
    CHECK(result.stop_name() == mlg_stop_name(result.summary().stop) && result.stop_name() != "UNKNOWN");
    CHECK(result.landmark_distances().size == 2 && result.attachment_distances().size == 1);
    CHECK(near(result.landmark_distances()[1], distance(result.points().end() - 3, &targets[3])));
    const std::vector<double> moved = result.carry(held);
    CHECK(near(result.attachment_distances()[0], distance(moved.data(), held_at.data())));
    CHECK(result.marker_distances().size == POINTS && result.quality().tet_count == tets.tets().size / 4);
    CHECK(result.plastic_strains().size == 9 * result.quality().tet_count);
    CHECK(result.tets().size == 4 * result.quality().tet_count && result.summary().remeshes == 0);
    const Uncertainty sure = result.uncertainty(4);
    CHECK(sure.sd().size == POINTS && sure.sd_normal().size == POINTS);
    CHECK(sure.sd()[0] >= sure.sd_normal()[0] && sure.sd_normal()[0] > 0);
    CHECK(sure.shape(3).size() == result.points().size);
    const MlgUncertaintySummary size = sure.summary();
    CHECK(size.shapes == 4 && size.volume_sd > 0 && size.volume_sd < size.volume && size.area_sd > 0);
    result.save_tets(in_folder("reshaped.vtu"));
    const TetMesh saved(in_folder("reshaped.vtu"));
    CHECK(saved.points().size == result.tet_points().size);
    const auto again = problem.start_again(result, options);
    CHECK(again.wait_for(std::numeric_limits<double>::infinity()) && again.poll().state == MLG_RUN_ENDED);
    const ReshapingResult second = again.wait();
    CHECK(second.points().size == result.points().size);

    // The other ways of saying where places are.
    Reshaping other(tets);
    other.set_landmarks(pairs());
    other.set_attachments(pairs());
    other.set_attachments_at_vertices(vertices, targets);
    std::ofstream(in_folder("fixed.txt")) << "vertex\n5\n";
    other.load_fixed(in_folder("fixed.txt"));
    const std::vector<std::uint32_t> fixed = {5}, beyond = {POINTS};
    other.set_fixed(fixed);
    CHECK(status_of([&] { other.set_fixed(beyond); }) == MLG_STATUS_INVALID_ARGUMENT);
    const std::vector<std::uint32_t> third = {3};
    const Pairs of_vertices = Pairs::vertices(ball.mesh(), third, ball.mesh(), larger.mesh());
    CHECK(of_vertices.template_vertices()[0] == 3);
    const Pairs of_bone = Pairs::bone(ball.mesh(), ball.mesh(), larger.mesh(), 0.1);
    CHECK(of_bone.targets().size == 3 * POINTS);
    CHECK(status_of([&] { Pairs::attachments(ball.mesh(), in_folder("none.csv")); }) == MLG_STATUS_IO);
    return result;
}

static void separated(const Tetrahedralization &tets, const ReshapingResult &result) {
    Separation problem;
    problem.add_body("ball", TetMesh(tets.points(), tets.tets()));
    problem.add_obstacle("wall", Ball(1, 1.9).mesh());
    const SeparationResult apart = problem.start().wait();
    CHECK(apart.ending_name() == "PARTED" && apart.summary().separated == 1);
    CHECK(result.points().size > 0);
}

static void imaged() {
    // A ball of radius 16 mm around (5, 0, 0) RAS, given as ITK does.
    auto grid = volume_grid();
    std::vector<float> values;
    for (std::size_t &size : grid.size) size = 24;
    for (double &spacing : grid.spacing) spacing = 2;
    const double corner[] = {-23 - 5, -23, -23};
    std::copy(corner, corner + 3, grid.origin);
    grid.lps = 1;
    for (int k = 0; k < 24; ++k)
        for (int j = 0; j < 24; ++j)
            for (int i = 0; i < 24; ++i)
                values.push_back(std::hypot(2 * i - 23, 2 * j - 23, 2 * k - 23) < 16 ? 7 : 0);
    const Volume volume(values, grid);
    CHECK(volume.values().size == values.size() && volume.values()[24 * 24 * 12 + 24 * 12 + 12] == 7);
    CHECK(volume.info().world_from_voxel[0] == -2 && volume.info().world_from_voxel[3] == 28);
    CHECK(volume.label_name(7).empty());
    CHECK(volume.notes().empty() && volume.labels() == std::vector<std::uint32_t>{7});
    const TriMesh surface = volume.label_surface(7);
    for (std::size_t i = 0; i < surface.points().size; i += 3) {
        const double centre[] = {5, 0, 0};
        CHECK(near(distance(&surface.points()[i], centre), 16, 1.5));
    }
    const MlgSlicePlane plane = volume.plane({0, 0, 1}, 1);
    CHECK(volume.slice(plane).size() == 4 * plane.width * plane.height);
    const Polylines outlines = volume.outlines(7, plane);
    const Markers clicked = volume.label_markers(7, {{0, 0, 1}, {1, 0, 0}});
    CHECK(outlines.closed()[0] == 1 && clicked.points().size > 60);

    values.pop_back();
    CHECK(status_of([&] { Volume(values, grid); }) == MLG_STATUS_INVALID_ARGUMENT);
    grid.spacing[1] = 0;
    values.push_back(0);
    CHECK(status_of([&] { Volume(values, grid); }) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(status_of([&] { Volume(in_folder("none.nrrd")); }) == MLG_STATUS_IO);
}

static Skeleton two_balls(double scale) {
    const TriMesh first = Ball(scale).mesh(), second = Ball(scale, 2.2 * scale).mesh();
    MlgJoint between = joint();
    between.name = "between";
    between.child = 1;
    std::fill_n(between.negative_limits, 3, 0.5);
    std::fill_n(between.positive_limits, 3, 0.5);
    return Skeleton({{"first", first}, {"second", second}}, {between});
}

static void moving(const std::string &examples) {
    const Skeleton balls = two_balls(1);
    CHECK(balls.joint_count() == 1 && balls.joint(0).child == 1 && balls.notes().empty());
    CHECK(balls.bone_triangles(1).size == 3 * TRIANGLES);
    balls.save(in_folder("balls.skeleton.json"));
    CHECK(Skeleton(in_folder("balls.skeleton.json")).bone_name(1) == "second");

    const Skeleton hand(examples + "/hand/skeleton.json");
    const std::string angle = hand.angle_name(0);
    CHECK(!angle.empty() && near(hand.angles()[0], 0) && hand.angle_name(hand.angles().size).empty());
    const std::vector<const char *> names = {angle.c_str()};
    const std::vector<double> times = {0, 1}, angles = {0, 0.25};
    const Motion motion(hand, names, times, angles);
    CHECK(motion.times()[1] == 1 && motion.angles()[1] == 0.25 && motion.angle_name(0) == angle);
    motion.save(in_folder("turn.mot"));
    const Motion again(hand, in_folder("turn.mot"), names);
    CHECK(near(again.angles()[1], -0.25, 1e-6) && again.notes().empty());
    hand.save_motion(in_folder("turn.mot"), in_folder("turn.glb"));
    CHECK(std::ifstream(in_folder("turn.glb")).good());
    CHECK(status_of([&] { hand.save_osim(in_folder("none.osim"), in_folder("out.osim")); }) != MLG_STATUS_OK);
    CHECK(status_of([&] { hand.save_osim(in_folder("none.osim"), in_folder("out.osim"), 70); }) != MLG_STATUS_OK);
}

static void registered() {
    const Skeleton skeleton = two_balls(1), large = two_balls(1.2), small = two_balls(0.9);
    const ShapeModel model(skeleton, Samples{skeleton, large, small});
    CHECK(ShapeModel::left_out(skeleton, {skeleton, large, small}).size() == 3);
    model.save(in_folder("balls.h5.json"));
    const ShapeModel read(skeleton, in_folder("balls.h5.json"));
    CHECK(near(read.deviations()[0], model.deviations()[0], 1e-4));

    Registration problem(skeleton);
    problem.set_shape_model_of_template();
    problem.set_bone_target(0, Ball(1.1).mesh());
    // The balls are larger and further apart than that explains.
    problem.set_bone_target(1, Ball(1.1, 2.5).mesh());
    auto options = registration_options();
    options.align = 0;
    const RegistrationResult found = problem.start(options).wait();
    const Skeleton person = found.skeleton();
    CHECK(found.joint_pose(0).usage <= 1 && near(person.points()[2], 1.1, 0.05));
    CHECK(found.warnings().find("by length: between") != std::string::npos);
    // A target that shows one of two bones says so.
    Registration half(skeleton);
    half.set_bone_target(0, Ball(1.1).mesh());
    const RegistrationResult unseen = half.run(options);
    CHECK(unseen.summary().verdict != MLG_VERDICT_GOOD && unseen.bone_fit(1).reason_count > 0);
    CHECK(unseen.bone_fit(1).verdict == MLG_VERDICT_DOUBTFUL && unseen.verdict_name() == "DOUBTFUL");
    CHECK(unseen.bone_reasons(1).find("no surface of it") != std::string::npos);
    CHECK(unseen.seen().size == person.points().size / 3);
    CHECK(unseen.seen()[0] > 0.5 && unseen.seen()[unseen.seen().size - 1] < 0.5);
    // Limits are a number of MlgLimits.
    options.limits = MLG_LIMITS_NONE + 1;
    CHECK(status_of([&] { half.run(options); }) == MLG_STATUS_INVALID_ARGUMENT);
    options.limits = MLG_LIMITS_SOFT;
    CHECK(status_of([&] { half.run(options); }) == MLG_STATUS_OK);
    // One in metres is refused, unless it is meant.
    Registration metres(skeleton);
    metres.set_target(Ball(0.001).mesh());
    CHECK(status_of([&] { metres.run(options); }) == MLG_STATUS_INVALID_ARGUMENT);
    options.as_is = 1;
    CHECK(status_of([&] { metres.run(options); }) == MLG_STATUS_OK);
    auto grid = volume_grid();
    for (std::size_t &size : grid.size) size = 8;
    const std::vector<float> dark(512);
    const Volume image(dark, grid);
    problem.set_image(image, image);
}

int main(int count, char **arguments) {
    CHECK(count == 3);
    folder = arguments[2];
    CHECK(version() == std::to_string(MLG_VERSION_MAJOR) + "." + std::to_string(MLG_VERSION_MINOR) + "." +
                           std::to_string(MLG_VERSION_PATCH));
    const Tetrahedralization tets = meshes();
    marked();
    const ReshapingResult result = reshaped(tets);
    separated(tets, result);
    imaged();
    moving(arguments[1]);
    registered();
    std::puts("reach: good");
}
