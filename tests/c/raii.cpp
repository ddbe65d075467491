// The C++ owners: errors thrown, handles freed, moves, cancel by leaving the scope, no list of a temporary, no list read
// beyond its end.
#include "moulage.hpp"

#include <functional>
#include <type_traits>

extern "C" {
#include "shapes.h"
}

// Whether such an object lends its points.
template <class T, class = void> struct lends : std::false_type {};
template <class T>
struct lends<T, std::void_t<decltype(std::declval<T>().points())>> : std::true_type {};
template <class T> constexpr bool lends_only_while_it_lives = lends<const T &>::value && !lends<T>::value;
static_assert(lends_only_while_it_lives<moulage::TriMesh> && lends_only_while_it_lives<moulage::TetMesh>);
static_assert(lends_only_while_it_lives<moulage::Markers> && lends_only_while_it_lives<moulage::Skeleton>);
static_assert(lends_only_while_it_lives<moulage::Tetrahedralization>);
static_assert(lends_only_while_it_lives<moulage::ReshapingResult>);

// Lists that do not go together are refused with a sentence, before anything is read.
static void refused(const char *words, const std::function<void()> &wrong) {
    try {
        wrong();
        CHECK(false);
    } catch (const moulage::Error &error) {
        CHECK(error.status() == MLG_STATUS_INVALID_ARGUMENT);
        CHECK(std::string(error.what()).find(words) != std::string::npos);
    }
}

static void lists_that_do_not_go_together(const moulage::TriMesh &mesh, moulage::Reshaping &problem) {
    using namespace moulage;
    const std::vector<double> nine(9), ten(10), one(1), three(3);
    const std::vector<std::uint32_t> triangle(3), four(4);
    refused("1 weights for 3 points", [&] { Markers(nine, one); });
    refused("points: 10 numbers", [&] { Markers{ten}; });
    refused("points: 10 numbers", [&] { TriMesh(ten, triangle); });
    refused("triangles: 4 numbers", [&] { TriMesh(nine, four); });
    refused("tets: 10 numbers", [&] { TetMesh(mesh.points(), std::vector<std::uint32_t>(10)); });
    refused("points: 10 numbers", [&] { mesh.distances_to(ten); });
    refused("points: 10 numbers", [&] { mesh.distances_of(ten); });
    refused("points: 10 numbers", [&] { mesh.save("unwritten.obj", ten); });
    refused("3 targets for 1 landmarks", [&] { mesh.align(MLG_ALIGN_RIGID, {}, three, nine); });
    refused("1 weights for 3 points", [&] { problem.set_markers(nine, one); });
    refused("1 targets for 3 places", [&] { problem.set_landmarks(nine, three); });
    refused("1 weights for 3 points", [&] { problem.set_attachments(nine, nine, one); });
}

