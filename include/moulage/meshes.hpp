/** Surfaces, tet meshes, and the lines in which planes cut surfaces. */
#ifndef MOULAGE_MESHES_HPP
#define MOULAGE_MESHES_HPP

#include "owners.hpp"

namespace moulage {

/** Lines, one after the other. */
class Polylines : public Owner<MlgPolylines, mlg_polylines_free> {
public:
    using Owner::Owner;
    MOULAGE_LENDS(double, points, mlg_polylines_points, 3)
    /** Where each line begins among the points, and at the end their number. */
    MOULAGE_LENDS(std::size_t, starts, mlg_polylines_starts, 1)
    /** 1 for each line whose last point is joined to its first. */
    MOULAGE_LENDS(std::uint8_t, closed, mlg_polylines_closed, 1)
};

/** Points and indices are flat lists: x, y, z of each point, three indices of each triangle. */
class TriMesh : public Owner<MlgTriMesh, mlg_tri_mesh_free> {
public:
    using Owner::Owner;
    TriMesh(View<double> points, View<std::uint32_t> triangles)
        : Owner(make(mlg_tri_mesh_new, points.data, rows(points, 3, "points"), triangles.data,
                     rows(triangles, 3, "triangles"))) {}
    explicit TriMesh(const std::string &path) : Owner(make(mlg_tri_mesh_load, path.c_str())) {}
    MOULAGE_LENDS(double, points, mlg_tri_mesh_points, 3)
    MOULAGE_LENDS(std::uint32_t, triangles, mlg_tri_mesh_triangles, 3)
    /** Distance of each vertex to the nearest of some points. */
    std::vector<double> distances_to(View<double> to) const {
        std::vector<double> distances(points().size / 3);
        call(mlg_tri_mesh_distances_to_points, as_const(), to.data, rows(to, 3, "points"),
             distances.data());
        return distances;
    }
    /** Distance of each of some points to the surface. */
    std::vector<double> distances_of(View<double> of) const {
        std::vector<double> distances(rows(of, 3, "points"));
        call(mlg_tri_mesh_distances_of_points, as_const(), of.data, distances.size(), distances.data());
        return distances;
    }
    /** The place on the surface nearest to each of some points. */
    std::vector<double> closest_points(View<double> to) const {
        std::vector<double> places(to.size);
        call(mlg_tri_mesh_closest_points, as_const(), to.data, rows(to, 3, "points"), places.data());
        return places;
    }
    /** Values known at some points at each vertex; NaN where no point is near. */
    std::vector<double> interpolate(View<double> at, View<double> values) const {
        check_same(values.size, "values", rows(at, 3, "points"), "points");
        std::vector<double> found(points().size / 3);
        call(mlg_tri_mesh_interpolate, as_const(), at.data, values.data, values.size, found.data());
        return found;
    }
    /** Where the template has to go so that the markers lie on it: a 4x4 matrix, row by row. Landmarks
     * and their targets may be left out. */
    std::vector<double> align(std::uint32_t freedom, View<double> markers,
                              View<double> landmarks = {}, View<double> targets = {}) const {
        const std::size_t count = rows(landmarks, 3, "landmarks");
        check_same(rows(targets, 3, "targets"), "targets", count, "landmarks");
        std::vector<double> matrix(16);
        call(mlg_tri_mesh_align, as_const(), freedom, markers.data, rows(markers, 3, "markers"),
             landmarks.data, targets.data, count, matrix.data());
        return matrix;
    }
    /** The lines along which a plane cuts the surface, with moved points if they are given. */
    Polylines section(const Vector &plane_point, const Vector &plane_normal,
                      View<double> moved = {}) const {
        return Polylines(made<MlgPolylines>(mlg_tri_mesh_section, as_const(), moved.data,
                                            rows(moved, 3, "points"), plane_point.data(),
                                            plane_normal.data()));
    }
    /** What is wrong with the surface, one sentence per line; empty for a clean, closed one. */
    std::string check() const { return text(mlg_tri_mesh_check, as_const()); }
    /** Writes the surface with moved points, or its own when none are given. */
    void save(const std::string &path, View<double> moved = {}) const {
        call(mlg_tri_mesh_save, as_const(), moved.data, rows(moved, 3, "points"), path.c_str());
    }
};

/** Tets: x, y, z of each point, four indices of each tet. */
class TetMesh : public Owner<MlgTetMesh, mlg_tet_mesh_free> {
public:
    TetMesh(View<double> points, View<std::uint32_t> tets)
        : Owner(make(mlg_tet_mesh_new, points.data, rows(points, 3, "points"), tets.data,
                     rows(tets, 4, "tets"))) {}
    explicit TetMesh(const std::string &path) : Owner(make(mlg_tet_mesh_load, path.c_str())) {}
    MOULAGE_LENDS(double, points, mlg_tet_mesh_points, 3)
    MOULAGE_LENDS(std::uint32_t, tets, mlg_tet_mesh_tets, 4)
    void save(const std::string &path) const { call(mlg_tet_mesh_save, as_const(), path.c_str()); }
};

/** The motion that brings points nearest to their targets: a 4x4 matrix, row by row. */
inline std::vector<double> align_points(std::uint32_t freedom, View<double> points, View<double> targets) {
    const std::size_t count = rows(points, 3, "points");
    check_same(rows(targets, 3, "targets"), "targets", count, "points");
    std::vector<double> matrix(16);
    call(mlg_points_align, freedom, points.data, targets.data, count, matrix.data());
    return matrix;
}

}  // namespace moulage

#endif
