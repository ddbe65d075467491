// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_moulage.h"

#include <algorithm>

#include <Eigen/Core>

#include "layers.h"

namespace {

double percentile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

double mean(const std::vector<double> &values) {
    double sum = 0;
    for (double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

}  // namespace

FilterMoulage::Figures FilterMoulage::tetrahedralize(const RichParameterList &parameters,
                                                     MeshDocument &document,
                                                     vcg::CallBackPos *callback) {
    MeshModel &own = current(document);
    need_faces(own);
    const moulage::TriMesh surface = surface_of(arrays_of(own));
    const moulage::Tetrahedralization tets = fill(surface, parameters, callback);
    warn(surface.check());
    for (const std::string &warning : tets.warnings()) warn(warning);
    const std::string save = file(parameters, "save", true);
    if (!save.empty()) moulage::TetMesh(tets.points(), tets.tets()).save(save);
    const MlgTetQuality quality = tets.quality();
    const bool by_tetgen = tets.method() == MLG_TETS_TETGEN;
    log("%i tets by %s, volume %g; dihedral angles %.1f to %.1f deg; radius ratio %.3f at least, %.3f "
        "on average",
        int(quality.tet_count), by_tetgen ? "TetGen" : "the lattice", quality.volume,
        quality.min_dihedral, quality.max_dihedral, quality.min_radius_ratio,
        quality.mean_radius_ratio);
    Eigen::VectorXd histogram(18);
    for (int k = 0; k < 18; ++k) histogram[k] = quality.dihedral_histogram[k];
    return {{"tet_count", int(quality.tet_count)},
            {"inverted_tets", int(quality.inverted_count)},
            {"volume", quality.volume},
            {"min_dihedral", quality.min_dihedral},
            {"max_dihedral", quality.max_dihedral},
            {"min_radius_ratio", quality.min_radius_ratio},
            {"mean_radius_ratio", quality.mean_radius_ratio},
            {"dihedral_histogram", QVariant::fromValue(histogram)}};
}

FilterMoulage::Figures FilterMoulage::distance(const RichParameterList &parameters,
                                               MeshDocument &document) {
    MeshModel &own = current(document);
    need_faces(own);
    const MeshModel &marker_layer = markers_beside(own, "surface", document, parameters);
    const std::vector<double> markers = points_in(own, marker_layer);
    const moulage::TriMesh surface = surface_of(arrays_of(own));
    const std::vector<double> to = surface.distances_to(markers);
    const std::vector<double> of = surface.distances_of(markers);

    set_quality(own, to);
    if (parameters.getBool("colorize")) colour_by_quality(own);
    const double largest = *std::max_element(of.begin(), of.end());
    log("%i markers: distance to the surface mean %g, 95 %% below %g, largest %g",
        int(of.size()), mean(of), percentile(of, 0.95), largest);
    return {{"mean_marker_distance", mean(of)},
            {"p95_marker_distance", percentile(of, 0.95)},
            {"max_marker_distance", largest},
            {"max_vertex_distance", *std::max_element(to.begin(), to.end())}};
}
