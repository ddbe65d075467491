// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_moulage.h"

#include <algorithm>

#include <QRegularExpression>

#include "layers.h"

namespace {

/** Names with * for anything; remembers which of them no layer had. */
class Names {
public:
    explicit Names(const QString &list) {
        for (const QString &name : list.split(',', Qt::SkipEmptyParts))
            patterns_.push_back({name.trimmed(), false});
    }
    bool hold(const QString &label) {
        bool held = false;
        for (Pattern &pattern : patterns_) {
            const QString expression = QRegularExpression::wildcardToRegularExpression(pattern.name);
            if (pattern.name != label && !QRegularExpression(expression).match(label).hasMatch()) continue;
            pattern.found = held = true;
        }
        return held;
    }
    void need_all_found() const {
        for (const Pattern &pattern : patterns_)
            if (!pattern.found)
                fail(QString("No visible layer with faces is called \"%1\", which is to stay fixed.")
                         .arg(pattern.name));
    }

private:
    struct Pattern {
        QString name;
        bool found;
    };
    std::vector<Pattern> patterns_;
};

/** The visible layers with faces, and the layers of points where bodies are held. */
struct Scene {
    std::vector<MeshModel *> bodies, obstacles;
    /** Of each body; null without markers. */
    std::vector<const MeshModel *> markers;

    Scene(MeshDocument &document, const RichParameterList &parameters) {
        Names fixed(parameters.getString("fixed"));
        std::vector<std::string> names, body_names;
        std::vector<const MeshModel *> layers;
        for (MeshModel &candidate : document.meshIterator()) {
            layers.push_back(&candidate);
            names.push_back(name_of(candidate));
            if (!candidate.isVisible() || candidate.cm.fn == 0) continue;
            if (fixed.hold(candidate.label())) {
                obstacles.push_back(&candidate);
            } else {
                bodies.push_back(&candidate);
                body_names.push_back(names.back());
            }
        }
        fixed.need_all_found();
        if (bodies.empty() || bodies.size() + obstacles.size() < 2)
            fail("There is nothing to separate: show two layers with faces, not all of them fixed.");
        markers.resize(bodies.size());
        for (const QString &pair : parameters.getString("markers").split(',', Qt::SkipEmptyParts)) {
            const auto found = named_pair(pair, body_names, names);
            if (!found)
                fail(QString("The markers \"%1\" do not name a layer that may move and a layer of points "
                             "as surface-points.").arg(pair.trimmed()));
            markers[found->first] = layers[found->second];
        }
    }
    /** As overlaps count: bodies first. */
    const MeshModel &layer(std::size_t number) const {
        return number < bodies.size() ? *bodies[number] : *obstacles[number - bodies.size()];
    }
};

}  // namespace

FilterMoulage::Figures FilterMoulage::separate(const RichParameterList &parameters,
                                               MeshDocument &document, vcg::CallBackPos *callback) {
    const Scene scene(document, parameters);
    // Everything meets in the frame of the scene.
    moulage::Separation problem;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const std::string name = name_of(*scene.bodies[b]);
        const moulage::TriMesh surface = surface_in_scene(*scene.bodies[b]);
        const moulage::Tetrahedralization tets = fill(surface, parameters, callback);
        for (const std::string &warning : tets.warnings()) warn(name + ": " + warning);
        problem.add_body(name, moulage::TetMesh(tets.points(), tets.tets()), surface);
        if (const MeshModel *markers = scene.markers[b]) {
            const std::vector<double> points = points_in_scene(*markers);
            problem.set_markers(b, points);
        }
    }
    for (const MeshModel *obstacle : scene.obstacles)
        problem.add_obstacle(name_of(*obstacle), surface_in_scene(*obstacle));
    MlgSeparationOptions options = moulage::separation_options();
    options.gap = double(parameters.getAbsPerc("gap"));
    options.rings = count(parameters, "rings");
    const auto run = problem.start(options);
    follow(run, callback, amount(parameters, "seconds"));
    const moulage::SeparationResult result = run.wait();

    int moved = 0;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const MlgSeparatedBody body = result.body(b);
        const std::string name = name_of(*scene.bodies[b]);
        if (body.markers_inside_obstacles > 0)
            warn(std::to_string(body.markers_inside_obstacles) + " markers of " + name +
                 " lie inside a fixed layer and cannot be met");
        if (body.moved_vertices == 0) continue;
        set_points_in_scene(*scene.bodies[b], result.points(b));
        moved += int(body.moved_vertices);
        log("%s: %i vertices moved, at most by %g", name.c_str(), int(body.moved_vertices),
            body.largest_move);
        if (body.mean_marker_distance[0] >= 0)  // NaN without markers
            log("%s: markers %g off on average before, %g after", name.c_str(),
                body.mean_marker_distance[0], body.mean_marker_distance[1]);
    }

    const MlgSeparationSummary summary = result.summary();
    int before = 0, after = 0;
    double deepest[] = {0, 0};
    for (std::size_t number = 0; number < summary.overlap_count; ++number) {
        const MlgOverlap overlap = result.overlap(number);
        const auto is_there = [&](int when) {
            return overlap.vertices_inside[when] > 0 || overlap.crossings[when] > 0;
        };
        before += is_there(0);
        after += is_there(1);
        for (int when : {0, 1}) deepest[when] = std::max(deepest[when], overlap.depth[when]);
        log("%s and %s: overlap %g deep before, %g after", name_of(scene.layer(overlap.first)).c_str(),
            name_of(scene.layer(overlap.second)).c_str(), overlap.depth[0], overlap.depth[1]);
    }
    if (summary.separated)
        log("No triangle of one surface crosses or lies inside another.");
    else
        warn(std::to_string(after) + " overlaps are left; allow more rings or more time, or look whether the "
                                     "shapes contradict each other");
    return {{"separated", summary.separated != 0},
            {"ending", int(summary.ending)},
            {"overlaps_before", before},
            {"overlaps_after", after},
            {"deepest_before", deepest[0]},
            {"deepest_after", deepest[1]},
            {"moved_vertices", moved},
            {"rounds", int(summary.rounds)},
            {"seconds", summary.seconds}};
}
