/** Bodies that overlap are pushed apart. */
#ifndef MOULAGE_SEPARATION_HPP
#define MOULAGE_SEPARATION_HPP

#include "reshaping.hpp"

namespace moulage {

inline MlgSeparationOptions separation_options() { return defaults(mlg_separation_options_init); }

/** Bodies that were pushed apart, by their numbers. */
class SeparationResult : public Owner<MlgSeparationResult, mlg_separation_result_free> {
public:
    using Owner::Owner;
    static SeparationResult of(const Run &run) {
        return SeparationResult(make(mlg_run_wait_separation, run.get()));
    }
    /** The surface of a body. */
    MOULAGE_LENDS_OF_EACH(double, points, mlg_separation_result_points, 3)
    MOULAGE_LENDS_OF_EACH(double, tet_points, mlg_separation_result_tet_points, 3)
    MlgSeparationSummary summary() const {
        return filled<MlgSeparationSummary>(mlg_separation_result_summary, as_const());
    }
    /** Why it ended, such as PARTED. */
    std::string ending_name() const { return mlg_ending_name(summary().ending); }
    MlgOverlap overlap(std::size_t number) const {
        return filled<MlgOverlap>(mlg_separation_result_overlap, as_const(), number);
    }
    MlgSeparatedBody body(std::size_t number) const {
        return filled<MlgSeparatedBody>(mlg_separation_result_body, as_const(), number);
    }
};

/** Bodies that overlap each other or obstacles; bodies are numbered from 0 as they are added. */
class Separation : public Owner<MlgSeparation, mlg_separation_free> {
public:
    Separation() : Owner(make(mlg_separation_new)) {}
    void add_body(const std::string &name, const ReshapingResult &result) {
        call(mlg_separation_add_result, get(), name.c_str(), result.as_const());
    }
    /** Tets in their present shape, and the surface that lies in them. */
    void add_body(const std::string &name, const TetMesh &tets, const TriMesh &surface) {
        call(mlg_separation_add_body, get(), name.c_str(), tets.as_const(), surface.as_const());
    }
    /** Tets in their present shape, with their boundary as surface. */
    void add_body(const std::string &name, const TetMesh &tets) {
        const MlgTriMesh *boundary = nullptr;
        call(mlg_separation_add_body, get(), name.c_str(), tets.as_const(), boundary);
    }
    void add_obstacle(const std::string &name, const TriMesh &surface) {
        call(mlg_separation_add_obstacle, get(), name.c_str(), surface.as_const());
    }
    void set_markers(std::size_t body, View<double> points) {
        call(mlg_separation_set_markers, get(), body, points.data, rows(points, 3, "points"));
    }
    RunOf<SeparationResult> start(const MlgSeparationOptions &options = separation_options()) const {
        return RunOf<SeparationResult>(made<MlgRun>(mlg_separation_start, as_const(), &options));
    }
    SeparationResult run(const MlgSeparationOptions &options = separation_options()) const {
        return SeparationResult(made<MlgSeparationResult>(mlg_separation_run, as_const(), &options));
    }
};

}  // namespace moulage

#endif
