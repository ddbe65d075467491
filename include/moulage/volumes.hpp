/** Medical images and label maps. */
#ifndef MOULAGE_VOLUMES_HPP
#define MOULAGE_VOLUMES_HPP

#include "markers.hpp"

namespace moulage {

inline MlgVolumeGrid volume_grid() { return defaults(mlg_volume_grid_init); }
inline MlgClicks clicks() { return defaults(mlg_clicks_init); }

/** An image; millimetres, RAS. */
class Volume : public Owner<MlgVolume, mlg_volume_free> {
public:
    explicit Volume(const std::string &path) : Owner(make(mlg_volume_load, path.c_str())) {}
    /** From memory, the first index fastest. */
    Volume(View<float> values, const MlgVolumeGrid &grid)
        : Owner(make(mlg_volume_new, checked(values, grid), &grid)) {}
    MOULAGE_LENDS(float, values, mlg_volume_values, 1)
    MlgVolumeInfo info() const { return filled<MlgVolumeInfo>(mlg_volume_info, as_const()); }
    /** What was noticed while reading, one sentence per line. */
    std::string notes() const { return text(mlg_volume_notes, as_const()); }
    /** The name that the file has for a label of a label map; empty where it has none. */
    std::string label_name(std::uint32_t label) const { return text(mlg_volume_label_name, as_const(), label); }
    /** A plane as large as the image needs. `pixel`: mm; 0: the image's smallest spacing. */
    MlgSlicePlane plane(const Vector &axis, double position, double pixel = 0) const {
        return filled<MlgSlicePlane>(mlg_volume_plane, as_const(), axis.data(), position, pixel);
    }
    /** Rows from the top, `channels` (1 or 4) bytes a pixel. `window`: width and level, or none. */
    std::vector<std::uint8_t> slice(const MlgSlicePlane &plane, std::uint32_t channels = 4,
                                    View<double> window = {}) const {
        if (!window.empty()) check_same(window.size, "numbers of window", 2, "values");
        std::vector<std::uint8_t> pixels(plane.width * plane.height * channels);
        call(mlg_volume_slice, as_const(), &plane, window.data, channels, pixels.data(), pixels.size());
        return pixels;
    }
    /** Of a label map: ascending, without 0. */
    std::vector<std::uint32_t> labels() const {
        std::size_t count = 0;
        call(mlg_volume_labels, as_const(), nullptr, std::size_t(0), &count);
        std::vector<std::uint32_t> labels(count);
        call(mlg_volume_labels, as_const(), labels.data(), labels.size(), &count);
        return labels;
    }
    Polylines outlines(std::uint32_t label, const MlgSlicePlane &plane) const {
        return Polylines(made<MlgPolylines>(mlg_volume_outlines, as_const(), label, &plane));
    }
    /** Markers on the outlines of a label. `axes`: one for each series of slices. */
    Markers label_markers(std::uint32_t label, const std::vector<Vector> &axes,
                          const MlgClicks &how = clicks()) const {
        const double *numbers = axes.empty() ? nullptr : axes.front().data();
        return Markers(made<MlgMarkers>(mlg_volume_label_markers, as_const(), label, numbers,
                                        axes.size(), &how));
    }
    TriMesh label_surface(std::uint32_t label) const {
        return TriMesh(made<MlgTriMesh>(mlg_volume_label_surface, as_const(), label));
    }

private:
    /** The values, if there are as many as the grid has voxels. */
    static const float *checked(View<float> values, const MlgVolumeGrid &grid) {
        std::size_t left = values.size;
        for (const std::size_t size : grid.size) {
            if (size == 0 || left % size != 0) left = 0;
            else left /= size;
        }
        if (left != 1)
            throw Error(MLG_STATUS_INVALID_ARGUMENT,
                        std::to_string(values.size) + " values for a grid of " +
                            std::to_string(grid.size[0]) + " x " + std::to_string(grid.size[1]) +
                            " x " + std::to_string(grid.size[2]) + " voxels");
        return values.data;
    }
};

}  // namespace moulage

#endif
