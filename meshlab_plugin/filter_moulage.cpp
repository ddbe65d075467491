// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_moulage.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>

#include <Eigen/Core>
#include <vcg/complex/algorithms/update/color.h>

#include "mesh_arrays.h"

namespace {

/** Time between two looks at a run. MeshLab redraws at most every 100 ms. */
constexpr auto POLL = std::chrono::milliseconds(30);

/** What the vertex quality shows after a reshaping. */
enum Shown { KEPT, STRETCH, MARKER_DISTANCE };

[[noreturn]] void fail(const QString &sentence) { throw MLException(sentence); }

/** Follows a run with MeshLab's progress bar until it ends; stops it if MeshLab says so. */
void follow(const moulage::Run &run, vcg::CallBackPos *callback) {
    for (;;) {
        const MlgProgress progress = run.poll();
        if (progress.state != MLG_RUN_RUNNING) return;
        if (callback && !callback(static_cast<int>(100 * progress.fraction), progress.stage)) {
            run.cancel();
            fail("Stopped; nothing was changed.");
        }
        std::this_thread::sleep_for(POLL);
    }
}

MeshModel &layer(MeshDocument &document, const RichParameterList &parameters, const char *name) {
    MeshModel *found = document.getMesh(parameters.getMeshId(name));
    if (!found) fail(QString("The layer chosen as \"%1\" does not exist.").arg(name));
    return *found;
}

MeshModel &current(MeshDocument &document) {
    if (!document.mm()) fail("There is no current layer.");
    return *document.mm();
}

moulage::TriMesh surface_of(const MeshArrays &arrays) {
    return moulage::TriMesh(arrays.points, arrays.triangles);
}

void need_faces(const MeshModel &layer) {
    if (layer.cm.fn == 0)
        fail(QString("The layer \"%1\" has no faces; a surface is needed.").arg(layer.label()));
}

/** What takes a point of `layer` to where it is seen from `seen_from`. */
Matrix44m into(const MeshModel &seen_from, const MeshModel &layer) {
    return vcg::Inverse(seen_from.cm.Tr) * layer.cm.Tr;
}

/** The points of a layer in the frame of another one. */
std::vector<double> points_in(const MeshModel &seen_from, const MeshModel &layer) {
    if (layer.cm.vn == 0)
        fail(QString("The layer \"%1\" has no points.").arg(layer.label()));
    const Matrix44m matrix = into(seen_from, layer);
    return arrays_of(layer, seen_from.cm.Tr == layer.cm.Tr ? nullptr : &matrix).points;
}

std::string file(const RichParameterList &parameters, const char *name, bool save = false) {
    const QString path =
        save ? parameters.getSaveFileName(name) : parameters.getOpenFileName(name);
    return path.toUtf8().toStdString();
}

MlgTetrahedralizationOptions tet_options(const RichParameterList &parameters,
                                         const std::string &tetgen) {
    MlgTetrahedralizationOptions options = moulage::tetrahedralization_options();
    options.method = static_cast<std::uint32_t>(parameters.getEnum("tets"));
    options.tet_count = static_cast<std::uint32_t>(std::max(0, parameters.getInt("tet_count")));
    options.tetgen_path = tetgen.empty() ? nullptr : tetgen.c_str();
    return options;
}

void add_tet_parameters(RichParameterList &list, bool hidden) {
    const QString group = hidden ? "Tets" : "";
    list.addParam(RichEnum("tets", 0, {"Automatic", "TetGen", "Lattice"}, "Tets by",
                           "TetGen makes better tets where it is installed and the surface is "
                           "closed; the built-in lattice takes any surface.", hidden, group));
    list.addParam(RichInt("tet_count", 15000, "Number of tets",
                          "About how many tets fill the surface.", hidden, group));
    list.addParam(RichFileOpen("tetgen", "", QStringList(), "TetGen program",
                               "Where the program TetGen is; left empty, it is looked up.", hidden,
                               group));
}

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

FilterMoulage::FilterMoulage() {
    typeList = {RESHAPE, REGISTER, TETRAHEDRALIZE, DISTANCE};
    for (ActionIDType id : types()) actionList.push_back(new QAction(filterName(id), this));
}

QString FilterMoulage::filterName(ActionIDType filter) const {
    switch (filter) {
    case RESHAPE: return "Reshape Template to Markers";
    case REGISTER: return "Register Skeleton to Surface";
    case TETRAHEDRALIZE: return "Tetrahedralize (quality report)";
    case DISTANCE: return "Distance to Markers";
    default: return QString();
    }
}

QString FilterMoulage::pythonFilterName(ActionIDType filter) const {
    switch (filter) {
    case RESHAPE: return "apply_coord_reshape_to_markers";
    case REGISTER: return "apply_coord_register_skeleton";
    case TETRAHEDRALIZE: return "get_tetrahedralization_quality";
    case DISTANCE: return "compute_scalar_by_distance_to_markers_per_vertex";
    default: return QString();
    }
}

QString FilterMoulage::filterInfo(ActionIDType filter) const {
    switch (filter) {
    case RESHAPE:
        return "Puts the current layer, the <b>template</b> of an organ, bone or muscle, into one "
               "person's shape. The person is known by <b>markers</b>: points on the surface, such as "
               "clicks on the slices of a scan, given as a layer. Vertices, faces, texture "
               "coordinates, colours and the selection stay; only positions change. Layer matrices "
               "are respected.<br>The inside is filled with tets. Each may stretch for good, smoothly "
               "from one to the next, and the whole stays in elastic equilibrium.<br><br>"
               "See:<br><i>Bohan Wang, George Matcuk, Jernej Barbic</i><br>"
               "<b>\"Modeling of Personalized Anatomy using Plastic Strains\"</b><br>"
               "ACM Transactions on Graphics 40(2), 2021.";
    case REGISTER:
        return "Puts a template <b>skeleton</b>, separate bones with joints between them, on a "
               "<b>surface</b> of one person's bones, which may be fused. The skeleton is a "
               "<i>.skeleton.json</i> or OpenSim file, or all other visible layers, one per bone. Bones "
               "that have a layer of their name move; those of a file without a layer get one. Vertex "
               "order, texture coordinates and colours stay.<br><br>"
               "See:<br><i>Benjamin Gilles, Lionel Reveret, Dinesh Pai</i><br>"
               "<b>\"Creating and animating subject-specific anatomical models\"</b><br>"
               "Computer Graphics Forum 29(8), 2010.";
    case TETRAHEDRALIZE:
        return "Fills the current layer with tets, as the reshaping does, and reports how good they "
               "are: dihedral angles in degrees, radius ratios (1 for a regular tet, 0 for a flat "
               "one). The layer is not changed; the tets can be saved for ParaView.";
    case DISTANCE:
        return "Measures how well markers support and meet the current layer. The <b>quality</b> of "
               "each vertex becomes its distance to the nearest marker; returned are the distances of "
               "the markers to the surface.";
    default: return QString();
    }
}

FilterPlugin::FilterClass FilterMoulage::getClass(const QAction *action) const {
    switch (ID(action)) {
    case RESHAPE: return FilterClass(Smoothing | PointSet);
    case REGISTER: return Smoothing;
    case TETRAHEDRALIZE: return Measure;
    default: return FilterClass(Quality | VertexColoring);
    }
}

FilterPlugin::FilterArity FilterMoulage::filterArity(const QAction *action) const {
    return ID(action) == TETRAHEDRALIZE ? SINGLE_MESH : FIXED;
}

int FilterMoulage::getPreConditions(const QAction *action) const {
    return ID(action) == REGISTER ? MeshModel::MM_NONE : MeshModel::MM_FACENUMBER;
}

int FilterMoulage::postCondition(const QAction *action) const {
    const int moved = MeshModel::MM_VERTCOORD | MeshModel::MM_VERTNORMAL | MeshModel::MM_FACENORMAL;
    switch (ID(action)) {
    case RESHAPE: return moved | MeshModel::MM_VERTQUALITY;
    case REGISTER: return moved;
    case TETRAHEDRALIZE: return MeshModel::MM_NONE;
    default: return MeshModel::MM_VERTQUALITY | MeshModel::MM_VERTCOLOR;
    }
}

RichParameterList FilterMoulage::initParameterList(const QAction *action,
                                                   const MeshDocument &document) {
    RichParameterList list;
    const MeshModel *own = document.mm();
    // The layer that is meant most often: the first one that is not the current one.
    unsigned int other = own ? own->id() : 0;
    for (const MeshModel &candidate : document.meshIterator())
        if (own && candidate.id() != own->id()) {
            other = candidate.id();
            break;
        }
    const Scalarm diagonal = own ? own->cm.bbox.Diag() : 1;
    const QStringList points_files = {"*.pp", "*.mrk.json", "*.fcsv", "*.csv"};
    switch (ID(action)) {
    case RESHAPE:
        list.addParam(RichMesh("markers", other, &document, "Markers",
                               "The layer whose vertices lie on the person's surface."));
        list.addParam(RichPercentage("tolerance", diagonal / 1000, 0, diagonal, "Tolerance",
                                     "How far a marker may be off because it was not clicked better. "
                                     "The result is the smoothest shape that explains the markers."));
        list.addParam(RichEnum("align", 0, {"No", "Turn and move", "Turn, move and scale"},
                               "Move to the markers first",
                               "For a template that does not lie where the person is."));
        list.addParam(RichEnum("quality", KEPT,
                               {"Leave as it is", "Largest stretch", "Distance to the nearest marker"},
                               "Vertex quality shows",
                               "What the quality of the vertices is to hold afterwards."));
        list.addParam(RichFileOpen("template_landmarks", "", points_files, "Landmarks on the template",
                                   "Named points on the template: .pp picked on the current layer, "
                                   ".mrk.json, .fcsv; or one .csv with template_x.. and target_x..",
                                   true, "Landmarks"));
        list.addParam(RichFileOpen("person_landmarks", "", points_files, "Landmarks on the person",
                                   "Points of the same names: .pp picked on the markers' layer, "
                                   ".mrk.json, .fcsv in that layer's frame.",
                                   true, "Landmarks"));
        list.addParam(RichPercentage("landmark_tolerance", 0, 0, diagonal, "Tolerance of landmarks",
                                     "How far a landmark may be off; 0: five times the tolerance.",
                                     true, "Landmarks"));
        list.addParam(RichMesh("bone", own ? own->id() : 0, &document, "Bone",
                               "The layer of a bone beside the template, to which it is attached; the "
                               "current layer for none.", true, "Attachments"));
        list.addParam(RichMesh("person_bone", own ? own->id() : 0, &document, "Bone of the person",
                               "The same bone, vertex by vertex, where the person has it; the current "
                               "layer if the bone stays.", true, "Attachments"));
        list.addParam(RichPercentage("attachment_distance", diagonal / 50, 0, diagonal,
                                     "Distance of attachments",
                                     "Vertices of the bone as near as this to the template hold it.",
                                     true, "Attachments"));
        list.addParam(RichInt("max_iterations",
                              static_cast<int>(moulage::reshaping_options().max_iterations),
                              "Iterations at most", "The shape so far is taken when they run out.",
                              true, "Solver"));
        add_tet_parameters(list, true);
        break;
    case REGISTER:
        list.addParam(RichMesh("target", own ? own->id() : 0, &document, "Surface",
                               "The layer with the person's bones; its normals point outwards."));
        list.addParam(RichFileOpen("skeleton", "", {"*.skeleton.json", "*.json", "*.osim"}, "Skeleton",
                                   "The template. Left empty, all other visible layers are its bones."));
        list.addParam(RichString("joints", "", "Joints",
                                 "Without a file: pairs of bone layers, parent-child, separated by "
                                 "commas, such as \"thigh-shank, shank-foot\"."));
        list.addParam(RichFloat("joint_limit", 45, "Limit of joints (deg)",
                                "Without a file: how far each joint may turn in any direction."));
        list.addParam(RichBool("align", true, "Try all orientations",
                               "Off if the template already lies about where the person is."));
        list.addParam(RichFileSave("save", "", "*.skeleton.json", "Save the skeleton as",
                                   "Bones, joint frames and residuals of the person; left empty, "
                                   "nothing is saved."));
        break;
    case TETRAHEDRALIZE:
        add_tet_parameters(list, false);
        list.addParam(RichFileSave("save", "", "*.vtu", "Save the tets as",
                                   "For ParaView; left empty, nothing is saved."));
        break;
    case DISTANCE:
        list.addParam(RichMesh("markers", other, &document, "Markers",
                               "The layer whose vertices are measured to."));
        list.addParam(RichBool("colorize", true, "Colour by distance",
                               "Red: a marker is near; blue: far."));
        break;
    default: break;
    }
    return list;
}

std::map<std::string, QVariant> FilterMoulage::applyFilter(const QAction *action,
                                                           const RichParameterList &parameters,
                                                           MeshDocument &document,
                                                           unsigned int &postConditionMask,
                                                           vcg::CallBackPos *callback) {
    try {
        moulage::check_version();
        postConditionMask = static_cast<unsigned int>(postCondition(action));
        switch (ID(action)) {
        case RESHAPE: return reshape(parameters, document, callback);
        case REGISTER: return register_skeleton(parameters, document, callback);
        case TETRAHEDRALIZE: return tetrahedralize(parameters, document, callback);
        case DISTANCE: return distance(parameters, document);
        default: wrongActionCalled(action);
        }
    } catch (const MLException &) {
        throw;
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const std::exception &error) {
        // MeshLab shows only its own exceptions; any other would end it.
        fail(QString::fromUtf8(error.what()));
    }
    return {};
}

/** Logs warnings line by line. */
void FilterMoulage::warn(const std::string &sentences) {
    std::istringstream lines(sentences);
    for (std::string line; std::getline(lines, line);) log("note: %s", line.c_str());
}

FilterMoulage::Figures FilterMoulage::reshape(const RichParameterList &parameters,
                                              MeshDocument &document, vcg::CallBackPos *callback) {
    MeshModel &own = current(document);
    need_faces(own);
    MeshModel &marker_layer = layer(document, parameters, "markers");
    if (marker_layer.id() == own.id())
        fail("The markers are the template itself; choose the layer with the person's points.");
    const std::vector<double> markers = points_in(own, marker_layer);
    MeshArrays arrays = arrays_of(own);
    moulage::TriMesh surface = surface_of(arrays);

    // Landmarks: places on the template and their targets, both in the template's frame.
    std::vector<double> places, targets;
    const std::string on_template = file(parameters, "template_landmarks");
    const std::string on_person = file(parameters, "person_landmarks");
    if (on_template.empty() && !on_person.empty())
        fail("Landmarks on the person need landmarks on the template.");
    if (!on_template.empty()) {
        const auto pairs = moulage::Pairs::landmarks(surface, on_template, on_person);
        if (const char *warning = mlg_pairs_warning(pairs.get())) warn(warning);
        places.assign(pairs.template_points().begin(), pairs.template_points().end());
        targets.assign(pairs.targets().begin(), pairs.targets().end());
        if (!on_person.empty() && !(own.cm.Tr == marker_layer.cm.Tr)) {
            const Matrix44m matrix = into(own, marker_layer);
            for (std::size_t i = 0; i < targets.size(); i += 3) {
                const Point3m p = matrix * Point3m(Scalarm(targets[i]), Scalarm(targets[i + 1]),
                                                   Scalarm(targets[i + 2]));
                for (int k = 0; k < 3; ++k) targets[i + std::size_t(k)] = double(p[k]);
            }
        }
    }

    // Attachments are read at rest, before the template is moved to the person.
    std::vector<double> held, held_at;
    MeshModel &bone = layer(document, parameters, "bone");
    MeshModel &person_bone = layer(document, parameters, "person_bone");
    if (bone.id() != own.id()) {
        const MeshModel &there = person_bone.id() == own.id() ? bone : person_bone;
        const std::vector<double> rest = points_in(own, bone), moved = points_in(own, there);
        const moulage::TriMesh rest_bone(rest, {}), moved_bone(moved, {});
        const auto pairs = moulage::Pairs::bone(surface, rest_bone, moved_bone,
                                                double(parameters.getAbsPerc("attachment_distance")));
        held.assign(pairs.template_points().begin(), pairs.template_points().end());
        held_at.assign(pairs.targets().begin(), pairs.targets().end());
        log("%i attachments to \"%s\"", int(held.size() / 3), qUtf8Printable(bone.label()));
    }

    const int align = parameters.getEnum("align");
    if (align != 0) {
        const std::vector<double> m =
            surface.align(align == 1 ? MLG_ALIGN_RIGID : MLG_ALIGN_SIMILARITY,
                          moulage::view_of(markers), moulage::view_of(places),
                          moulage::view_of(targets));
        for (std::vector<double> *list : {&arrays.points, &places, &held})
            for (std::size_t i = 0; i < list->size(); i += 3) {
                double *p = list->data() + i;
                const double old[] = {p[0], p[1], p[2]};
                for (std::size_t k = 0; k < 3; ++k)
                    p[k] = m[4 * k] * old[0] + m[4 * k + 1] * old[1] + m[4 * k + 2] * old[2] +
                           m[4 * k + 3];
            }
        surface = surface_of(arrays);
    }

    const std::string tetgen = file(parameters, "tetgen");
    const moulage::Run filling = moulage::start_tets(surface, tet_options(parameters, tetgen));
    follow(filling, callback);
    const moulage::Tetrahedralization tets = filling.wait_tets();
    for (const std::string &warning : tets.warnings()) warn(warning);

    moulage::Reshaping problem(tets);
    problem.set_markers(moulage::view_of(markers));
    problem.set_landmarks(moulage::view_of(places), moulage::view_of(targets));
    problem.set_attachments(moulage::view_of(held), moulage::view_of(held_at));
    warn(problem.check());
    MlgReshapingOptions options = moulage::reshaping_options();
    options.tolerance = double(parameters.getAbsPerc("tolerance"));
    options.landmark_tolerance = double(parameters.getAbsPerc("landmark_tolerance"));
    options.max_iterations =
        static_cast<std::uint32_t>(std::max(0, parameters.getInt("max_iterations")));
    const moulage::Run run = problem.start(options);
    follow(run, callback);
    const moulage::ReshapingResult result = run.wait();

    set_points(own, result.points());
    const int shown = parameters.getEnum("quality");
    if (shown == STRETCH) set_quality(own, result.max_stretches());
    if (shown == MARKER_DISTANCE) {
        const moulage::TriMesh person(
            std::vector<double>(result.points().begin(), result.points().end()), arrays.triangles);
        const std::vector<double> distances = person.distances_to(moulage::view_of(markers));
        set_quality(own, moulage::view_of(distances));
    }

    const MlgReshapingSummary summary = result.summary();
    log("%i markers: mean distance %g, largest %g; %i iterations, %.1f s", int(markers.size() / 3),
        summary.mean_marker_distance, summary.max_marker_distance, int(summary.iterations),
        summary.seconds);
    if (summary.stop == MLG_STOP_ITERATION_LIMIT)
        log("note: the iterations ran out; allow more, or a larger tolerance");
    if (summary.stop == MLG_STOP_NO_STEP)
        log("note: no step makes it better; look for points that contradict each other, or allow a larger "
            "tolerance");
    if (summary.inverted_tets > 0)
        log("note: the shape is folded in places (%i inverted tets)", int(summary.inverted_tets));
    return {{"mean_marker_distance", summary.mean_marker_distance},
            {"max_marker_distance", summary.max_marker_distance},
            {"iterations", int(summary.iterations)},
            {"inverted_tets", int(summary.inverted_tets)},
            {"seconds", summary.seconds}};
}

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
        names.push_back(candidate.label().toUtf8().toStdString());
        surfaces.push_back(surface_of(arrays_of(candidate, &candidate.cm.Tr)));
    }
    if (layers.empty())
        fail("There is no bone: name a skeleton file, or show the layers that are its bones.");
    std::vector<MlgBone> bones;
    for (std::size_t b = 0; b < layers.size(); ++b)
        bones.push_back({sizeof(MlgBone), names[b].c_str(), surfaces[b].get()});

    const double limit = double(parameters.getFloat("joint_limit")) * M_PI / 180;
    std::vector<MlgJoint> joints;
    std::vector<std::string> joint_names;
    const QStringList wanted = parameters.getString("joints").split(',', Qt::SkipEmptyParts);
    joint_names.reserve(std::size_t(wanted.size()));
    for (const QString &pair : wanted) {
        MlgJoint joint = moulage::joint();
        bool found = false;
        // Labels may hold hyphens: every one of them may be what separates parent and child.
        for (int cut = pair.indexOf('-'); cut >= 0 && !found; cut = pair.indexOf('-', cut + 1)) {
            const auto number = [&](const QString &name) {
                return std::find(names.begin(), names.end(), name.trimmed().toUtf8().toStdString()) -
                       names.begin();
            };
            const auto parent = number(pair.left(cut)), child = number(pair.mid(cut + 1));
            const auto count = static_cast<std::ptrdiff_t>(names.size());
            if (parent == count || child == count) continue;
            joint.parent = static_cast<std::uint32_t>(parent);
            joint.child = static_cast<std::uint32_t>(child);
            found = true;
        }
        if (!found)
            fail(QString("The joint \"%1\" does not name two visible bone layers as parent-child.")
                     .arg(pair.trimmed()));
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
    Matrix44m identity;
    identity.SetIdentity();
    problem.set_target(
        surface_of(arrays_of(target, target.cm.Tr == identity ? nullptr : &target.cm.Tr)));
    MlgRegistrationOptions options = moulage::registration_options();
    options.align = parameters.getBool("align") ? 1 : 0;
    const moulage::Run run = problem.start(options);
    follow(run, callback);
    const moulage::RegistrationResult result = run.wait_registration();
    const moulage::Skeleton person = result.skeleton();
    const std::string save = file(parameters, "save", true);
    if (!save.empty()) person.save(save);

    for (std::size_t b = 0; b < person.bone_count(); ++b) {
        if (MeshModel *bone = layered.layers[b]) {
            const Matrix44m back = vcg::Inverse(bone->cm.Tr);
            set_points(*bone, person.bone_points(b), bone->cm.Tr == identity ? nullptr : &back);
        } else {
            add_bone_layer(document, person, b);
        }
    }

    const MlgRegistrationSummary summary = result.summary();
    for (std::size_t b = 0; b < person.bone_count(); ++b)
        log("%s: residual %g, seen %i %%", person.bone_name(b).c_str(), result.bone_fit(b).mean_residual,
            int(100 * result.bone_fit(b).seen));
    warn(result.warnings());
    log("%i bones: mean residual %g, largest %g; %i iterations, %.1f s", int(person.bone_count()),
        summary.mean_residual, summary.max_residual, int(summary.iterations), summary.seconds);
    return {{"mean_residual", summary.mean_residual},
            {"max_residual", summary.max_residual},
            {"suspicious_bones", int(summary.suspicious_bones)},
            {"joints_outside", int(summary.joints_outside)},
            {"iterations", int(summary.iterations)},
            {"seconds", summary.seconds}};
}

