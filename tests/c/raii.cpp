// The C++ owners: errors thrown, handles freed, moves, cancel by leaving the scope.
#include "moulage.hpp"

extern "C" {
#include "shapes.h"
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
    problem.set_markers(moulage::view_of(markers));
    { const moulage::Run left_alone = problem.start(); }
    const moulage::Run run = problem.start();
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
    CHECK(mesh.distances_to(moulage::view_of(markers)).size() == POINTS);
    CHECK(mesh.distances_of(mesh.points())[5] < 1e-12);
    CHECK(result.max_stretches()[0] >= result.min_stretches()[0]);
    const std::vector<double> still =
        mesh.align(MLG_ALIGN_RIGID, {}, mesh.points(), mesh.points());
    CHECK(std::fabs(still[0] - 1) < 1e-9 && std::fabs(still[3]) < 1e-9);
    CHECK(moulage::start_tets(mesh, options).wait_tets().quality().inverted_count == 0);

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
    const moulage::Skeleton skeleton({{sizeof(MlgBone), "ball", mesh.get()}}, {});
    CHECK(skeleton.bone_count() == 1 && skeleton.bone_name(0) == "ball" && skeleton.bone_name(1).empty());
    moulage::Registration registration(skeleton);
    registration.set_target(moulage::TriMesh(larger, triangles));
    auto close = moulage::registration_options();
    close.align = 0;
    const moulage::RegistrationResult found = registration.run(close);
    CHECK(found.skeleton().bone_points(0).size == points.size());
    CHECK(found.summary().mean_residual < 0.05 && found.bone_fit(0).seen > 0.5);
    CHECK(std::fabs(found.carry(mesh)[2] - found.skeleton().points()[2]) < 0.1);

    // What the two balls have in common: size.
    const moulage::Skeleton person = found.skeleton();
    const auto model =
        moulage::ShapeModel::fit(skeleton, {skeleton.as_const(), person.as_const()});
    CHECK(model.deviations().size == 1 && model.explained()[0] > 0.999);
    const double mean = model.shape().bone_points(0)[2], more = model.shape({1}).bone_points(0)[2];
    CHECK(std::fabs(mean - 1.05) < 0.02 && std::fabs(more - mean) > 0.03);
    registration.set_shape_model(model);
    CHECK(registration.run(close).coefficients().size == 1);
    std::puts("raii: good");
}
