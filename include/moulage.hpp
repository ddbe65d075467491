/** C++17 over moulage.h: owners that free, errors that are thrown. Nothing is declared twice; the
 * options and summaries are the C structs. */
#ifndef MOULAGE_HPP
#define MOULAGE_HPP

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "moulage.h"

namespace moulage {

/** A failed call; what() is the library's sentence. */
class Error : public std::runtime_error {
public:
    Error(MlgStatus status, const std::string &message) : std::runtime_error(message), status_(status) {}
    MlgStatus status() const noexcept { return status_; }

private:
    MlgStatus status_;
};

/** Calls a C function with the arguments and an MlgError; throws if it fails. */
template <class Function, class... Arguments>
void call(Function function, Arguments... arguments) {
    MlgError error = {MLG_STATUS_OK, ""};
    const MlgStatus status = function(arguments..., &error);
    if (status != MLG_STATUS_OK) throw Error(status, error.message);
}

/** A list borrowed from a handle; valid as long as its owner lives. */
template <class T> struct View {
    const T *data = nullptr;
    std::size_t size = 0;
    const T *begin() const { return data; }
    const T *end() const { return data + size; }
    const T &operator[](std::size_t i) const { return data[i]; }
};

/** A list as the functions below take it. */
template <class T> View<T> view_of(const std::vector<T> &list) { return {list.data(), list.size()}; }

/** The number of rows of `width` numbers in a flat list; throws when the last one is not whole. */
template <class T> std::size_t rows(View<T> list, std::size_t width, const char *name) {
    if (list.size % width != 0)
        throw Error(MLG_STATUS_INVALID_ARGUMENT,
                    std::string(name) + ": " + std::to_string(list.size) + " numbers, but " +
                        std::to_string(width) + " of them belong together");
    return list.size / width;
}

/** Throws unless there are as many of the one as of the other. */
inline void check_same(std::size_t count, const char *name, std::size_t wanted, const char *of) {
    if (count != wanted)
        throw Error(MLG_STATUS_INVALID_ARGUMENT,
                    std::to_string(count) + " " + name + " for " + std::to_string(wanted) + " " + of);
}

/** Weights for a call; NULL, that is 1 throughout, when they are left out. */
inline const double *weights_for(View<double> weights, std::size_t count) {
    if (weights.size == 0) return nullptr;
    check_same(weights.size, "weights", count, "points");
    return weights.data;
}

/** Owns a handle; move-only. */
template <class Handle, void (*Free)(Handle *)> class Owner {
public:
    Owner() = default;
    explicit Owner(Handle *handle) : handle_(handle) {}
    Handle *get() const noexcept { return handle_.get(); }
    const Handle *as_const() const noexcept { return handle_.get(); }

protected:
    /** A text that a C function writes into a buffer. */
    template <class Function> static std::string text(Function function, const Handle *handle) {
        std::size_t length = 0;
        call(function, handle, nullptr, std::size_t(0), &length);
        std::string text(length + 1, '\0');
        call(function, handle, &text[0], text.size(), &length);
        text.resize(length);
        return text;
    }

    /** Makes a handle by a C function whose last arguments are the out handle and the error. */
    template <class Made = Handle, class Function, class... Arguments>
    static Made *make(Function function, Arguments... arguments) {
        Made *handle = nullptr;
        call(function, arguments..., &handle);
        return handle;
    }

    /** A borrowed list of `width` numbers per element. */
    template <class T>
    View<T> view(const T *(*getter)(const Handle *, std::size_t *), std::size_t width) const {
        std::size_t count = 0;
        const T *data = getter(get(), &count);
        return {data, width * count};
    }

private:
    struct Deleter {
        void operator()(Handle *handle) const noexcept { Free(handle); }
    };
    std::unique_ptr<Handle, Deleter> handle_;
};

/** Points and indices are flat lists: x, y, z of each point, three indices of each triangle. */
class TriMesh : public Owner<MlgTriMesh, mlg_tri_mesh_free> {
public:
    TriMesh(const std::vector<double> &points, const std::vector<std::uint32_t> &triangles)
        : Owner(make(mlg_tri_mesh_new, points.data(), rows(view_of(points), 3, "points"),
                     triangles.data(), rows(view_of(triangles), 3, "triangles"))) {}
    explicit TriMesh(const std::string &path) : Owner(make(mlg_tri_mesh_load, path.c_str())) {}
    View<double> points() const && = delete;
    View<double> points() const & { return view(mlg_tri_mesh_points, 3); }
    View<std::uint32_t> triangles() const && = delete;
    View<std::uint32_t> triangles() const & { return view(mlg_tri_mesh_triangles, 3); }
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
    /** What is wrong with the surface, one sentence per line; empty for a clean, closed one. */
    std::string check() const { return text(mlg_tri_mesh_check, as_const()); }
    /** Writes the surface with moved points, or its own when none are given. */
    void save(const std::string &path, View<double> points = {}) const {
        call(mlg_tri_mesh_save, get(), points.data, rows(points, 3, "points"), path.c_str());
    }
};

/** Tets: x, y, z of each point, four indices of each tet. */
class TetMesh : public Owner<MlgTetMesh, mlg_tet_mesh_free> {
public:
    TetMesh(View<double> points, View<std::uint32_t> tets)
        : Owner(make(mlg_tet_mesh_new, points.data, rows(points, 3, "points"), tets.data,
                     rows(tets, 4, "tets"))) {}
    explicit TetMesh(const std::string &path) : Owner(make(mlg_tet_mesh_load, path.c_str())) {}
    View<double> points() const && = delete;
    View<double> points() const & { return view(mlg_tet_mesh_points, 3); }
    View<std::uint32_t> tets() const && = delete;
    View<std::uint32_t> tets() const & { return view(mlg_tet_mesh_tets, 4); }
    void save(const std::string &path) const { call(mlg_tet_mesh_save, as_const(), path.c_str()); }
};

class Markers : public Owner<MlgMarkers, mlg_markers_free> {
public:
    explicit Markers(const std::vector<double> &points, const std::vector<double> &weights = {})
        : Owner(make(mlg_markers_new, points.data(),
                     weights_for(view_of(weights), rows(view_of(points), 3, "points")), nullptr,
                     points.size() / 3)) {}
    explicit Markers(const std::string &path) : Owner(make(mlg_markers_load, path.c_str())) {}
    View<double> points() const && = delete;
    View<double> points() const & { return view(mlg_markers_points, 3); }
    View<double> weights() const && = delete;
    View<double> weights() const & { return view(mlg_markers_weights, 1); }
    void save(const std::string &path) const { call(mlg_markers_save, as_const(), path.c_str()); }
};

/** Places on a template with their targets: landmarks or attachments. */
class Pairs : public Owner<MlgPairs, mlg_pairs_free> {
public:
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
    View<double> template_points() const && = delete;
    View<double> template_points() const & { return view(mlg_pairs_template_points, 3); }
    View<double> targets() const && = delete;
    View<double> targets() const & { return view(mlg_pairs_targets, 3); }

private:
    using Owner::Owner;
};

inline MlgTetrahedralizationOptions tetrahedralization_options() {
    MlgTetrahedralizationOptions options;
    mlg_tetrahedralization_options_init(&options, sizeof options);
    return options;
}

class Tetrahedralization : public Owner<MlgTetrahedralization, mlg_tetrahedralization_free> {
public:
    using Owner::Owner;
    explicit Tetrahedralization(
        const TriMesh &surface,
        const MlgTetrahedralizationOptions &options = tetrahedralization_options())
        : Owner(make(mlg_tetrahedralization_run, surface.as_const(), &options)) {}
    View<double> points() const && = delete;
    View<double> points() const & { return view(mlg_tetrahedralization_points, 3); }
    View<std::uint32_t> tets() const && = delete;
    View<std::uint32_t> tets() const & { return view(mlg_tetrahedralization_tets, 4); }
    MlgTetQuality quality() const {
        MlgTetQuality quality = {};
        quality.struct_size = sizeof quality;
        call(mlg_tetrahedralization_quality, as_const(), &quality);
        return quality;
    }
    std::vector<std::string> warnings() const {
        std::vector<std::string> all;
        for (std::size_t i = 0; i < mlg_tetrahedralization_warning_count(get()); ++i)
            all.emplace_back(mlg_tetrahedralization_warning(get(), i));
        return all;
    }
};

class ReshapingResult : public Owner<MlgReshapingResult, mlg_reshaping_result_free> {
public:
    using Owner::Owner;
    View<double> points() const && = delete;
    View<double> points() const & { return view(mlg_reshaping_result_points, 3); }
    View<double> tet_points() const && = delete;
    View<double> tet_points() const & { return view(mlg_reshaping_result_tet_points, 3); }
    View<double> marker_distances() const && = delete;
    View<double> marker_distances() const & { return view(mlg_reshaping_result_marker_distances, 1); }
    View<double> max_stretches() const && = delete;
    View<double> max_stretches() const & { return view(mlg_reshaping_result_max_stretches, 1); }
    View<double> min_stretches() const && = delete;
    View<double> min_stretches() const & { return view(mlg_reshaping_result_min_stretches, 1); }
    MlgReshapingSummary summary() const {
        MlgReshapingSummary summary = {};
        summary.struct_size = sizeof summary;
        call(mlg_reshaping_result_summary, get(), &summary);
        return summary;
    }
    /** Moves other points with the template. */
    std::vector<double> carry(std::vector<double> points) const {
        call(mlg_reshaping_result_carry, get(), points.data(), rows(view_of(points), 3, "points"),
             points.data());
        return points;
    }
};

/** Bones and joints. */
class Skeleton : public Owner<MlgSkeleton, mlg_skeleton_free> {
public:
    using Owner::Owner;
    explicit Skeleton(const std::string &path) : Owner(make(mlg_skeleton_load, path.c_str())) {}
    Skeleton(const std::vector<MlgBone> &bones, const std::vector<MlgJoint> &joints)
        : Owner(make(mlg_skeleton_new, bones.data(), bones.size(), joints.data(), joints.size())) {}
    std::size_t bone_count() const { return mlg_skeleton_bone_count(get()); }
    std::size_t joint_count() const { return mlg_skeleton_joint_count(get()); }
    std::string bone_name(std::size_t bone) const {
        const char *name = mlg_skeleton_bone_name(get(), bone);
        return name == nullptr ? "" : name;
    }
    View<double> bone_points(std::size_t bone) const && = delete;
    View<double> bone_points(std::size_t bone) const & {
        std::size_t count = 0;
        const double *data = mlg_skeleton_bone_points(get(), bone, &count);
        return {data, 3 * count};
    }
    View<std::uint32_t> bone_triangles(std::size_t bone) const && = delete;
    View<std::uint32_t> bone_triangles(std::size_t bone) const & {
        std::size_t count = 0;
        const std::uint32_t *data = mlg_skeleton_bone_triangles(get(), bone, &count);
        return {data, 3 * count};
    }
    View<double> points() const && = delete;
    View<double> points() const & { return view(mlg_skeleton_points, 3); }
    MlgJoint joint(std::size_t number) const {
        MlgJoint joint = {};
        joint.struct_size = sizeof joint;
        call(mlg_skeleton_joint, as_const(), number, &joint);
        return joint;
    }
    void save(const std::string &path) const { call(mlg_skeleton_save, as_const(), path.c_str()); }
};

/** Named angles of a skeleton's joints over time. */
class Motion : public Owner<MlgMotion, mlg_motion_free> {
public:
    Motion(const Skeleton &skeleton, const std::string &path,
           const std::vector<const char *> &flipped = {})
        : Owner(make(mlg_motion_load, skeleton.as_const(), path.c_str(), flipped.data(),
                     flipped.size())) {}
    View<double> times() const && = delete;
    View<double> times() const & { return view(mlg_motion_times, 1); }
    /** One frame after the other. */
    View<double> angles() const && = delete;
    View<double> angles() const & { return view(mlg_motion_angles, 1); }
    std::string notes() const { return mlg_motion_notes(get()); }
    void save(const std::string &path) const { call(mlg_motion_save, as_const(), path.c_str()); }
};

/** Shapes of all bones of a template together. */
class ShapeModel : public Owner<MlgShapeModel, mlg_shape_model_free> {
public:
    ShapeModel(const Skeleton &skeleton, const std::string &path)
        : Owner(make(mlg_shape_model_load, skeleton.as_const(), path.c_str())) {}
    /** Learnt from skeletons with the template's bones, two or more, in any pose. */
    static ShapeModel fit(const Skeleton &skeleton, const std::vector<const MlgSkeleton *> &samples) {
        return ShapeModel(
            make(mlg_shape_model_fit, skeleton.as_const(), samples.data(), samples.size()));
    }
    void save(const std::string &path) const { call(mlg_shape_model_save, as_const(), path.c_str()); }
    View<double> deviations() const && = delete;
    View<double> deviations() const & { return view(mlg_shape_model_deviations, 1); }
    View<double> explained() const && = delete;
    View<double> explained() const & { return view(mlg_shape_model_explained, 1); }
    /** The shape at some coefficients, in standard deviations. */
    Skeleton shape(const std::vector<double> &coefficients = {}) const {
        return Skeleton(make<MlgSkeleton>(mlg_shape_model_shape, as_const(), coefficients.data(),
                                          coefficients.size()));
    }

private:
    using Owner::Owner;
};

class RegistrationResult : public Owner<MlgRegistrationResult, mlg_registration_result_free> {
public:
    using Owner::Owner;
    /** The person's skeleton. */
    Skeleton skeleton() const {
        return Skeleton(make<MlgSkeleton>(mlg_registration_result_skeleton, as_const()));
    }
    MlgRegistrationSummary summary() const {
        MlgRegistrationSummary summary = {};
        summary.struct_size = sizeof summary;
        call(mlg_registration_result_summary, as_const(), &summary);
        return summary;
    }
    MlgBoneFit bone_fit(std::size_t bone) const {
        MlgBoneFit fit = {};
        fit.struct_size = sizeof fit;
        call(mlg_registration_result_bone_fit, as_const(), bone, &fit);
        return fit;
    }
    /** Of the shape model, in standard deviations; empty without one. */
    View<double> coefficients() const && = delete;
    View<double> coefficients() const & { return view(mlg_registration_result_coefficients, 1); }
    /** Moves a soft tissue surface with the bones. */
    std::vector<double> carry(const TriMesh &tissue) const {
        std::vector<double> points(tissue.points().size);
        call(mlg_registration_result_carry, as_const(), tissue.as_const(), points.data());
        return points;
    }
    /** What to look at, one sentence per line. */
    std::string warnings() const { return text(mlg_registration_result_warnings, as_const()); }
};

/** Bodies that were pushed apart. */
class SeparationResult : public Owner<MlgSeparationResult, mlg_separation_result_free> {
public:
    using Owner::Owner;
    /** The surface of a body. */
    View<double> points(std::size_t body) const && = delete;
    View<double> points(std::size_t body) const & {
        std::size_t count = 0;
        const double *data = mlg_separation_result_points(get(), body, &count);
        return {data, 3 * count};
    }
    View<double> tet_points(std::size_t body) const && = delete;
    View<double> tet_points(std::size_t body) const & {
        std::size_t count = 0;
        const double *data = mlg_separation_result_tet_points(get(), body, &count);
        return {data, 3 * count};
    }
    MlgSeparationSummary summary() const {
        MlgSeparationSummary summary = {};
        summary.struct_size = sizeof summary;
        call(mlg_separation_result_summary, as_const(), &summary);
        return summary;
    }
    MlgOverlap overlap(std::size_t number) const {
        MlgOverlap overlap = {};
        overlap.struct_size = sizeof overlap;
        call(mlg_separation_result_overlap, as_const(), number, &overlap);
        return overlap;
    }
    MlgSeparatedBody body(std::size_t number) const {
        MlgSeparatedBody body = {};
        body.struct_size = sizeof body;
        call(mlg_separation_result_body, as_const(), number, &body);
        return body;
    }
};

/** A computation under way; leaving its scope cancels it and waits for its end. */
class Run : public Owner<MlgRun, mlg_run_free> {
public:
    using Owner::Owner;
    MlgProgress poll() const {
        MlgProgress progress = {};
        progress.struct_size = sizeof progress;
        call(mlg_run_poll, get(), &progress);
        return progress;
    }
    void cancel() const { mlg_run_cancel(get()); }
    /** The latest shape; empty before the first one. */
    std::vector<double> preview() const {
        std::vector<double> points;
        std::size_t count = 0;
        do {
            points.resize(3 * count);
            call(mlg_run_preview_points, get(), points.data(), points.size() / 3, &count);
        } while (3 * count > points.size());
        points.resize(3 * count);
        return points;
    }
    ReshapingResult wait() const {
        return ReshapingResult(make<MlgReshapingResult>(mlg_run_wait_reshaping, get()));
    }
    RegistrationResult wait_registration() const {
        return RegistrationResult(make<MlgRegistrationResult>(mlg_run_wait_registration, get()));
    }
    SeparationResult wait_separation() const {
        return SeparationResult(make<MlgSeparationResult>(mlg_run_wait_separation, get()));
    }
    Tetrahedralization wait_tets() const {
        return Tetrahedralization(
            make<MlgTetrahedralization>(mlg_run_wait_tetrahedralization, get()));
    }
};

/** Starts to fill a surface with tets. */
inline Run start_tets(const TriMesh &surface, const MlgTetrahedralizationOptions &options =
                                                  tetrahedralization_options()) {
    MlgRun *run = nullptr;
    call(mlg_tetrahedralization_start, surface.as_const(), &options, &run);
    return Run(run);
}

inline MlgReshapingOptions reshaping_options() {
    MlgReshapingOptions options;
    mlg_reshaping_options_init(&options, sizeof options);
    return options;
}

/** A template and the data it is to follow. Lists are flat, weights may be left out. */
class Reshaping : public Owner<MlgReshaping, mlg_reshaping_free> {
public:
    explicit Reshaping(const Tetrahedralization &tets)
        : Owner(make(mlg_reshaping_new, static_cast<const MlgTetrahedralization *>(tets.get()))) {}
    void set_markers(View<double> points, View<double> weights = {}) {
        const std::size_t count = rows(points, 3, "points");
        call(mlg_reshaping_set_markers, get(), points.data, weights_for(weights, count), count);
    }
    void set_landmarks(View<double> places, View<double> targets, View<double> weights = {}) {
        set_pairs(mlg_reshaping_set_landmarks, places, targets, weights);
    }
    void set_attachments(View<double> places, View<double> targets, View<double> weights = {}) {
        set_pairs(mlg_reshaping_set_attachments, places, targets, weights);
    }
    void set_landmarks(const Pairs &pairs) {
        call(mlg_reshaping_set_landmark_pairs, get(), pairs.as_const());
    }
    void set_attachments(const Pairs &pairs) {
        call(mlg_reshaping_set_attachment_pairs, get(), pairs.as_const());
    }
    /** What is suspicious, one sentence per line; throws if it cannot work. */
    std::string check() const { return text(mlg_reshaping_check, as_const()); }
    void set_fixed(View<std::uint32_t> vertices) {
        call(mlg_reshaping_set_fixed, get(), vertices.data, vertices.size);
    }
    Run start(const MlgReshapingOptions &options = reshaping_options()) const {
        MlgRun *run = nullptr;
        call(mlg_reshaping_start, as_const(), &options, &run);
        return Run(run);
    }
    /** From the shape of an earlier result for the same template and options. */
    Run start_again(const ReshapingResult &earlier,
                    const MlgReshapingOptions &options = reshaping_options()) const {
        MlgRun *run = nullptr;
        call(mlg_reshaping_start_again, earlier.as_const(), as_const(), &options, &run);
        return Run(run);
    }
    ReshapingResult run(const MlgReshapingOptions &options = reshaping_options()) const {
        return start(options).wait();
    }

private:
    template <class Function>
    void set_pairs(Function function, View<double> places, View<double> targets, View<double> weights) {
        const std::size_t count = rows(places, 3, "places");
        check_same(rows(targets, 3, "targets"), "targets", count, "places");
        call(function, get(), places.data, targets.data, weights_for(weights, count), count);
    }
};

inline MlgRegistrationOptions registration_options() {
    MlgRegistrationOptions options;
    mlg_registration_options_init(&options, sizeof options);
    return options;
}

inline MlgJoint joint() {
    MlgJoint joint;
    mlg_joint_init(&joint, sizeof joint);
    return joint;
}

/** A template skeleton and the surface it is to follow. */
class Registration : public Owner<MlgRegistration, mlg_registration_free> {
public:
    explicit Registration(const Skeleton &skeleton)
        : Owner(make(mlg_registration_new, skeleton.as_const())) {}
    void set_target(const TriMesh &surface) {
        call(mlg_registration_set_target, get(), surface.as_const());
    }
    void set_bone_target(std::size_t bone, const TriMesh &surface) {
        call(mlg_registration_set_bone_target, get(), bone, surface.as_const());
    }
    void set_shape_model(const ShapeModel &model) {
        call(mlg_registration_set_shape_model, get(), model.as_const());
    }
    Run start(const MlgRegistrationOptions &options = registration_options()) const {
        MlgRun *run = nullptr;
        call(mlg_registration_start, as_const(), &options, &run);
        return Run(run);
    }
    RegistrationResult run(const MlgRegistrationOptions &options = registration_options()) const {
        return start(options).wait_registration();
    }
};

inline MlgSeparationOptions separation_options() {
    MlgSeparationOptions options;
    mlg_separation_options_init(&options, sizeof options);
    return options;
}

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
    void add_obstacle(const std::string &name, const TriMesh &surface) {
        call(mlg_separation_add_obstacle, get(), name.c_str(), surface.as_const());
    }
    void set_markers(std::size_t body, View<double> points) {
        call(mlg_separation_set_markers, get(), body, points.data, rows(points, 3, "points"));
    }
    Run start(const MlgSeparationOptions &options = separation_options()) const {
        MlgRun *run = nullptr;
        call(mlg_separation_start, as_const(), &options, &run);
        return Run(run);
    }
    SeparationResult run(const MlgSeparationOptions &options = separation_options()) const {
        return start(options).wait_separation();
    }
};

/** Throws if the library that was loaded does not fit this header. */
inline void check_version() {
    if (mlg_abi_version() != MLG_ABI_VERSION)
        throw Error(MLG_STATUS_UNSUPPORTED, "the moulage library and its header do not fit");
}

}  // namespace moulage

#endif
