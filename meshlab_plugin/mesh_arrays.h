// SPDX-License-Identifier: GPL-3.0-or-later
/** MeshLab's meshes as flat arrays, and back. MeshLab keeps deleted elements in its lists; the arrays
 * hold what is left, in order. */
#ifndef MOULAGE_MESH_ARRAYS_H
#define MOULAGE_MESH_ARRAYS_H

#include <cstdint>
#include <vector>

#include <common/ml_document/mesh_document.h>

#include "moulage.hpp"

struct MeshArrays {
    std::vector<double> points;
    std::vector<std::uint32_t> triangles;
};

/** The layer's points and triangles as they are, or its points transformed by `matrix`. */
inline MeshArrays arrays_of(const MeshModel &layer, const Matrix44m *matrix = nullptr) {
    MeshArrays arrays;
    std::vector<std::uint32_t> number(layer.cm.vert.size());
    for (std::size_t v = 0; v < layer.cm.vert.size(); ++v) {
        if (layer.cm.vert[v].IsD()) continue;
        number[v] = static_cast<std::uint32_t>(arrays.points.size() / 3);
        const Point3m p = matrix ? *matrix * layer.cm.vert[v].cP() : layer.cm.vert[v].cP();
        for (int k = 0; k < 3; ++k) arrays.points.push_back(static_cast<double>(p[k]));
    }
    for (const CFaceO &face : layer.cm.face) {
        if (face.IsD()) continue;
        for (int k = 0; k < 3; ++k)
            arrays.triangles.push_back(number[vcg::tri::Index(layer.cm, face.cV(k))]);
    }
    return arrays;
}

/** Gives each vertex of the layer its three numbers of `points`, as they are or transformed. */
inline void set_points(MeshModel &layer, moulage::View<double> points,
                       const Matrix44m *matrix = nullptr) {
    std::size_t next = 0;
    for (CVertexO &vertex : layer.cm.vert) {
        if (vertex.IsD()) continue;
        Point3m p;
        for (int k = 0; k < 3; ++k) p[k] = static_cast<Scalarm>(points[next++]);
        vertex.P() = matrix ? *matrix * p : p;
    }
    layer.updateBoxAndNormals();
}

/** Gives each vertex of the layer its number of `values` as quality. */
inline void set_quality(MeshModel &layer, moulage::View<double> values) {
    layer.updateDataMask(MeshModel::MM_VERTQUALITY);
    std::size_t next = 0;
    for (CVertexO &vertex : layer.cm.vert)
        if (!vertex.IsD()) vertex.Q() = static_cast<Scalarm>(values[next++]);
}

#endif
