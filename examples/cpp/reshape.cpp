// Puts a template into the shape that markers tell, with a progress line; Ctrl-C keeps the best
// shape so far.
//
//   reshape_cpp TEMPLATE.obj MARKERS.csv OUT.obj [TOLERANCE]
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "moulage.hpp"

namespace {

volatile std::sig_atomic_t interrupted = 0;

void reshape(int argc, char **argv) {
    const moulage::TriMesh surface{std::string(argv[1])};
    const moulage::Markers markers{std::string(argv[2])};
    const moulage::Tetrahedralization tets(surface);
    for (const auto &warning : tets.warnings()) std::fprintf(stderr, "note: %s\n", warning.c_str());

    moulage::Reshaping problem(tets);
    problem.set_markers(markers.points(), markers.weights());
    auto options = moulage::reshaping_options();
    if (argc > 4) options.tolerance = std::atof(argv[4]);

    const auto run = problem.start(options);
    while (!run.wait_for(0.1)) {
        const auto now = run.poll();
        std::fprintf(stderr, "\r%3.0f %% %-30s mean %.3f ", 100 * now.fraction, now.stage, now.mean_error);
        if (interrupted) run.cancel();
    }
    const moulage::ReshapingResult result = run.wait();
    const auto summary = result.summary();
    std::printf("\n%u iterations, markers mean %.3f max %.3f\n", summary.iterations,
                summary.mean_marker_distance, summary.max_marker_distance);
    surface.save(argv[3], result.points());
}

}  // namespace

int main(int argc, char **argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: %s TEMPLATE MARKERS OUT [TOLERANCE]\n", argv[0]);
        return 1;
    }
    std::signal(SIGINT, [](int) { interrupted = 1; });
    try {
        moulage::check_version();
        reshape(argc, argv);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
