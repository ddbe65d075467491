/** A template's tets follow markers, landmarks and attachments. */
#ifndef MOULAGE_RESHAPING_HPP
#define MOULAGE_RESHAPING_HPP

#include "markers.hpp"
#include "run.hpp"
#include "tets.hpp"

namespace moulage {

inline MlgReshapingOptions reshaping_options() { return defaults(mlg_reshaping_options_init); }

/** Shapes that explain the data about as well as a result: how sure it is. */
class Uncertainty : public Owner<MlgUncertainty, mlg_uncertainty_free> {
public:
    /** So many, at least 2; takes about as long as one iteration. */
    static Uncertainty of(const MlgReshapingResult *result, std::size_t shapes) {
        return Uncertainty(make(mlg_uncertainty_new, result, shapes));
    }
    /** Standard deviation of each vertex across the surface. */
    MOULAGE_LENDS(double, sd_normal, mlg_uncertainty_sd_normal, 1)
    /** In all directions. */
    MOULAGE_LENDS(double, sd, mlg_uncertainty_sd, 1)
    /** The points of one plausible shape. */
    std::vector<double> shape(std::size_t number) const {
        std::vector<double> points(3 * sd().size);
        call(mlg_uncertainty_shape, as_const(), number, points.data(), sd().size);
        return points;
    }
    /** Volume and area of the result with their standard deviations. */
    MlgUncertaintySummary summary() const {
        return filled<MlgUncertaintySummary>(mlg_uncertainty_summary, as_const());
    }

private:
    using Owner::Owner;
};

/** A reshaped template. */
class ReshapingResult : public Owner<MlgReshapingResult, mlg_reshaping_result_free> {
public:
    using Owner::Owner;
    static ReshapingResult of(const Run &run) {
        return ReshapingResult(make(mlg_run_wait_reshaping, run.get()));
    }
    MOULAGE_LENDS(double, points, mlg_reshaping_result_points, 3)
    /** The corners of each tet: those of the problem, unless new ones were made. */
    MOULAGE_LENDS(std::uint32_t, tets, mlg_reshaping_result_tets, 4)
    MOULAGE_LENDS(double, tet_points, mlg_reshaping_result_tet_points, 3)
    /** A symmetric 3x3 matrix for each tet. */
    MOULAGE_LENDS(double, plastic_strains, mlg_reshaping_result_plastic_strains, 9)
    MOULAGE_LENDS(double, marker_distances, mlg_reshaping_result_marker_distances, 1)
    MOULAGE_LENDS(double, landmark_distances, mlg_reshaping_result_landmark_distances, 1)
    MOULAGE_LENDS(double, attachment_distances, mlg_reshaping_result_attachment_distances, 1)
    MOULAGE_LENDS(double, max_stretches, mlg_reshaping_result_max_stretches, 1)
    MOULAGE_LENDS(double, min_stretches, mlg_reshaping_result_min_stretches, 1)
    MlgReshapingSummary summary() const {
        return filled<MlgReshapingSummary>(mlg_reshaping_result_summary, as_const());
    }
    /** Why it ended, such as SETTLED. */
    std::string stop_name() const { return mlg_stop_name(summary().stop); }
    MlgTetQuality quality() const {
        return filled<MlgTetQuality>(mlg_reshaping_result_quality, as_const());
    }
    /** So many plausible shapes beside it. */
    Uncertainty uncertainty(std::size_t shapes = 64) const {
        return Uncertainty::of(as_const(), shapes);
    }
    /** Moves other points with the template. */
    std::vector<double> carry(std::vector<double> at_rest) const {
        call(mlg_reshaping_result_carry, as_const(), at_rest.data(),
             rows(View<double>(at_rest), 3, "points"), at_rest.data());
        return at_rest;
    }
    /** Writes the deformed tets as .vtu, with their strains. */
    void save_tets(const std::string &path) const {
        call(mlg_reshaping_result_save_tets, as_const(), path.c_str());
    }
};

/** What is suspicious about a template and what it is to follow, and what mends it. */
class Findings : public Owner<MlgFindings, mlg_findings_free> {
public:
    /** Before any tets are made. */
    static Findings of(const TriMesh &surface, View<double> markers, const Pairs &landmarks = {},
                       const Pairs &attachments = {}, View<std::uint32_t> fixed = {}) {
        return Findings(make(mlg_tri_mesh_inspect, surface.as_const(), markers.data,
                             rows(markers, 3, "markers"), landmarks.as_const(),
                             attachments.as_const(), fixed.data, fixed.size));
    }
    std::size_t size() const { return mlg_findings_count(as_const()); }
    MlgFinding operator[](std::size_t number) const {
        return filled<MlgFinding>(mlg_findings_get, as_const(), number);
    }
    /** What is wrong and what can be done, in one sentence. */
    std::string text(std::size_t number) const {
        return text_or_empty(mlg_findings_text(as_const(), number));
    }
    /** Such as UP_AXIS. */
    std::string concern_name(std::size_t number) const {
        return mlg_concern_name((*this)[number].concern);
    }
    /** Such as DOUBTFUL. */
    std::string severity_name(std::size_t number) const {
        return mlg_severity_name((*this)[number].severity);
    }

private:
    using Owner::Owner;
};

/** A template and the data it is to follow. Lists are flat, weights may be left out. */
class Reshaping : public Owner<MlgReshaping, mlg_reshaping_free> {
public:
    explicit Reshaping(const Tetrahedralization &tets)
        : Owner(make(mlg_reshaping_new, tets.as_const())) {}
    void set_markers(View<double> points, View<double> weights = {}) {
        const std::size_t count = rows(points, 3, "points");
        call(mlg_reshaping_set_markers, get(), points.data, weights_for(weights, count), count);
    }
    void set_markers(const Markers &markers) {
        set_markers(markers.points(), markers.weights());
        set_marker_sigmas(markers.sigmas());
    }
    /** Each marker's own noise, in place of the tolerance of all; 0 stands for that. */
    void set_marker_sigmas(View<double> sigmas) {
        call(mlg_reshaping_set_marker_sigmas, get(), sigmas.data, sigmas.size);
    }
    void set_landmarks(View<double> places, View<double> targets, View<double> weights = {}) {
        set_pairs(mlg_reshaping_set_landmarks, places, 3, targets, weights);
    }
    void set_landmarks_at_vertices(View<std::uint32_t> vertices, View<double> targets,
                                   View<double> weights = {}) {
        set_pairs(mlg_reshaping_set_landmarks_at_vertices, vertices, 1, targets, weights);
    }
    void set_landmarks(const Pairs &pairs) {
        call(mlg_reshaping_set_landmark_pairs, get(), pairs.as_const());
    }
    /** How far each landmark may end from its target, whatever the markers say; below 0: no pin. */
    void set_pins(View<double> within) {
        call(mlg_reshaping_set_pins, get(), within.data, within.size);
    }
    void set_attachments(View<double> places, View<double> targets, View<double> weights = {}) {
        set_pairs(mlg_reshaping_set_attachments, places, 3, targets, weights);
    }
    void set_attachments_at_vertices(View<std::uint32_t> vertices, View<double> targets,
                                     View<double> weights = {}) {
        set_pairs(mlg_reshaping_set_attachments_at_vertices, vertices, 1, targets, weights);
    }
    void set_attachments(const Pairs &pairs) {
        call(mlg_reshaping_set_attachment_pairs, get(), pairs.as_const());
    }
    /** Vertices that stay where they are. */
    void set_fixed(View<std::uint32_t> vertices) {
        call(mlg_reshaping_set_fixed, get(), vertices.data, vertices.size);
    }
    /** The same, read from a .csv file with the column vertex, or x, y, z, or both. */
    void load_fixed(const std::string &path) {
        call(mlg_reshaping_load_fixed, get(), path.c_str());
    }
    /** What is suspicious, one sentence per line; throws if it cannot work. */
    std::string check() const { return text(mlg_reshaping_check, as_const()); }
    RunOf<ReshapingResult> start(const MlgReshapingOptions &options = reshaping_options()) const {
        return RunOf<ReshapingResult>(made<MlgRun>(mlg_reshaping_start, as_const(), &options));
    }
    /** From the shape of an earlier result for the same template and options. */
    RunOf<ReshapingResult> start_again(const ReshapingResult &earlier,
                                       const MlgReshapingOptions &options = reshaping_options()) const {
        return RunOf<ReshapingResult>(
            made<MlgRun>(mlg_reshaping_start_again, earlier.as_const(), as_const(), &options));
    }
    ReshapingResult run(const MlgReshapingOptions &options = reshaping_options()) const {
        return ReshapingResult(made<MlgReshapingResult>(mlg_reshaping_run, as_const(), &options));
    }

private:
    template <class Place, class Function>
    void set_pairs(Function function, View<Place> places, std::size_t width, View<double> targets,
                   View<double> weights) {
        const std::size_t count = rows(places, width, "places");
        check_same(rows(targets, 3, "targets"), "targets", count, "places");
        call(function, get(), places.data, targets.data, weights_for(weights, count), count);
    }
};

}  // namespace moulage

#endif
