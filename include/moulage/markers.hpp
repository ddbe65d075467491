/** Markers, and pairs of places and targets. */
#ifndef MOULAGE_MARKERS_HPP
#define MOULAGE_MARKERS_HPP

#include "meshes.hpp"

namespace moulage {

/** Points that somebody marked. */
class Markers : public Owner<MlgMarkers, mlg_markers_free> {
public:
    using Owner::Owner;
    /** `labels`: as many as points, each of which may be NULL; or none. */
    explicit Markers(View<double> points, View<double> weights = {}, View<const char *> labels = {})
        : Owner(make(mlg_markers_new, points.data, weights_for(weights, rows(points, 3, "points")),
                     labels_for(labels, points.size / 3), points.size / 3)) {}
    explicit Markers(const std::string &path) : Owner(make(mlg_markers_load, path.c_str())) {}
    MOULAGE_LENDS(double, points, mlg_markers_points, 3)
    MOULAGE_LENDS(double, weights, mlg_markers_weights, 1)
    /** The noise of each; 0 where none is given. */
    MOULAGE_LENDS(double, sigmas, mlg_markers_sigmas, 1)
    /** The name of a marker; empty if it has none. */
    std::string label(std::size_t number) const {
        return text_or_empty(mlg_markers_label(as_const(), number));
    }
    void save(const std::string &path) const { call(mlg_markers_save, as_const(), path.c_str()); }

private:
    static const char *const *labels_for(View<const char *> labels, std::size_t count) {
        if (labels.empty()) return nullptr;
        check_same(labels.size, "labels", count, "points");
        return labels.data;
    }
};

/** Places on a template with their targets: landmarks or attachments. */
class Pairs : public Owner<MlgPairs, mlg_pairs_free> {
public:
    /** None. */
    Pairs() = default;
    Pairs(View<double> places, View<double> targets, View<double> weights = {},
          View<const char *> labels = {})
        : Owner(make_from(places, targets, weights, labels)) {}
    /** From a file of pairs, or from two marker files paired by label. */
    static Pairs landmarks(const TriMesh &surface, const std::string &path,
                           const std::string &person_path = "") {
        const char *person = person_path.empty() ? nullptr : person_path.c_str();
        return Pairs(make(mlg_pairs_load_landmarks, surface.as_const(), path.c_str(), person));
    }
    static Pairs attachments(const TriMesh &surface, const std::string &path, bool keep_gap = true) {
        return Pairs(make(mlg_pairs_load_attachments, surface.as_const(), path.c_str(),
                          std::uint32_t(keep_gap)));
    }
    static Pairs bone(const TriMesh &surface, const TriMesh &bone, const TriMesh &person_bone,
                      double distance) {
        return Pairs(make(mlg_pairs_from_bone, surface.as_const(), bone.as_const(),
                          person_bone.as_const(), distance));
    }
    /** The template's vertices that are named, each held at the bone's vertex nearest to it. */
    static Pairs vertices(const TriMesh &surface, View<std::uint32_t> vertices, const TriMesh &bone,
                          const TriMesh &person_bone) {
        return Pairs(make(mlg_pairs_from_vertices, surface.as_const(), vertices.data, vertices.size,
                          bone.as_const(), person_bone.as_const()));
    }
    MOULAGE_LENDS(double, template_points, mlg_pairs_template_points, 3)
    /** MLG_NO_VERTEX where a place is no vertex. */
    MOULAGE_LENDS(std::uint32_t, template_vertices, mlg_pairs_template_vertices, 1)
    MOULAGE_LENDS(double, targets, mlg_pairs_targets, 3)
    MOULAGE_LENDS(double, weights, mlg_pairs_weights, 1)
    /** Of pins, how far they may end from their targets; below 0 where a landmark is none. */
    MOULAGE_LENDS(double, within, mlg_pairs_within, 1)
    std::string label(std::size_t number) const {
        return text_or_empty(mlg_pairs_label(as_const(), number));
    }
    /** What was left out, in a sentence; empty if nothing was. */
    std::string warning() const { return text_or_empty(mlg_pairs_warning(as_const())); }

private:
    using Owner::Owner;
    static MlgPairs *make_from(View<double> places, View<double> targets, View<double> weights,
                               View<const char *> labels) {
        const std::size_t count = rows(places, 3, "places");
        check_same(rows(targets, 3, "targets"), "targets", count, "places");
        if (!labels.empty()) check_same(labels.size, "labels", count, "places");
        return make(mlg_pairs_new, places.data, targets.data, weights_for(weights, count),
                    labels.data, count);
    }
};

}  // namespace moulage

#endif
