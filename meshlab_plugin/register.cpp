// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_moulage.h"

#include <algorithm>

#include "layers.h"

namespace {

/** A template of which each bone may have a layer. */
struct LayeredSkeleton {
    moulage::Skeleton skeleton;
    std::vector<MeshModel *> layers;
};

LayeredSkeleton skeleton_from_file(MeshDocument &document, const MeshModel &target,
                                   const std::string &path) {
    LayeredSkeleton found{moulage::Skeleton(path), {}};
    for (std::size_t b = 0; b < found.skeleton.bone_count(); ++b) {
        const QString name = QString::fromStdString(found.skeleton.bone_name(b));
        found.layers.push_back(nullptr);
        for (MeshModel &candidate : document.meshIterator()) {
            QString label = candidate.label();
            label = label.left(label.lastIndexOf('.') > 0 ? label.lastIndexOf('.') : label.size());
            if (candidate.id() == target.id() || (label != name && candidate.label() != name))
                continue;
            if (std::size_t(candidate.cm.vn) != found.skeleton.bone_points(b).size / 3)
                fail(QString("The layer \"%1\" has %2 vertices and the bone of that name %3; rename "
                             "the layer, or load the bone's own mesh.")
                         .arg(candidate.label())
                         .arg(candidate.cm.vn)
                         .arg(found.skeleton.bone_points(b).size / 3));
            found.layers.back() = &candidate;
        }
    }
    return found;
}

LayeredSkeleton skeleton_from_layers(MeshDocument &document, const MeshModel &target,
                                     const RichParameterList &parameters) {
    std::vector<MeshModel *> layers;
    std::vector<std::string> names;
    std::vector<moulage::TriMesh> surfaces;
    for (MeshModel &candidate : document.meshIterator()) {
        if (candidate.id() == target.id() || !candidate.isVisible()) continue;
        need_faces(candidate);
        layers.push_back(&candidate);
        names.push_back(name_of(candidate));
        surfaces.push_back(surface_in_scene(candidate));
    }
    if (layers.empty())
        fail("There is no bone: name a skeleton file, or show the layers that are its bones.");
    std::vector<moulage::Bone> bones;
    for (std::size_t b = 0; b < layers.size(); ++b) bones.push_back({names[b], surfaces[b]});

    const double limit = double(parameters.getFloat("joint_limit")) * M_PI / 180;
    std::vector<MlgJoint> joints;
    std::vector<std::string> joint_names;
    const QStringList wanted = parameters.getString("joints").split(',', Qt::SkipEmptyParts);
    joint_names.reserve(std::size_t(wanted.size()));
    for (const QString &pair : wanted) {
        const auto bones_of_joint = named_pair(pair, names, names);
        if (!bones_of_joint)
            fail(QString("The joint \"%1\" does not name two visible bone layers as parent-child.")
                     .arg(pair.trimmed()));
        MlgJoint joint = moulage::joint();
        joint.parent = static_cast<std::uint32_t>(bones_of_joint->first);
        joint.child = static_cast<std::uint32_t>(bones_of_joint->second);
        joint_names.push_back(pair.trimmed().toUtf8().toStdString());
        joint.name = joint_names.back().c_str();
        std::fill_n(joint.negative_limits, 3, limit);
        std::fill_n(joint.positive_limits, 3, limit);
        joints.push_back(joint);
    }
    return {moulage::Skeleton(bones, joints), layers};
}

void add_bone_layer(MeshDocument &document, const moulage::Skeleton &skeleton, std::size_t bone) {
    MeshModel *made =
        document.addNewMesh("", QString::fromStdString(skeleton.bone_name(bone)), false);
    const auto points = skeleton.bone_points(bone);
    const auto triangles = skeleton.bone_triangles(bone);
    auto vertex = vcg::tri::Allocator<CMeshO>::AddVertices(made->cm, points.size / 3);
    for (std::size_t i = 0; i < points.size; i += 3, ++vertex)
        vertex->P() = Point3m(Scalarm(points[i]), Scalarm(points[i + 1]), Scalarm(points[i + 2]));
    auto face = vcg::tri::Allocator<CMeshO>::AddFaces(made->cm, triangles.size / 3);
    for (std::size_t i = 0; i < triangles.size; i += 3, ++face)
        for (std::size_t k = 0; k < 3; ++k) face->V(int(k)) = &made->cm.vert[triangles[i + k]];
    made->updateBoxAndNormals();
}

}  // namespace

FilterMoulage::Figures FilterMoulage::register_skeleton(const RichParameterList &parameters,
                                                        MeshDocument &document,
                                                        vcg::CallBackPos *callback) {
    MeshModel &target = layer(document, parameters, "target");
    need_faces(target);
    const std::string path = file(parameters, "skeleton");
    const LayeredSkeleton layered = path.empty()
                                        ? skeleton_from_layers(document, target, parameters)
                                        : skeleton_from_file(document, target, path);
    // Everything meets in the frame of the scene.
    moulage::Registration problem(layered.skeleton);
    problem.set_target(surface_in_scene(target));
    MlgRegistrationOptions options = moulage::registration_options();
    options.align = parameters.getBool("align") ? 1 : 0;
    options.as_is = parameters.getBool("as_is") ? 1 : 0;
    const auto run = problem.start(options);
    follow(run, callback, amount(parameters, "seconds"));
    const moulage::RegistrationResult result = run.wait();
    const moulage::Skeleton person = result.skeleton();
    const std::string save = file(parameters, "save", true);
    if (!save.empty()) person.save(save);

    for (std::size_t b = 0; b < person.bone_count(); ++b) {
        if (MeshModel *bone = layered.layers[b]) {
            set_points_in_scene(*bone, person.bone_points(b));
        } else {
            add_bone_layer(document, person, b);
        }
    }

    const MlgRegistrationSummary summary = result.summary();
    for (std::size_t b = 0; b < person.bone_count(); ++b) {
        const MlgBoneFit fit = result.bone_fit(b);
        log("%s: %s, residual %g, seen %i %%", person.bone_name(b).c_str(), mlg_verdict_name(fit.verdict),
            fit.mean_residual, int(100 * fit.seen));
    }
    log("The result is %s.", result.verdict_name().c_str());
    warn(result.warnings());
    if (summary.cancelled) warn("the time was over before the end; the bones are where they were then");
    log("%i bones: mean residual %g, largest %g; %i iterations, %.1f s", int(person.bone_count()),
        summary.mean_residual, summary.max_residual, int(summary.iterations), summary.seconds);
    return {{"verdict", int(summary.verdict)},
            {"mean_residual", summary.mean_residual},
            {"max_residual", summary.max_residual},
            {"suspicious_bones", int(summary.suspicious_bones)},
            {"failed_bones", int(summary.failed_bones)},
            {"joints_outside", int(summary.joints_outside)},
            {"cancelled", summary.cancelled != 0},
            {"iterations", int(summary.iterations)},
            {"seconds", summary.seconds}};
}
