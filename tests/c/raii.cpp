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
    std::puts("raii: good");
}
