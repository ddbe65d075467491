/** From a surface to tets that carry it. */
#ifndef MOULAGE_TETS_HPP
#define MOULAGE_TETS_HPP

#include "meshes.hpp"
#include "run.hpp"

namespace moulage {

inline MlgTetrahedralizationOptions tetrahedralization_options() {
    return defaults(mlg_tetrahedralization_options_init);
}

/** Tets that carry a surface. */
class Tetrahedralization : public Owner<MlgTetrahedralization, mlg_tetrahedralization_free> {
public:
    using Owner::Owner;
    /** Waits; `start_tets` does not. */
    explicit Tetrahedralization(
        const TriMesh &surface,
        const MlgTetrahedralizationOptions &options = tetrahedralization_options())
        : Owner(make(mlg_tetrahedralization_run, surface.as_const(), &options)) {}
    /** Tets made elsewhere. */
    Tetrahedralization(const TriMesh &surface, const TetMesh &tets)
        : Owner(make(mlg_tetrahedralization_from_tets, surface.as_const(), tets.as_const())) {}
    static Tetrahedralization of(const Run &run) {
        return Tetrahedralization(make(mlg_run_wait_tetrahedralization, run.get()));
    }
    MOULAGE_LENDS(double, points, mlg_tetrahedralization_points, 3)
    MOULAGE_LENDS(std::uint32_t, tets, mlg_tetrahedralization_tets, 4)
    /** The share of each tet inside the surface, 0 to 1. */
    MOULAGE_LENDS(double, inside_fractions, mlg_tetrahedralization_inside_fractions, 1)
    /** What made the tets: MLG_TETS_TETGEN, MLG_TETS_LATTICE or MLG_TETS_GIVEN. */
    std::uint32_t method() const { return mlg_tetrahedralization_method(as_const()); }
    /** Whether the surface's own triangles are the boundary of the tets. */
    bool boundary_kept() const { return mlg_tetrahedralization_boundary_kept(as_const()) == 1; }
    MlgTetQuality quality() const {
        return filled<MlgTetQuality>(mlg_tetrahedralization_quality, as_const());
    }
    std::vector<std::string> warnings() const {
        std::vector<std::string> all;
        for (std::size_t i = 0; i < mlg_tetrahedralization_warning_count(as_const()); ++i)
            all.emplace_back(mlg_tetrahedralization_warning(as_const(), i));
        return all;
    }
};

/** Starts to fill a surface with tets. */
inline RunOf<Tetrahedralization>
start_tets(const TriMesh &surface,
           const MlgTetrahedralizationOptions &options = tetrahedralization_options()) {
    return RunOf<Tetrahedralization>(
        made<MlgRun>(mlg_tetrahedralization_start, surface.as_const(), &options));
}

}  // namespace moulage

#endif
