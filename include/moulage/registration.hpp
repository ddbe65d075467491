/** A template skeleton follows a person's surface or image. */
#ifndef MOULAGE_REGISTRATION_HPP
#define MOULAGE_REGISTRATION_HPP

#include "run.hpp"
#include "skeletons.hpp"
#include "volumes.hpp"

namespace moulage {

inline MlgRegistrationOptions registration_options() {
    return defaults(mlg_registration_options_init);
}

/** A registered skeleton. */
class RegistrationResult : public Owner<MlgRegistrationResult, mlg_registration_result_free> {
public:
    using Owner::Owner;
    static RegistrationResult of(const Run &run) {
        return RegistrationResult(make(mlg_run_wait_registration, run.get()));
    }
    /** The person's skeleton. */
    Skeleton skeleton() const {
        return Skeleton(made<MlgSkeleton>(mlg_registration_result_skeleton, as_const()));
    }
    MlgRegistrationSummary summary() const {
        return filled<MlgRegistrationSummary>(mlg_registration_result_summary, as_const());
    }
    /** How far the whole can be trusted: "GOOD", "DOUBTFUL", "FAILED". */
    std::string verdict_name() const { return mlg_verdict_name(summary().verdict); }
    MlgBoneFit bone_fit(std::size_t bone) const {
        return filled<MlgBoneFit>(mlg_registration_result_bone_fit, as_const(), bone);
    }
    /** Why a bone is not good and what can be done about it, one sentence per line, worst first. */
    std::string bone_reasons(std::size_t bone) const {
        return text(mlg_registration_result_bone_reasons, as_const(), bone);
    }
    MlgJointPose joint_pose(std::size_t joint) const {
        return filled<MlgJointPose>(mlg_registration_result_joint_pose, as_const(), joint);
    }
    /** Of the shape model, in standard deviations; empty without one. */
    MOULAGE_LENDS(double, coefficients, mlg_registration_result_coefficients, 1)
    /** Whether each vertex of the skeleton lies on the target, 0 to 1; what does not is a guess. */
    MOULAGE_LENDS(double, seen, mlg_registration_result_seen, 1)
    /** Moves a soft tissue surface with the bones. */
    std::vector<double> carry(const TriMesh &tissue) const {
        std::vector<double> points(tissue.points().size);
        call(mlg_registration_result_carry, as_const(), tissue.as_const(), points.data());
        return points;
    }
    /** What to look at: why the whole is not good, then the worst bones and joints; one sentence per line. */
    std::string warnings() const { return text(mlg_registration_result_warnings, as_const()); }
};

/** A template skeleton and what it is to follow. */
class Registration : public Owner<MlgRegistration, mlg_registration_free> {
public:
    explicit Registration(const Skeleton &skeleton)
        : Owner(make(mlg_registration_new, skeleton.as_const())) {}
    /** One surface of all bones, which may be fused. */
    void set_target(const TriMesh &surface) {
        call(mlg_registration_set_target, get(), surface.as_const());
    }
    void set_bone_target(std::size_t bone, const TriMesh &surface) {
        call(mlg_registration_set_bone_target, get(), bone, surface.as_const());
    }
    /** An image of the person, and one of the same kind in which the template lies on the bones. */
    void set_image(const Volume &person, const Volume &reference) {
        call(mlg_registration_set_image, get(), person.as_const(), reference.as_const());
    }
    void set_shape_model(const ShapeModel &model) {
        call(mlg_registration_set_shape_model, get(), model.as_const());
    }
    /** The shape model that the template's file names, if any. */
    void set_shape_model_of_template() {
        const MlgShapeModel *named = nullptr;
        call(mlg_registration_set_shape_model, get(), named);
    }
    RunOf<RegistrationResult> start(const MlgRegistrationOptions &options = registration_options()) const {
        return RunOf<RegistrationResult>(made<MlgRun>(mlg_registration_start, as_const(), &options));
    }
    RegistrationResult run(const MlgRegistrationOptions &options = registration_options()) const {
        return RegistrationResult(
            made<MlgRegistrationResult>(mlg_registration_run, as_const(), &options));
    }
};

}  // namespace moulage

#endif
