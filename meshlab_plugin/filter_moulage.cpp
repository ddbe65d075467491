// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_moulage.h"

#include <sstream>

#include "layers.h"

FilterMoulage::FilterMoulage() {
    typeList = {RESHAPE, REGISTER, SEPARATE, TETRAHEDRALIZE, DISTANCE};
    for (ActionIDType id : types()) actionList.push_back(new QAction(filterName(id), this));
}

QString FilterMoulage::filterName(ActionIDType filter) const {
    switch (filter) {
    case RESHAPE: return "Reshape Template to Markers";
    case REGISTER: return "Register Skeleton to Surface";
    case SEPARATE: return "Separate Overlapping Layers";
    case TETRAHEDRALIZE: return "Tetrahedralize (quality report)";
    case DISTANCE: return "Distance to Markers";
    default: return QString();
    }
}

QString FilterMoulage::pythonFilterName(ActionIDType filter) const {
    switch (filter) {
    case RESHAPE: return "apply_coord_reshape_to_markers";
    case REGISTER: return "apply_coord_register_skeleton";
    case SEPARATE: return "apply_coord_separate_layers";
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
    case SEPARATE:
        return "Pushes all visible layers with faces apart where they <b>overlap</b>, such as muscles that "
               "were reshaped one at a time. The inside of each is filled with tets, and those near an "
               "overlap are simulated with contact between the surfaces; all else stays where it is. "
               "Layers named as fixed, such as bones, do not move. No tet is inverted; overlaps that are "
               "left are told.<br><br>"
               "See section 4.1.4 of:<br><i>Bohan Wang, George Matcuk, Jernej Barbic</i><br>"
               "<b>\"Modeling of Personalized Anatomy using Plastic Strains\"</b><br>"
               "ACM Transactions on Graphics 40(2), 2021.";
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
    case REGISTER:
    case SEPARATE: return Smoothing;
    case TETRAHEDRALIZE: return Measure;
    default: return FilterClass(Quality | VertexColoring);
    }
}

FilterPlugin::FilterArity FilterMoulage::filterArity(const QAction *action) const {
    switch (ID(action)) {
    case TETRAHEDRALIZE: return SINGLE_MESH;
    case SEPARATE: return VARIABLE;
    default: return FIXED;
    }
}

int FilterMoulage::getPreConditions(const QAction *action) const {
    const bool any_layer = ID(action) == REGISTER || ID(action) == SEPARATE;
    return any_layer ? MeshModel::MM_NONE : MeshModel::MM_FACENUMBER;
}

int FilterMoulage::postCondition(const QAction *action) const {
    const int moved = MeshModel::MM_VERTCOORD | MeshModel::MM_VERTNORMAL | MeshModel::MM_FACENORMAL;
    switch (ID(action)) {
    case RESHAPE: return moved | MeshModel::MM_VERTQUALITY | MeshModel::MM_VERTCOLOR;
    case REGISTER:
    case SEPARATE: return moved;
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
    const MlgReshapingOptions defaults = moulage::reshaping_options();
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
        list.addParam(RichEnum("quality", 0,
                               {"Leave as it is", "Largest stretch", "Distance to the nearest marker",
                                "Standard deviation across the surface"},
                               "Vertex quality shows",
                               "What the quality of the vertices is to hold afterwards."));
        list.addParam(RichBool("colorize", true, "Colour by vertex quality",
                               "If it shows anything new: the lowest blue, the highest red."));
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
        list.addParam(RichPercentage("attachment_tolerance", 0, 0, diagonal, "Tolerance of attachments",
                                     "How far an attachment may be off; 0: the tolerance.", true,
                                     "Attachments"));
        list.addParam(RichBool("hard_attachments", false, "Meet attachments exactly",
                               "Whatever the markers say; else both are weighed.", true, "Attachments"));
        list.addParam(RichBool("fix_selected", false, "Selected vertices stay",
                               "The vertices that are selected on the current layer do not move.", true,
                               "Attachments"));
        list.addParam(RichInt("max_iterations",
                              static_cast<int>(defaults.max_iterations),
                              "Iterations at most",
                              "The shape so far is taken when they run out; 0: as many as by default.",
                              true, "Solver"));
        list.addParam(RichFloat("smoothness", static_cast<Scalarm>(defaults.smoothness), "Smoothness",
                                "How strongly neighbouring places are stretched alike: more for few or "
                                "inexact markers.", true, "Solver"));
        list.addParam(RichFloat("screening", static_cast<Scalarm>(defaults.screening), "Reach of markers",
                                "Farther from them than so many sizes of the template it is stretched as "
                                "on average; 0: by how much of it was marked.", true, "Solver"));
        list.addParam(RichFloat("poisson", static_cast<Scalarm>(defaults.poisson), "Poisson's ratio",
                                "Above 0 and below 0.5: the nearer to 0.5, the better the tissue keeps its "
                                "volume.", true, "Solver"));
        add_time_limit(list, true);
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
        list.addParam(RichBool("as_is", false, "Meant as it is",
                               "Take the target even if it looks like a mirror image of the skeleton, or "
                               "as if it were in another unit."));
        add_time_limit(list, false);
        list.addParam(RichFileSave("save", "", "*.skeleton.json", "Save the skeleton as",
                                   "Bones, joint frames and residuals of the person; left empty, "
                                   "nothing is saved."));
        break;
    case SEPARATE:
        list.addParam(RichString("fixed", "", "Fixed layers",
                                 "Layers that stay, such as bones: their names, separated by commas; "
                                 "* stands for anything, as in \"bone_*, scaphoid\"."));
        list.addParam(RichString("markers", "", "Markers",
                                 "Surfaces are held where markers are met: pairs of layers, "
                                 "surface-points, separated by commas, such as \"left-left clicks\"."));
        list.addParam(RichPercentage("gap", 0, 0, diagonal, "Gap",
                                     "Distance to leave between surfaces; 0: the size of the layers / "
                                     "2000."));
        list.addParam(RichInt("rings", static_cast<int>(moulage::separation_options().rings), "Rings",
                              "Vertices up to this many edges away from an overlap may move."));
        add_time_limit(list, false);
        add_tet_parameters(list, true);
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
                               "Blue: a marker is near; red: far."));
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
        warnings_ = 0;
        Figures figures;
        switch (ID(action)) {
        case RESHAPE:
            figures = reshape(parameters, document, callback);
            // MeshLab shows what is said to have changed.
            if (parameters.getEnum("quality") == 0) postConditionMask &= ~unsigned(MeshModel::MM_VERTQUALITY);
            if (parameters.getEnum("quality") == 0 || !parameters.getBool("colorize"))
                postConditionMask &= ~unsigned(MeshModel::MM_VERTCOLOR);
            break;
        case REGISTER: figures = register_skeleton(parameters, document, callback); break;
        case SEPARATE: figures = separate(parameters, document, callback); break;
        case TETRAHEDRALIZE: figures = tetrahedralize(parameters, document, callback); break;
        case DISTANCE: figures = distance(parameters, document); break;
        default: wrongActionCalled(action);
        }
        // Scripts do not see the log.
        figures["warnings"] = warnings_;
        return figures;
    } catch (const MLException &) {
        throw;
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const std::exception &error) {
        // MeshLab shows only its own exceptions; any other would end it.
        fail(QString::fromUtf8(error.what()));
    }
}

void FilterMoulage::warn(const std::string &sentences) {
    std::istringstream lines(sentences);
    for (std::string line; std::getline(lines, line); ++warnings_) log("note: %s", line.c_str());
}

MESHLAB_PLUGIN_NAME_EXPORTER(FilterMoulage)
