// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_moulage.h"

#include <algorithm>

#include "layers.h"

namespace {

/** What the vertex quality shows afterwards, in the order of the dialog. */
enum Shown { KEPT, STRETCH, MARKER_DISTANCE, HOW_SURE };

}  // namespace

FilterMoulage::Figures FilterMoulage::reshape(const RichParameterList &parameters,
                                              MeshDocument &document, vcg::CallBackPos *callback) {
    MeshModel &own = current(document);
    need_faces(own);
    const MeshModel &marker_layer = markers_beside(own, "template", document, parameters);
    const std::vector<double> markers = points_in(own, marker_layer);
    MeshArrays arrays = arrays_of(own);
    moulage::TriMesh surface = surface_of(arrays);

    // Landmarks: places on the template and their targets, both in the template's frame.
    std::vector<double> places, targets;
    const std::string on_template = file(parameters, "template_landmarks");
    const std::string on_person = file(parameters, "person_landmarks");
    if (on_template.empty() && !on_person.empty())
        fail("Landmarks on the person need landmarks on the template.");
    if (!on_template.empty()) {
        const auto pairs = moulage::Pairs::landmarks(surface, on_template, on_person);
        warn(pairs.warning());
        places.assign(pairs.template_points().begin(), pairs.template_points().end());
        targets.assign(pairs.targets().begin(), pairs.targets().end());
        if (!on_person.empty() && !(own.cm.Tr == marker_layer.cm.Tr)) {
            const Matrix44m matrix = into(own, marker_layer);
            for (std::size_t i = 0; i < targets.size(); i += 3) {
                const Point3m p = matrix * Point3m(Scalarm(targets[i]), Scalarm(targets[i + 1]),
                                                   Scalarm(targets[i + 2]));
                for (int k = 0; k < 3; ++k) targets[i + std::size_t(k)] = double(p[k]);
            }
        }
    }

    // Attachments are read at rest, before the template is moved to the person.
    std::vector<double> held, held_at;
    MeshModel &bone = layer(document, parameters, "bone");
    MeshModel &person_bone = layer(document, parameters, "person_bone");
    if (bone.id() != own.id()) {
        const MeshModel &there = person_bone.id() == own.id() ? bone : person_bone;
        const std::vector<double> rest = points_in(own, bone), moved = points_in(own, there);
        const moulage::TriMesh rest_bone(rest, {}), moved_bone(moved, {});
        const auto pairs = moulage::Pairs::bone(surface, rest_bone, moved_bone,
                                                double(parameters.getAbsPerc("attachment_distance")));
        held.assign(pairs.template_points().begin(), pairs.template_points().end());
        held_at.assign(pairs.targets().begin(), pairs.targets().end());
        log("%i attachments to \"%s\"", int(held.size() / 3), qUtf8Printable(bone.label()));
    }

    const int align = parameters.getEnum("align");
    if (align != 0) {
        const std::vector<double> m =
            surface.align(align == 1 ? MLG_ALIGN_RIGID : MLG_ALIGN_SIMILARITY,
                          markers, places, targets);
        for (std::vector<double> *list : {&arrays.points, &places, &held})
            for (std::size_t i = 0; i < list->size(); i += 3) {
                double *p = list->data() + i;
                const double old[] = {p[0], p[1], p[2]};
                for (std::size_t k = 0; k < 3; ++k)
                    p[k] = m[4 * k] * old[0] + m[4 * k + 1] * old[1] + m[4 * k + 2] * old[2] +
                           m[4 * k + 3];
            }
        surface = surface_of(arrays);
    }

    const moulage::Tetrahedralization tets = fill(surface, parameters, callback);
    for (const std::string &warning : tets.warnings()) warn(warning);

    moulage::Reshaping problem(tets);
    problem.set_markers(markers);
    problem.set_landmarks(places, targets);
    problem.set_attachments(held, held_at);
    if (parameters.getBool("fix_selected")) {
        const std::vector<std::uint32_t> selected = selected_vertices(own);
        if (selected.empty()) fail("No vertex of the current layer is selected to stay.");
        problem.set_fixed(selected);
    }
    warn(problem.check());
    MlgReshapingOptions options = moulage::reshaping_options();
    options.tolerance = double(parameters.getAbsPerc("tolerance"));
    options.landmark_tolerance = double(parameters.getAbsPerc("landmark_tolerance"));
    options.attachment_tolerance = double(parameters.getAbsPerc("attachment_tolerance"));
    options.hard_attachments = parameters.getBool("hard_attachments") ? 1 : 0;
    options.max_iterations = count(parameters, "max_iterations");
    options.smoothness = amount(parameters, "smoothness", options.smoothness);
    options.screening = amount(parameters, "screening", options.screening);
    options.poisson = amount(parameters, "poisson", options.poisson);
    const auto run = problem.start(options);
    follow(run, callback, amount(parameters, "seconds"));
    const moulage::ReshapingResult result = run.wait();

    set_points(own, result.points());
    const moulage::Uncertainty sure = result.uncertainty();
    const int shown = parameters.getEnum("quality");
    if (shown == STRETCH) set_quality(own, result.max_stretches());
    if (shown == MARKER_DISTANCE) {
        const moulage::TriMesh person(
            std::vector<double>(result.points().begin(), result.points().end()), arrays.triangles);
        const std::vector<double> distances = person.distances_to(markers);
        set_quality(own, distances);
    }
    if (shown == HOW_SURE) set_quality(own, sure.sd_normal());
    if (shown != KEPT && parameters.getBool("colorize")) colour_by_quality(own);

    const MlgReshapingSummary summary = result.summary();
    log("%i markers: mean distance %g, largest %g; %s after %i iterations, %.1f s",
        int(markers.size() / 3), summary.mean_marker_distance, summary.max_marker_distance,
        result.stop_name().c_str(), int(summary.iterations), summary.seconds);
    const MlgUncertaintySummary size = sure.summary();
    log("volume %g (sd %g), surface area %g (sd %g)", size.volume, size.volume_sd, size.area, size.area_sd);
    if (summary.stop == MLG_STOP_ITERATION_LIMIT)
        warn("the iterations ran out; allow more, or a larger tolerance");
    if (summary.stop == MLG_STOP_NO_STEP)
        warn("no step makes it better; look for points that contradict each other, or allow a larger tolerance");
    if (summary.stop == MLG_STOP_CANCELLED) warn("the time was over before the end; this is the best shape so far");
    if (summary.inverted_tets > 0)
        warn("the shape is folded in places (" + std::to_string(summary.inverted_tets) + " inverted tets)");
    return {{"stop", int(summary.stop)},
            {"mean_marker_distance", summary.mean_marker_distance},
            {"max_marker_distance", summary.max_marker_distance},
            {"iterations", int(summary.iterations)},
            {"inverted_tets", int(summary.inverted_tets)},
            {"volume", size.volume},
            {"volume_sd", size.volume_sd},
            {"area", size.area},
            {"area_sd", size.area_sd},
            {"seconds", summary.seconds}};
}
