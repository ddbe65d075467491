/** Skeletons, their motions, and statistics of their shapes. */
#ifndef MOULAGE_SKELETONS_HPP
#define MOULAGE_SKELETONS_HPP

#include <functional>

#include "meshes.hpp"

namespace moulage {

inline MlgJoint joint() { return defaults(mlg_joint_init); }

/** A bone to make a skeleton of; may go afterwards. */
struct Bone {
    std::string name;
    const TriMesh &surface;
};

/** Bones and joints. */
class Skeleton : public Owner<MlgSkeleton, mlg_skeleton_free> {
public:
    using Owner::Owner;
    explicit Skeleton(const std::string &path) : Owner(make(mlg_skeleton_load, path.c_str())) {}
    explicit Skeleton(const std::vector<Bone> &bones, const std::vector<MlgJoint> &joints = {})
        : Owner(make(mlg_skeleton_new, structs(bones).data(), bones.size(), joints.data(),
                     joints.size())) {}
    std::size_t bone_count() const { return mlg_skeleton_bone_count(as_const()); }
    std::size_t joint_count() const { return mlg_skeleton_joint_count(as_const()); }
    /** Empty if there is no bone of that number. */
    std::string bone_name(std::size_t bone) const {
        return text_or_empty(mlg_skeleton_bone_name(as_const(), bone));
    }
    MOULAGE_LENDS_OF_EACH(double, bone_points, mlg_skeleton_bone_points, 3)
    MOULAGE_LENDS_OF_EACH(std::uint32_t, bone_triangles, mlg_skeleton_bone_triangles, 3)
    /** Of all bones, one after the other. */
    MOULAGE_LENDS(double, points, mlg_skeleton_points, 3)
    /** Its name is lent. */
    MlgJoint joint(std::size_t number) const & {
        return filled<MlgJoint>(mlg_skeleton_joint, as_const(), number);
    }
    MlgJoint joint(std::size_t number) const && = delete;
    /** The named angles of the joints in the skeleton's pose, radians. */
    MOULAGE_LENDS(double, angles, mlg_skeleton_angles, 1)
    std::string angle_name(std::size_t angle) const {
        return text_or_empty(mlg_skeleton_angle_name(as_const(), angle));
    }
    /** What was left out when it was read, one sentence per line. */
    std::string notes() const { return text_or_empty(mlg_skeleton_notes(as_const())); }
    void save(const std::string &path) const { call(mlg_skeleton_save, as_const(), path.c_str()); }
    /** A scene that moves as a motion file says. */
    void save_motion(const std::string &motion_path, const std::string &path,
                     View<const char *> flipped = {}, double unit_in_metres = 0) const {
        call(mlg_skeleton_save_motion, as_const(), motion_path.c_str(), flipped.data, flipped.size,
             unit_in_metres, path.c_str());
    }
    /** Into the OpenSim model that the template came from, with the template's density; returns what was
        not carried over. */
    std::string save_osim(const std::string &model_path, const std::string &path) const {
        return notes_of([&](char *notes, std::size_t capacity, std::size_t *length) {
            call(mlg_skeleton_save_osim, as_const(), model_path.c_str(), path.c_str(), notes, capacity,
                 length);
        });
    }
    /** The same with the person's mass. */
    std::string save_osim(const std::string &model_path, const std::string &path, double kilograms) const {
        return notes_of([&](char *notes, std::size_t capacity, std::size_t *length) {
            call(mlg_skeleton_save_osim_mass, as_const(), model_path.c_str(), kilograms, path.c_str(),
                 notes, capacity, length);
        });
    }

private:
    template <typename Write> static std::string notes_of(const Write &write) {
        std::string notes(1 << 16, '\0');
        std::size_t length = 0;
        write(&notes[0], notes.size(), &length);
        notes.resize(length < notes.size() ? length : notes.size() - 1);
        return notes;
    }
    static std::vector<MlgBone> structs(const std::vector<Bone> &bones) {
        std::vector<MlgBone> all;
        for (const Bone &bone : bones)
            all.push_back({sizeof(MlgBone), bone.name.c_str(), bone.surface.as_const()});
        return all;
    }
};

/** Named angles of a skeleton's joints over time. */
class Motion : public Owner<MlgMotion, mlg_motion_free> {
public:
    /** `flipped`: names of angles of the opposite sign. */
    Motion(const Skeleton &skeleton, const std::string &path, View<const char *> flipped = {})
        : Owner(make(mlg_motion_load, skeleton.as_const(), path.c_str(), flipped.data,
                     flipped.size)) {}
    /** `times`: seconds, rising. `angles`: one frame after the other, radians. */
    Motion(const Skeleton &skeleton, View<const char *> names, View<double> times,
           View<double> angles)
        : Owner(make(mlg_motion_new, skeleton.as_const(), names.data, names.size, times.data,
                     checked(angles, names.size * times.size), times.size)) {}
    MOULAGE_LENDS(double, times, mlg_motion_times, 1)
    /** One frame after the other. */
    MOULAGE_LENDS(double, angles, mlg_motion_angles, 1)
    std::string angle_name(std::size_t angle) const {
        return text_or_empty(mlg_motion_angle_name(as_const(), angle));
    }
    std::string notes() const { return text_or_empty(mlg_motion_notes(as_const())); }
    void save(const std::string &path) const { call(mlg_motion_save, as_const(), path.c_str()); }

private:
    static const double *checked(View<double> angles, std::size_t count) {
        check_same(angles.size, "angles", count, "names and times");
        return angles.data;
    }
};

/** Skeletons with a template's bones and vertices, in any pose. */
using Samples = std::vector<std::reference_wrapper<const Skeleton>>;

/** Shapes of all bones of a template together. */
class ShapeModel : public Owner<MlgShapeModel, mlg_shape_model_free> {
public:
    ShapeModel(const Skeleton &skeleton, const std::string &path)
        : Owner(make(mlg_shape_model_load, skeleton.as_const(), path.c_str())) {}
    /** Learnt from two samples or more. */
    ShapeModel(const Skeleton &skeleton, const Samples &samples)
        : Owner(make(mlg_shape_model_fit, skeleton.as_const(), handles(samples).data(),
                     samples.size())) {}
    /** How well models fit new persons: for each of three or more samples, the distance from what a model of
     * the others makes of it. */
    static std::vector<double> left_out(const Skeleton &skeleton, const Samples &samples) {
        std::vector<double> distances(samples.size());
        call(mlg_shape_model_left_out, skeleton.as_const(), handles(samples).data(), samples.size(),
             distances.data());
        return distances;
    }
    void save(const std::string &path) const {
        call(mlg_shape_model_save, as_const(), path.c_str());
    }
    MOULAGE_LENDS(double, deviations, mlg_shape_model_deviations, 1)
    MOULAGE_LENDS(double, explained, mlg_shape_model_explained, 1)
    /** The shape at some coefficients, in standard deviations. */
    Skeleton shape(View<double> coefficients = {}) const {
        return Skeleton(made<MlgSkeleton>(mlg_shape_model_shape, as_const(), coefficients.data,
                                          coefficients.size));
    }

private:
    static std::vector<const MlgSkeleton *> handles(const Samples &samples) {
        std::vector<const MlgSkeleton *> all;
        for (const Skeleton &sample : samples) all.push_back(sample.as_const());
        return all;
    }
};

}  // namespace moulage

#endif
