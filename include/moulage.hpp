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
    Error(MlgStatus status, const char *message) : std::runtime_error(message), status_(status) {}
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

/** Owns a handle; move-only. */
template <class Handle, void (*Free)(Handle *)> class Owner {
public:
    Owner() = default;
    explicit Owner(Handle *handle) : handle_(handle) {}
    Handle *get() const noexcept { return handle_.get(); }

protected:
    /** Makes a handle by a C function whose last arguments are the out handle and the error. */
    template <class Function, class... Arguments>
    static Handle *make(Function function, Arguments... arguments) {
        Handle *handle = nullptr;
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
        : Owner(make(mlg_tri_mesh_new, points.data(), points.size() / 3, triangles.data(),
                     triangles.size() / 3)) {}
    explicit TriMesh(const std::string &path) : Owner(make(mlg_tri_mesh_load, path.c_str())) {}
    View<double> points() const { return view(mlg_tri_mesh_points, 3); }
    View<std::uint32_t> triangles() const { return view(mlg_tri_mesh_triangles, 3); }
    /** Writes the surface with moved points, or its own when none are given. */
    void save(const std::string &path, View<double> points = {}) const {
        call(mlg_tri_mesh_save, get(), points.data, points.size / 3, path.c_str());
    }
};

class Markers : public Owner<MlgMarkers, mlg_markers_free> {
public:
    explicit Markers(const std::string &path) : Owner(make(mlg_markers_load, path.c_str())) {}
    View<double> points() const { return view(mlg_markers_points, 3); }
    View<double> weights() const { return view(mlg_markers_weights, 1); }
};

inline MlgTetrahedralizationOptions tetrahedralization_options() {
    MlgTetrahedralizationOptions options;
    mlg_tetrahedralization_options_init(&options, sizeof options);
    return options;
}

class Tetrahedralization : public Owner<MlgTetrahedralization, mlg_tetrahedralization_free> {
public:
    explicit Tetrahedralization(
        const TriMesh &surface,
        const MlgTetrahedralizationOptions &options = tetrahedralization_options())
        : Owner(make(mlg_tetrahedralization_run, static_cast<const MlgTriMesh *>(surface.get()),
                     &options)) {}
    View<double> points() const { return view(mlg_tetrahedralization_points, 3); }
    View<std::uint32_t> tets() const { return view(mlg_tetrahedralization_tets, 4); }
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
    View<double> points() const { return view(mlg_reshaping_result_points, 3); }
    View<double> tet_points() const { return view(mlg_reshaping_result_tet_points, 3); }
    View<double> marker_distances() const { return view(mlg_reshaping_result_marker_distances, 1); }
    MlgReshapingSummary summary() const {
        MlgReshapingSummary summary = {};
        summary.struct_size = sizeof summary;
        call(mlg_reshaping_result_summary, get(), &summary);
        return summary;
    }
    /** Moves other points with the template. */
    std::vector<double> carry(std::vector<double> points) const {
        call(mlg_reshaping_result_carry, get(), points.data(), points.size() / 3, points.data());
        return points;
    }
};

/** A reshaping under way; leaving its scope cancels it and waits for its end. */
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
        MlgReshapingResult *result = nullptr;
        call(mlg_run_wait_reshaping, get(), &result);
        return ReshapingResult(result);
    }
};

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
        check(weights, points.size / 3);
        call(mlg_reshaping_set_markers, get(), points.data, weights.data, points.size / 3);
    }
    void set_landmarks(View<double> places, View<double> targets, View<double> weights = {}) {
        check(targets, places.size, weights);
        call(mlg_reshaping_set_landmarks, get(), places.data, targets.data, weights.data,
             places.size / 3);
    }
    void set_attachments(View<double> places, View<double> targets, View<double> weights = {}) {
        check(targets, places.size, weights);
        call(mlg_reshaping_set_attachments, get(), places.data, targets.data, weights.data,
             places.size / 3);
    }
    void set_fixed(View<std::uint32_t> vertices) {
        call(mlg_reshaping_set_fixed, get(), vertices.data, vertices.size);
    }
    Run start(const MlgReshapingOptions &options = reshaping_options()) const {
        MlgRun *run = nullptr;
        call(mlg_reshaping_start, static_cast<const MlgReshaping *>(get()), &options, &run);
        return Run(run);
    }
    ReshapingResult run(const MlgReshapingOptions &options = reshaping_options()) const {
        return start(options).wait();
    }

private:
    static void check(View<double> weights, std::size_t count) {
        if (weights.data != nullptr && weights.size != count)
            throw Error(MLG_STATUS_INVALID_ARGUMENT, "as many weights as points are needed");
    }
    static void check(View<double> targets, std::size_t size, View<double> weights) {
        if (targets.size != size)
            throw Error(MLG_STATUS_INVALID_ARGUMENT, "as many targets as places are needed");
        check(weights, size / 3);
    }
};

/** A list as the functions above take it. */
template <class T> View<T> view_of(const std::vector<T> &list) { return {list.data(), list.size()}; }

/** Throws if the library that was loaded does not fit this header. */
inline void check_version() {
    if (mlg_abi_version() != MLG_ABI_VERSION)
        throw Error(MLG_STATUS_UNSUPPORTED, "the moulage library and its header do not fit");
}

}  // namespace moulage

#endif
