// SPDX-License-Identifier: GPL-3.0-or-later
/** What all filters need: the document's layers, files, tets, and following a run. */
#ifndef MOULAGE_LAYERS_H
#define MOULAGE_LAYERS_H

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <common/ml_document/mesh_document.h>
#include <common/parameters/rich_parameter_list.h>
#include <wrap/callback.h>

#include "mesh_arrays.h"

/** Ends the filter with a sentence for the user. */
[[noreturn]] void fail(const QString &sentence);

/** Follows a run with MeshLab's progress bar until it ends; stops it if MeshLab says so. After `seconds` (0: no limit) the
 * run is asked to end with the best it has. */
void follow(const moulage::Run &run, vcg::CallBackPos *callback, double seconds = 0);

/** The parameter "seconds", for `follow`: MeshLab's progress bar has no button to cancel. */
void add_time_limit(RichParameterList &list, bool hidden);

/** A number of a parameter that is 0 or more. */
std::uint32_t count(const RichParameterList &parameters, const char *name);
double amount(const RichParameterList &parameters, const char *name);
/** The same, in double precision where the default was left as it is. */
double amount(const RichParameterList &parameters, const char *name, double by_default);

/** The numbers of a layer's selected vertices, as `arrays_of` counts them. */
std::vector<std::uint32_t> selected_vertices(const MeshModel &layer);

/** Colours the vertices by their quality: the lowest blue, the highest red. */
void colour_by_quality(MeshModel &layer);

/** The layer that the parameter `name` chooses. */
MeshModel &layer(MeshDocument &document, const RichParameterList &parameters, const char *name);
MeshModel &current(MeshDocument &document);

/** The layer that the parameter "markers" chooses; not `own`, the user's `word` for which is told. */
const MeshModel &markers_beside(const MeshModel &own, const char *word, MeshDocument &document,
                                const RichParameterList &parameters);
void need_faces(const MeshModel &layer);

moulage::TriMesh surface_of(const MeshArrays &arrays);

/** Points and surface of a layer in the frame of the scene. */
std::vector<double> points_in_scene(const MeshModel &layer);
moulage::TriMesh surface_in_scene(const MeshModel &layer);

/** Gives each vertex of a layer its place in the frame of the scene. */
void set_points_in_scene(MeshModel &layer, moulage::View<double> points);

/** What takes a point of `layer` to where it is seen from `seen_from`. */
Matrix44m into(const MeshModel &seen_from, const MeshModel &layer);

/** The points of a layer in the frame of another one. */
std::vector<double> points_in(const MeshModel &seen_from, const MeshModel &layer);

/** The label of a layer, in UTF-8. */
std::string name_of(const MeshModel &layer);

/** Splits "first-second" at the hyphen that leaves a name of each list (names may hold hyphens), and
 * gives their places in the lists; nothing without such a hyphen. */
std::optional<std::pair<std::size_t, std::size_t>> named_pair(const QString &pair,
                                                              const std::vector<std::string> &firsts,
                                                              const std::vector<std::string> &seconds);

std::string file(const RichParameterList &parameters, const char *name, bool save = false);

/** Fills a surface with tets as the parameters say. */
moulage::Tetrahedralization fill(const moulage::TriMesh &surface,
                                 const RichParameterList &parameters, vcg::CallBackPos *callback);

/** Parameters that `fill` reads. */
void add_tet_parameters(RichParameterList &list, bool hidden);

#endif