int main() {
    moulage::check_version();
    std::vector<double> points(3 * POINTS), markers(3 * POINTS);
    std::vector<std::uint32_t> triangles(3 * TRIANGLES);
    make_sphere(points.data(), triangles.data());
    markers.resize(3 * ellipsoid_markers(points.data(), markers.data()));

    moulage::TriMesh made(points, triangles);
    moulage::TriMesh mesh = std::move(made);
    CHECK(made.get() == nullptr && mesh.points().size == points.size());
    auto options = moulage::tetrahedralization_options();
    options.method = MLG_TETS_LATTICE;
    options.tet_count = 800;
    const moulage::Tetrahedralization tets(mesh, options);
    CHECK(tets.warnings().empty() && tets.tets().size > 4 * 600);

    moulage::Reshaping problem(tets);
    lists_that_do_not_go_together(mesh, problem);
    problem.set_markers(markers);
    { const auto left_alone = problem.start(); }
    const auto run = problem.start();
    while (run.poll().state == MLG_RUN_RUNNING) CHECK(run.preview().size() % 3 == 0);
    const moulage::ReshapingResult result = run.wait();
    CHECK(result.points().size == points.size() && result.summary().mean_marker_distance < 0.05);
    CHECK(result.carry({0, 0, 0}).size() == 3);
    try {
        run.wait();
        CHECK(false);
    } catch (const moulage::Error &error) {
        CHECK(error.status() == MLG_STATUS_INVALID_ARGUMENT && std::string(error.what()).size() > 10);
    }

    // Distances, placing, tets on a thread.
    CHECK(mesh.check().empty() && problem.check().empty());
    for (double &coordinate : markers) coordinate /= 1000;
    const std::vector<double> place = {1, 0, 0};
    const char *const name[] = {"right"};
    const moulage::Pairs own(place, place, {}, moulage::View<const char *>(name, 1));
    CHECK(own.label(0) == "right" && own.targets()[0] == 1 && own.within()[0] < 0);
    problem.set_landmarks(own);
    problem.set_pins(std::vector<double>{0.1});
    const moulage::Findings findings = moulage::Findings::of(mesh, markers);
    CHECK(moulage::Findings::of(mesh, {}, own).concern_name(0) == "AMOUNT");
    CHECK(findings.size() == 1 && findings[0].has_motion == 1);
    CHECK(findings.concern_name(0) == "UNIT" && findings.severity_name(0) == "REFUSED");
    CHECK(findings.text(0).find("metres beside millimetres") != std::string::npos);
    CHECK(mesh.distances_to(markers).size() == POINTS);
    CHECK(mesh.distances_of(mesh.points())[5] < 1e-12);
    CHECK(mesh.closest_points(mesh.points()).size() == 3 * POINTS);
    const std::vector<double> twos(POINTS, 2.0);
    CHECK(mesh.interpolate(mesh.points(), twos)[3] == 2);
    CHECK(moulage::align_points(MLG_ALIGN_RIGID, mesh.points(), mesh.points())[0] > 0.999);
    CHECK(result.max_stretches()[0] >= result.min_stretches()[0]);
    const std::vector<double> still =
        mesh.align(MLG_ALIGN_RIGID, {}, mesh.points(), mesh.points());
    CHECK(std::fabs(still[0] - 1) < 1e-9 && std::fabs(still[3]) < 1e-9);
    CHECK(moulage::start_tets(mesh, options).wait().quality().inverted_count == 0);

    // The result beside a copy of the template that overlaps it.
    moulage::Separation pile;
    pile.add_body("reshaped", result);
    pile.add_body("other", moulage::TetMesh(tets.points(), tets.tets()), mesh);
    pile.set_markers(0, {});
    std::vector<double> far = points;
    for (std::size_t i = 0; i < far.size(); i += 3) far[i] += 2.3;
    moulage::Separation beside;
    beside.add_body("reshaped", result);
    beside.add_obstacle("bone", moulage::TriMesh(far, triangles));
    const moulage::SeparationResult apart = beside.run();
    CHECK(apart.summary().separated == 1 && apart.points(0).size == points.size());
    CHECK(apart.overlap(0).depth[0] > 0.1 && apart.overlap(0).depth[1] == 0);
    CHECK(apart.body(0).inverted_tets == 0 && apart.tet_points(0).size > 0);
    pile.start().cancel();

    // A skeleton of one bone on the same bone, larger.
    std::vector<double> larger = points;
    for (double &c : larger) c *= 1.1;
    const moulage::Skeleton skeleton({{"ball", mesh}});
    CHECK(skeleton.bone_count() == 1 && skeleton.bone_name(0) == "ball" && skeleton.bone_name(1).empty());
    moulage::Registration registration(skeleton);
    registration.set_target(moulage::TriMesh(larger, triangles));
    auto close = moulage::registration_options();
    close.align = 0;
    const moulage::RegistrationResult found = registration.run(close);
    const moulage::Skeleton person = found.skeleton();
    CHECK(person.bone_points(0).size == points.size());
    CHECK(found.summary().mean_residual < 0.05 && found.bone_fit(0).seen > 0.5);
    CHECK(found.summary().verdict == MLG_VERDICT_GOOD && found.bone_reasons(0).empty());
    CHECK(std::fabs(found.carry(mesh)[2] - person.points()[2]) < 0.1);

    // What the two balls have in common: size.
    const auto model =
        moulage::ShapeModel(skeleton, moulage::Samples{skeleton, person});
    CHECK(model.deviations().size == 1 && model.explained()[0] > 0.999);
    const std::vector<double> one = {1};
    const moulage::Skeleton mean = model.shape(), more = model.shape(one);
    const double middle = mean.bone_points(0)[2];
    CHECK(std::fabs(middle - 1.05) < 0.02 && std::fabs(more.bone_points(0)[2] - middle) > 0.03);
    registration.set_shape_model(model);
    const moulage::RegistrationResult modelled = registration.run(close);
    CHECK(modelled.coefficients().size == 1);
    std::puts("raii: good");
}
