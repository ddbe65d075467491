// SPDX-License-Identifier: GPL-3.0-or-later
#include "layers.h"

#include <algorithm>

#include <common/mlexception.h>
#include <vcg/complex/algorithms/stat.h>
#include <vcg/complex/algorithms/update/color.h>

namespace {

/** Time between two looks at a run. MeshLab redraws at most every 100 ms. */
constexpr double POLL_SECONDS = 0.03;

/** Null for a layer that lies in the frame of the scene: no number changes then. */
const Matrix44m *unless_identity(const Matrix44m &matrix) {
    Matrix44m identity;
    identity.SetIdentity();
    return matrix == identity ? nullptr : &matrix;
}

}  // namespace

[[noreturn]] void fail(const QString &sentence) { throw MLException(sentence); }

void follow(const moulage::Run &run, vcg::CallBackPos *callback, double seconds) {
    while (!run.wait_for(POLL_SECONDS)) {
        const MlgProgress progress = run.poll();
        if (callback && !callback(static_cast<int>(100 * progress.fraction), progress.stage)) {
            run.cancel();
            fail("Stopped; nothing was changed.");
        }
        // Not before there is something to take.
        if (seconds > 0 && progress.seconds > seconds && progress.iteration > 0) run.cancel();
    }
}

void add_time_limit(RichParameterList &list, bool hidden) {
    list.addParam(RichFloat("seconds", 0, "Seconds at most",
                            "The best shape so far is taken when they are over; 0: no limit.", hidden,
                            hidden ? "Solver" : ""));
}

std::uint32_t count(const RichParameterList &parameters, const char *name) {
    const int value = parameters.getInt(name);
    if (value < 0) fail(QString("%1 is %2; it must be 0 or more.").arg(name).arg(value));
    return static_cast<std::uint32_t>(value);
}

double amount(const RichParameterList &parameters, const char *name) {
    const double value = double(parameters.getFloat(name));
    if (!(value >= 0)) fail(QString("%1 is %2; it must be 0 or more.").arg(name).arg(value));
    return value;
}

double amount(const RichParameterList &parameters, const char *name, double by_default) {
    // Numbers pass through single precision on their way here.
    const double value = amount(parameters, name);
    return static_cast<float>(value) == static_cast<float>(by_default) ? by_default : value;
}

std::vector<std::uint32_t> selected_vertices(const MeshModel &layer) {
    std::vector<std::uint32_t> selected;
    std::uint32_t number = 0;
    for (const CVertexO &vertex : layer.cm.vert) {
        if (vertex.IsD()) continue;
        if (vertex.IsS()) selected.push_back(number);
        ++number;
    }
    return selected;
}

void colour_by_quality(MeshModel &layer) {
    layer.updateDataMask(MeshModel::MM_VERTCOLOR);
    const auto range = vcg::tri::Stat<CMeshO>::ComputePerVertexQualityMinMax(layer.cm);
    vcg::tri::UpdateColor<CMeshO>::PerVertexQualityRamp(layer.cm, range.second, range.first);
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

const MeshModel &markers_beside(const MeshModel &own, const char *word, MeshDocument &document,
                                const RichParameterList &parameters) {
    const MeshModel &markers = layer(document, parameters, "markers");
    if (markers.id() == own.id())
        fail(QString("The markers are the %1 itself; choose the layer with the person's points.").arg(word));
    return markers;
}

moulage::TriMesh surface_of(const MeshArrays &arrays) {
    return moulage::TriMesh(arrays.points, arrays.triangles);
}

void need_faces(const MeshModel &layer) {
    if (layer.cm.fn == 0)
        fail(QString("The layer \"%1\" has no faces; a surface is needed.").arg(layer.label()));
}

Matrix44m into(const MeshModel &seen_from, const MeshModel &layer) {
    return vcg::Inverse(seen_from.cm.Tr) * layer.cm.Tr;
}

std::vector<double> points_in(const MeshModel &seen_from, const MeshModel &layer) {
    if (layer.cm.vn == 0)
        fail(QString("The layer \"%1\" has no points.").arg(layer.label()));
    const Matrix44m matrix = into(seen_from, layer);
    return arrays_of(layer, seen_from.cm.Tr == layer.cm.Tr ? nullptr : &matrix).points;
}

std::string file(const RichParameterList &parameters, const char *name, bool save) {
    const QString path =
        save ? parameters.getSaveFileName(name) : parameters.getOpenFileName(name);
    return path.toUtf8().toStdString();
}

std::string name_of(const MeshModel &layer) { return layer.label().toUtf8().toStdString(); }

std::optional<std::pair<std::size_t, std::size_t>> named_pair(const QString &pair,
                                                              const std::vector<std::string> &firsts,
                                                              const std::vector<std::string> &seconds) {
    const auto find = [](const std::vector<std::string> &names, const QString &name) {
        return std::find(names.begin(), names.end(), name.trimmed().toUtf8().toStdString());
    };
    for (int cut = pair.indexOf('-'); cut >= 0; cut = pair.indexOf('-', cut + 1)) {
        const auto first = find(firsts, pair.left(cut)), second = find(seconds, pair.mid(cut + 1));
        if (first == firsts.end() || second == seconds.end()) continue;
        return std::pair(std::size_t(first - firsts.begin()), std::size_t(second - seconds.begin()));
    }
    return std::nullopt;
}

std::vector<double> points_in_scene(const MeshModel &layer) {
    return arrays_of(layer, unless_identity(layer.cm.Tr)).points;
}

moulage::TriMesh surface_in_scene(const MeshModel &layer) {
    return surface_of(arrays_of(layer, unless_identity(layer.cm.Tr)));
}

void set_points_in_scene(MeshModel &layer, moulage::View<double> points) {
    const Matrix44m back = vcg::Inverse(layer.cm.Tr);
    set_points(layer, points, unless_identity(layer.cm.Tr) ? &back : nullptr);
}

moulage::Tetrahedralization fill(const moulage::TriMesh &surface,
                                 const RichParameterList &parameters, vcg::CallBackPos *callback) {
    const std::string tetgen = file(parameters, "tetgen");
    MlgTetrahedralizationOptions options = moulage::tetrahedralization_options();
    options.method = static_cast<std::uint32_t>(parameters.getEnum("tets"));
    options.tet_count = count(parameters, "tet_count");
    options.tetgen_path = tetgen.empty() ? nullptr : tetgen.c_str();
    const auto run = moulage::start_tets(surface, options);
    follow(run, callback);
    return run.wait();
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