FilterMoulage::Figures FilterMoulage::tetrahedralize(const RichParameterList &parameters,
                                                     MeshDocument &document,
                                                     vcg::CallBackPos *callback) {
    MeshModel &own = current(document);
    need_faces(own);
    const std::string tetgen = file(parameters, "tetgen");
    const moulage::TriMesh surface = surface_of(arrays_of(own));
    const moulage::Run run = moulage::start_tets(surface, tet_options(parameters, tetgen));
    follow(run, callback);
    const moulage::Tetrahedralization tets = run.wait_tets();
    warn(surface.check());
    for (const std::string &warning : tets.warnings()) warn(warning);
    const std::string save = file(parameters, "save", true);
    if (!save.empty()) {
        MlgTetMesh *mesh = nullptr;
        moulage::call(mlg_tet_mesh_new, tets.points().data, tets.points().size / 3, tets.tets().data,
                      tets.tets().size / 4, &mesh);
        const moulage::Owner<MlgTetMesh, mlg_tet_mesh_free> owner(mesh);
        moulage::call(mlg_tet_mesh_save, owner.as_const(), save.c_str());
    }
    const MlgTetQuality quality = tets.quality();
    const bool by_tetgen = mlg_tetrahedralization_method(tets.get()) == MLG_TETS_TETGEN;
    log("%i tets by %s, volume %g; dihedral angles %.1f to %.1f deg; radius ratio %.3f at least, %.3f "
        "in the mean",
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
    MeshModel &marker_layer = layer(document, parameters, "markers");
    if (marker_layer.id() == own.id())
        fail("The markers are the surface itself; choose the layer with the person's points.");
    const std::vector<double> markers = points_in(own, marker_layer);
    const moulage::TriMesh surface = surface_of(arrays_of(own));
    const std::vector<double> to = surface.distances_to(moulage::view_of(markers));
    const std::vector<double> of = surface.distances_of(moulage::view_of(markers));

    set_quality(own, moulage::view_of(to));
    if (parameters.getBool("colorize")) {
        own.updateDataMask(MeshModel::MM_VERTCOLOR);
        vcg::tri::UpdateColor<CMeshO>::PerVertexQualityRamp(
            own.cm, 0, Scalarm(*std::max_element(to.begin(), to.end())));
    }
    const double largest = *std::max_element(of.begin(), of.end());
    log("%i markers: distance to the surface mean %g, 95 %% below %g, largest %g",
        int(of.size()), mean(of), percentile(of, 0.95), largest);
    return {{"mean_marker_distance", mean(of)},
            {"p95_marker_distance", percentile(of, 0.95)},
            {"max_marker_distance", largest},
            {"max_vertex_distance", *std::max_element(to.begin(), to.end())}};
}

MESHLAB_PLUGIN_NAME_EXPORTER(FilterMoulage)
