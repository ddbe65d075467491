/**
 * moulage puts a template of an organ, bone or skeleton into one person's shape.
 *
 * A reshaping, without the checks of its statuses (examples/c/reshape.c has them):
 *
 *     MlgError error;
 *     mlg_tri_mesh_load("liver.obj", &surface, &error);
 *     mlg_markers_load("clicks.csv", &markers, &error);
 *     mlg_tetrahedralization_run(surface, NULL, &tets, &error);
 *     mlg_reshaping_new(tets, &problem, &error);
 *     points = mlg_markers_points(markers, &count);
 *     mlg_reshaping_set_markers(problem, points, NULL, count, &error);
 *     mlg_reshaping_run(problem, NULL, &result, &error);
 *     points = mlg_reshaping_result_points(result, &count);
 *     mlg_tri_mesh_save(surface, points, count, "person.obj", &error);
 *     (and the _free of each)
 *
 * Functions return a status and write their outputs only on success; details of a failure go to the
 * caller's MlgError, which may be NULL. Handles come from _new, _load, _run or _start and are freed
 * once by _free. A handle is a ticket, not an address: one that was freed, or is of another type, is
 * refused with MLG_STATUS_INVALID_ARGUMENT.
 * Arrays given are copied; arrays returned are borrowed until their handle is freed: NULL and a count
 * of 0 for what is not there. Points are packed x, y, z. Strings and paths are UTF-8. A file is
 * written beside its place and renamed; its folder must exist.
 * Structs that begin with struct_size may grow at their end: options are set by their _init, in others
 * the caller sets it, as in `progress.struct_size = sizeof progress;`.
 * Functions may be called from any thread. The library has threads of its own: one per run, and those
 * that compute, which stay. So a child made by fork() without exec must not call it.
 *
 * Sections, in this order:
 *   Handles: what the functions work on.
 *   Versions.
 *   Statuses and errors: what every function does at the border.
 *   Surfaces and tet meshes, from arrays and files.
 *   Between a surface and points: distances, nearest places, values.
 *   Markers, from arrays and files.
 *   Runs: started, polled, cancelled, waited for. No callback crosses the border.
 *   Filling: from a surface to tets that carry it.
 *   Reshaping: the problem and its options.
 *   Landmarks and attachments: places on a template and their targets, from files or bones.
 *   Before a reshaping: where the template is to lie.
 *   Findings: what is suspicious before a reshaping is run, and what mends it.
 *   Reshaping: started, or run to its end.
 *   What a reshaping gave.
 *   What a reshaping gave: how far markers, landmarks and attachments are from it.
 *   How sure a reshaped template is: plausible shapes, and how far they differ.
 *   Separation of bodies that overlap: the problem, its options, the run.
 *   What a separation gave.
 *   Medical images: slices, and lines on slices.
 *   Medical images from memory, and their voxels.
 *   Label maps: which labels there are, their outlines, markers on them, their surfaces.
 *   Skeletons from arrays: bones and joints.
 *   What is in a skeleton: names, surfaces, joints, angles.
 *   Skeleton files, read and written.
 *   Motions of skeletons: angles of their joints over time.
 *   Shape statistics of a skeleton's bones.
 *   Registration of a skeleton: the problem, its options, the run.
 *   What a registration gave.
 *
 * Made from src/capi by cbindgen; do not edit.
 */
#ifndef MOULAGE_H
#define MOULAGE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ================================================================================================
 * Handles: what the functions work on.
 * ================================================================================================ */

/**
 * A tet mesh. Immutable; may be read from many threads.
 */
typedef struct MlgTetMesh MlgTetMesh;

/**
 * A triangle surface. Immutable; may be read from many threads.
 */
typedef struct MlgTriMesh MlgTriMesh;

/**
 * Points that somebody marked. Immutable; may be read from many threads.
 */
typedef struct MlgMarkers MlgMarkers;

/**
 * A computation on a thread of its own. May be polled and cancelled from any thread.
 */
typedef struct MlgRun MlgRun;

/**
 * Tets that carry a surface. Immutable; may be read from many threads.
 */
typedef struct MlgTetrahedralization MlgTetrahedralization;

/**
 * A template and the data it is to follow. May be used by one thread at a time.
 */
typedef struct MlgReshaping MlgReshaping;

/**
 * Places on a template with their targets: landmarks or attachments. Immutable; may be read from
 * many threads.
 */
typedef struct MlgPairs MlgPairs;

/**
 * What is suspicious about a template and its data. Immutable; may be read from many threads.
 */
typedef struct MlgFindings MlgFindings;

/**
 * A reshaped template. Immutable; may be read from many threads.
 */
typedef struct MlgReshapingResult MlgReshapingResult;

/**
 * Shapes that explain the data about as well as the result. Immutable; may be read from many threads.
 */
typedef struct MlgUncertainty MlgUncertainty;

/**
 * Bodies that overlap each other or obstacles. May be used by one thread at a time.
 */
typedef struct MlgSeparation MlgSeparation;

/**
 * Bodies that were pushed apart. Immutable; may be read from many threads.
 */
typedef struct MlgSeparationResult MlgSeparationResult;

/**
 * Lines, each open or closed. Immutable; may be read from many threads.
 */
typedef struct MlgPolylines MlgPolylines;

/**
 * A medical image, or a label map. Immutable; may be read from many threads. World coordinates are
 * millimetres in RAS: x to the person's right, y to the front, z to the head.
 */
typedef struct MlgVolume MlgVolume;

/**
 * Bones and the joints between them. Immutable; may be read from many threads.
 */
typedef struct MlgSkeleton MlgSkeleton;

/**
 * Named angles over time, and the skeleton that they move. Immutable; may be read from many threads.
 */
typedef struct MlgMotion MlgMotion;

/**
 * Mean shape and modes of all bones of a template. Immutable; may be read from many threads.
 */
typedef struct MlgShapeModel MlgShapeModel;

/**
 * A template skeleton and the surface it is to follow. May be used by one thread at a time.
 */
typedef struct MlgRegistration MlgRegistration;

/**
 * A registered skeleton. Immutable; may be read from many threads.
 */
typedef struct MlgRegistrationResult MlgRegistrationResult;

/* ================================================================================================
 * Versions.
 * ================================================================================================ */

/**
 * Raised whenever a program built against an older header would break.
 */
#define MLG_ABI_VERSION 1

/**
 * First number of the library's version.
 */
#define MLG_VERSION_MAJOR 0

/**
 * Second number of the library's version.
 */
#define MLG_VERSION_MINOR 1

/**
 * Third number of the library's version.
 */
#define MLG_VERSION_PATCH 0

/**
 * The library's `MLG_ABI_VERSION`. Compare it with the header's when loading the library at run
 * time, and refuse to go on if they differ.
 */
uint32_t mlg_abi_version(void);

/**
 * The library's version, e.g. "0.1.0". Static, never NULL.
 */
const char *mlg_version_string(void);

/* ================================================================================================
 * Statuses and errors: what every function does at the border.
 * ================================================================================================ */

/**
 * Bytes of `MlgError.message`, the ending zero included.
 */
#define MLG_ERROR_MESSAGE_SIZE 512

/**
 * How a call ended. Numbers are never reused.
 */
typedef enum MlgStatus {
  /**
   * All went well; outputs are written.
   */
  MLG_STATUS_OK = 0,
  /**
   * Stopped on request before there was a result.
   */
  MLG_STATUS_CANCELLED = 1,
  /**
   * A pointer that must not be NULL is NULL.
   */
  MLG_STATUS_NULL_ARGUMENT = 2,
  /**
   * A value is wrong: the message names it. Also for handles that were freed or are of another
   * type.
   */
  MLG_STATUS_INVALID_ARGUMENT = 3,
  /**
   * A valid wish that this version cannot fulfil, or a program that is not installed.
   */
  MLG_STATUS_UNSUPPORTED = 4,
  /**
   * A file could not be read or written.
   */
  MLG_STATUS_IO = 5,
  /**
   * A file does not hold what its format asks for.
   */
  MLG_STATUS_PARSE = 6,
  /**
   * A linear system has no unique solution.
   */
  MLG_STATUS_SINGULAR = 7,
  /**
   * The solver could not make further progress and there is no result.
   */
  MLG_STATUS_DIVERGED = 8,
  /**
   * A fault in the library; the message says where. Free all handles and report it.
   */
  MLG_STATUS_PANIC = 9,
  /**
   * A program started by the library failed.
   */
  MLG_STATUS_EXTERNAL_PROGRAM = 10,
} MlgStatus;

/**
 * What went wrong. Owned by the caller; written by a call only when it fails.
 */
typedef struct MlgError {
  /**
   * The status the call returned.
   */
  MlgStatus status;
  /**
   * One sentence for the user: UTF-8, zero-terminated, cut to fit.
   */
  char message[MLG_ERROR_MESSAGE_SIZE];
} MlgError;

/**
 * The name of a status, e.g. "INVALID_ARGUMENT"; "UNKNOWN" for other numbers. Static, never NULL.
 */
const char *mlg_status_name(uint32_t status);

/* ================================================================================================
 * Surfaces and tet meshes, from arrays and files.
 * ================================================================================================ */

/**
 * Makes a surface from arrays, which are copied.
 *
 * `points`: `3 * point_count` coordinates (x, y, z of each), finite, in any unit.
 * `triangles`: `3 * triangle_count` vertex indices from 0, counter-clockwise seen from outside.
 * Neither may be NULL unless its count is 0. Free with `mlg_tri_mesh_free`.
 */
MlgStatus mlg_tri_mesh_new(const double *points,
                           size_t point_count,
                           const uint32_t *triangles,
                           size_t triangle_count,
                           MlgTriMesh **out_mesh,
                           MlgError *error);

/**
 * Reads a surface from a `.obj`, `.ply` or `.stl` file. `path`: UTF-8. Free with
 * `mlg_tri_mesh_free`.
 */
MlgStatus mlg_tri_mesh_load(const char *path, MlgTriMesh **out_mesh, MlgError *error);

/**
 * Writes a surface with moved points to a `.obj`, `.ply` or `.stl` file. Where the mesh was loaded
 * from a file of that format, all but points and normals stays as it was: texture coordinates,
 * groups, materials.
 *
 * `points`: `3 * point_count` coordinates, or NULL for the mesh's own; `point_count` must be that
 * of the mesh (ignored for NULL).
 */
MlgStatus mlg_tri_mesh_save(const MlgTriMesh *mesh,
                            const double *points,
                            size_t point_count,
                            const char *path,
                            MlgError *error);

/**
 * The points: `3 * *out_count` coordinates, borrowed until the mesh is freed. NULL for a mesh
 * without points or a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_tri_mesh_points(const MlgTriMesh *mesh, size_t *out_count);

/**
 * The triangles: `3 * *out_count` vertex indices, borrowed until the mesh is freed. NULL for a
 * mesh without triangles or a handle that is not valid. `out_count`: may be NULL.
 */
const uint32_t *mlg_tri_mesh_triangles(const MlgTriMesh *mesh, size_t *out_count);

/**
 * Looks for holes, crowded and flipped edges, empty triangles, double and unused vertices, and
 * writes what it finds, one sentence per line, into `buffer`: UTF-8, zero-terminated, cut to
 * `capacity` bytes. An empty text means a clean, closed surface. `buffer` may be NULL if
 * `capacity` is 0. `out_length`: bytes of the whole text without the zero; may be NULL.
 */
MlgStatus mlg_tri_mesh_check(const MlgTriMesh *mesh,
                             char *buffer,
                             size_t capacity,
                             size_t *out_length,
                             MlgError *error);

/**
 * Frees a surface. NULL and handles freed already are allowed. Objects made from it stay valid.
 */
void mlg_tri_mesh_free(MlgTriMesh *mesh);

/**
 * Makes a tet mesh from arrays, which are copied. Tets of negative volume are turned around.
 *
 * `points`: `3 * point_count` coordinates, finite. `tets`: `4 * tet_count` vertex indices from 0.
 * Neither may be NULL unless its count is 0. Free with `mlg_tet_mesh_free`.
 */
MlgStatus mlg_tet_mesh_new(const double *points,
                           size_t point_count,
                           const uint32_t *tets,
                           size_t tet_count,
                           MlgTetMesh **out_mesh,
                           MlgError *error);

/**
 * Reads a tet mesh from a TetGen `.node` or `.ele`, `.vtu`, VegaFEM `.veg` or Gmsh `.msh` file.
 * `path`: UTF-8. Free with `mlg_tet_mesh_free`.
 */
MlgStatus mlg_tet_mesh_load(const char *path, MlgTetMesh **out_mesh, MlgError *error);

/**
 * Writes a tet mesh as `.vtu` (VTK, for ParaView). `path`: UTF-8.
 */
MlgStatus mlg_tet_mesh_save(const MlgTetMesh *mesh, const char *path, MlgError *error);

/**
 * The points: `3 * *out_count` coordinates, borrowed until the mesh is freed. NULL for a mesh
 * without points or a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_tet_mesh_points(const MlgTetMesh *mesh, size_t *out_count);

/**
 * The tets: `4 * *out_count` vertex indices, borrowed until the mesh is freed. NULL for a mesh
 * without tets or a handle that is not valid. `out_count`: may be NULL.
 */
const uint32_t *mlg_tet_mesh_tets(const MlgTetMesh *mesh, size_t *out_count);

/**
 * Frees a tet mesh. NULL and handles freed already are allowed. Objects made from it stay valid.
 */
void mlg_tet_mesh_free(MlgTetMesh *mesh);

/* ================================================================================================
 * Between a surface and points: distances, nearest places, values.
 * ================================================================================================ */

/**
 * The distance of each vertex of a surface to the nearest of some points: how well each place of a
 * result is supported by markers.
 *
 * `points`: `3 * count` coordinates, finite, at least one point. `out_distances`: room for one number
 * per vertex of `mesh`.
 */
MlgStatus mlg_tri_mesh_distances_to_points(const MlgTriMesh *mesh,
                                           const double *points,
                                           size_t count,
                                           double *out_distances,
                                           MlgError *error);

/**
 * The distance of each of some points to the nearest place on a surface: how well a result meets its
 * markers.
 *
 * `points`: `3 * count` coordinates, finite, at least one point. `out_distances`: room for `count`
 * numbers. The mesh needs triangles.
 */
MlgStatus mlg_tri_mesh_distances_of_points(const MlgTriMesh *mesh,
                                           const double *points,
                                           size_t count,
                                           double *out_distances,
                                           MlgError *error);

/**
 * The place on a surface that is nearest to each of some points.
 *
 * `points`: `3 * count` coordinates, finite, at least one point. `out_places`: room for `3 * count`
 * numbers. The mesh needs triangles.
 */
MlgStatus mlg_tri_mesh_closest_points(const MlgTriMesh *mesh,
                                      const double *points,
                                      size_t count,
                                      double *out_places,
                                      MlgError *error);

/**
 * Values that are known at some points, such as the distances of markers, at each vertex of a surface: the mean
 * of the four nearest points, weighted by nearness.
 *
 * `points`: `3 * count` coordinates, finite, at least one point. `values`: `count` numbers.
 * `out_values`: room for one number per vertex of `mesh`; NaN for a vertex that is farther from its
 * nearest point than three times the points' usual spacing.
 */
MlgStatus mlg_tri_mesh_interpolate(const MlgTriMesh *mesh,
                                   const double *points,
                                   const double *values,
                                   size_t count,
                                   double *out_values,
                                   MlgError *error);

/* ================================================================================================
 * Markers, from arrays and files.
 * ================================================================================================ */

/**
 * Makes markers from arrays, which are copied.
 *
 * `points`: `3 * count` coordinates, finite. `weights`: `count` numbers, 0 or more, or NULL for 1
 * throughout. `labels`: `count` names in UTF-8, each of which may be NULL; or NULL for none. Free
 * with `mlg_markers_free`.
 */
MlgStatus mlg_markers_new(const double *points,
                          const double *weights,
                          const char *const *labels,
                          size_t count,
                          MlgMarkers **out_markers,
                          MlgError *error);

/**
 * Reads markers from `.csv`, `.txt`, `.xyz`, `.ply`, 3D Slicer `.mrk.json` and `.fcsv` (turned
 * into RAS) or MeshLab `.pp`. `path`: UTF-8. Free with `mlg_markers_free`.
 */
MlgStatus mlg_markers_load(const char *path, MlgMarkers **out_markers, MlgError *error);

/**
 * Writes markers as `.csv`, 3D Slicer `.mrk.json` or `.fcsv` (said to be RAS) or MeshLab `.pp`.
 * `path`: UTF-8.
 */
MlgStatus mlg_markers_save(const MlgMarkers *markers, const char *path, MlgError *error);

/**
 * The positions: `3 * *out_count` coordinates, borrowed until the markers are freed. NULL for a
 * handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_markers_points(const MlgMarkers *markers, size_t *out_count);

/**
 * The noise of each: `*out_count` numbers, 0 where the file gives none, borrowed until the markers are
 * freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_markers_sigmas(const MlgMarkers *markers,
                                 size_t *out_count);

/**
 * The weights: `*out_count` numbers, 1 where the file gives none, borrowed until the markers are
 * freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_markers_weights(const MlgMarkers *markers, size_t *out_count);

/**
 * The name of one marker: UTF-8, borrowed until the markers are freed. NULL where it has none, if
 * `index` is not below the count, or for a handle that is not valid.
 */
const char *mlg_markers_label(const MlgMarkers *markers, size_t index);

/**
 * Frees markers. NULL and handles freed already are allowed.
 */
void mlg_markers_free(MlgMarkers *markers);

/* ================================================================================================
 * Runs: started, polled, cancelled, waited for. No callback crosses the border.
 * ================================================================================================ */

/**
 * Still at work.
 */
#define MLG_RUN_RUNNING 0

/**
 * Ended; waiting for its result returns at once.
 */
#define MLG_RUN_ENDED 1

/**
 * Bytes of `MlgProgress.stage`, the ending zero included.
 */
#define MLG_STAGE_SIZE 64

/**
 * Where a run stands. Lengths are in the template's unit.
 */
typedef struct MlgProgress {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * `MLG_RUN_RUNNING` or `MLG_RUN_ENDED`.
   */
  uint32_t state;
  /**
   * Iterations of the outer loop so far.
   */
  uint32_t iteration;
  /**
   * Share of the work done, 0 to 1, never falling; 1 once it has ended with a result and was not
   * cancelled.
   */
  double fraction;
  /**
   * Latest value of the objective.
   */
  double energy;
  /**
   * Mean distance of the markers (registrations: of the pairs) to the shape; NaN while unknown.
   */
  double mean_error;
  /**
   * Largest distance of a marker to the shape; NaN while unknown.
   */
  double max_error;
  /**
   * Seconds since the start.
   */
  double seconds;
  /**
   * What is being done: UTF-8, zero-terminated.
   */
  char stage[MLG_STAGE_SIZE];
} MlgProgress;

/**
 * Tells where a run stands; takes less than a microsecond. `out_progress`: its `struct_size` must
 * be set.
 */
MlgStatus mlg_run_poll(const MlgRun *run, MlgProgress *out_progress, MlgError *error);

/**
 * Waits until a run has ended, at most `seconds`: 0 does not wait, INFINITY waits for the end.
 * `out_state`: `MLG_RUN_RUNNING` or `MLG_RUN_ENDED`. The result is handed over by the
 * `mlg_run_wait_...` of its kind.
 */
MlgStatus mlg_run_wait_for(const MlgRun *run,
                           double seconds,
                           uint32_t *out_state,
                           MlgError *error);

/**
 * Asks a run to stop; returns at once. The run still hands out the best shape so far, if it has
 * one. Allowed at any time, from any thread (but not from a signal handler: set a flag there).
 */
void mlg_run_cancel(const MlgRun *run);

/**
 * Copies the latest shape of the surface (registrations: of all bones, one after the other), for a
 * live view: `3 * *out_count` coordinates into `buffer`, which has room for `3 * capacity`.
 * `*out_count` is the number of points there are: 0 before the first shape; if it is above
 * `capacity`, nothing is copied. `buffer` may be NULL if `capacity` is 0.
 */
MlgStatus mlg_run_preview_points(const MlgRun *run,
                                 double *buffer,
                                 size_t capacity,
                                 size_t *out_count,
                                 MlgError *error);

/**
 * Cancels a run, waits for its end and frees it. NULL and handles freed already are allowed.
 */
void mlg_run_free(MlgRun *run);

/* ================================================================================================
 * Filling: from a surface to tets that carry it.
 * ================================================================================================ */

/**
 * TetGen where it is found and can fill the surface, else the lattice.
 */
#define MLG_TETS_AUTO 0

/**
 * The program TetGen, or an error.
 */
#define MLG_TETS_TETGEN 1

/**
 * The built-in lattice: takes open, self-intersecting and non-manifold surfaces as well.
 */
#define MLG_TETS_LATTICE 2

/**
 * (Only as an answer.) The tets were given by the caller.
 */
#define MLG_TETS_GIVEN 3

/**
 * How to make tets. Set with `mlg_tetrahedralization_options_init`.
 */
typedef struct MlgTetrahedralizationOptions {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * `MLG_TETS_AUTO` (default), `MLG_TETS_TETGEN` or `MLG_TETS_LATTICE`.
   */
  uint32_t method;
  /**
   * About how many tets, 24 to 10 million. Default 15000.
   */
  uint32_t tet_count;
  /**
   * Path of the program TetGen, UTF-8; NULL: the environment variable MOULAGE_TETGEN, else the
   * search path. Read during the call only.
   */
  const char *tetgen_path;
} MlgTetrahedralizationOptions;

/**
 * Shapes of tets. Volumes in the mesh's own unit, angles in degrees.
 */
typedef struct MlgTetQuality {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Number of tets.
   */
  uint32_t tet_count;
  /**
   * Tets of no or negative volume.
   */
  uint32_t inverted_count;
  /**
   * Sum of the signed volumes.
   */
  double volume;
  /**
   * Smallest dihedral angle.
   */
  double min_dihedral;
  /**
   * Largest dihedral angle.
   */
  double max_dihedral;
  /**
   * Smallest radius ratio (3 inner / outer sphere): 1 for regular tets, 0 for flat ones.
   */
  double min_radius_ratio;
  /**
   * Mean radius ratio.
   */
  double mean_radius_ratio;
  /**
   * Number of dihedral angles in each 10 degrees from 0 to 180.
   */
  uint32_t dihedral_histogram[18];
} MlgTetQuality;

/**
 * Writes the defaults. `struct_size`: `sizeof *out_options`.
 */
MlgStatus mlg_tetrahedralization_options_init(MlgTetrahedralizationOptions *out_options,
                                              size_t struct_size);

/**
 * Fills a surface with tets; takes seconds (to wait without blocking: `_start`). `options`: NULL for the defaults. Free with
 * `mlg_tetrahedralization_free`.
 */
MlgStatus mlg_tetrahedralization_run(const MlgTriMesh *surface,
                                     const MlgTetrahedralizationOptions *options,
                                     MlgTetrahedralization **out_tets,
                                     MlgError *error);

/**
 * Starts filling a surface with tets on a thread of its own and returns at once. `options`: NULL for
 * the defaults, read during the call only. Free the run with `mlg_run_free`.
 */
MlgStatus mlg_tetrahedralization_start(const MlgTriMesh *surface,
                                       const MlgTetrahedralizationOptions *options,
                                       MlgRun **out_run,
                                       MlgError *error);

/**
 * Waits for the end of a tetrahedralization and hands the tets over, once; `MLG_STATUS_CANCELLED`
 * if it was cancelled. Free them with `mlg_tetrahedralization_free`, and the run with
 * `mlg_run_free`.
 */
MlgStatus mlg_run_wait_tetrahedralization(MlgRun *run,
                                          MlgTetrahedralization **out_tets,
                                          MlgError *error);

/**
 * Takes tets made elsewhere; each vertex of the surface is carried by the tet that holds it, or
 * the nearest one. Tets of another surface, or in another unit, are refused. Free with
 * `mlg_tetrahedralization_free`.
 */
MlgStatus mlg_tetrahedralization_from_tets(const MlgTriMesh *surface,
                                           const MlgTetMesh *tets,
                                           MlgTetrahedralization **out_tets,
                                           MlgError *error);

/**
 * The tets' points: `3 * *out_count` coordinates, borrowed until the object is freed. NULL for a
 * handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_tetrahedralization_points(const MlgTetrahedralization *tets,
                                            size_t *out_count);

/**
 * The tets: `4 * *out_count` vertex indices, borrowed until the object is freed. NULL for a handle
 * that is not valid. `out_count`: may be NULL.
 */
const uint32_t *mlg_tetrahedralization_tets(const MlgTetrahedralization *tets,
                                            size_t *out_count);

/**
 * The share of each tet that is inside the surface, 0 to 1: `*out_count` numbers, one per tet,
 * borrowed until the object is freed. NULL for a handle that is not valid. `out_count`: may be
 * NULL.
 */
const double *mlg_tetrahedralization_inside_fractions(const MlgTetrahedralization *tets,
                                                      size_t *out_count);

/**
 * What made the tets: `MLG_TETS_TETGEN`, `MLG_TETS_LATTICE` or `MLG_TETS_GIVEN`; UINT32_MAX for a
 * handle that is not valid.
 */
uint32_t mlg_tetrahedralization_method(const MlgTetrahedralization *tets);

/**
 * 1 if the surface's own triangles are the boundary of the tets, else 0.
 */
uint32_t mlg_tetrahedralization_boundary_kept(const MlgTetrahedralization *tets);

/**
 * Number of warnings.
 */
size_t mlg_tetrahedralization_warning_count(const MlgTetrahedralization *tets);

/**
 * One warning: a sentence in UTF-8, borrowed until the object is freed. NULL if `index` is not
 * below the count.
 */
const char *mlg_tetrahedralization_warning(const MlgTetrahedralization *tets, size_t index);

/**
 * Measures the tets. `out_quality`: its `struct_size` must be set.
 */
MlgStatus mlg_tetrahedralization_quality(const MlgTetrahedralization *tets,
                                         MlgTetQuality *out_quality,
                                         MlgError *error);

/**
 * Frees tets. NULL and handles freed already are allowed. Objects made from it stay valid.
 */
void mlg_tetrahedralization_free(MlgTetrahedralization *tets);

/* ================================================================================================
 * Reshaping: the problem and its options.
 * ================================================================================================ */

/**
 * How to reshape. Set with `mlg_reshaping_options_init`. Lengths are in the template's unit; 0
 * takes a default relative to the template's size.
 */
typedef struct MlgReshapingOptions {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * How far a marker may be off. 0 (default): the template's diagonal / 1000.
   */
  double tolerance;
  /**
   * How far a landmark may be off. 0 (default): 5 times `tolerance`.
   */
  double landmark_tolerance;
  /**
   * How far an attachment may be off. 0 (default): `tolerance`.
   */
  double attachment_tolerance;
  /**
   * Weight of the smoothness of the plastic strain, dimensionless. Default: 0.08.
   */
  double smoothness;
  /**
   * Distance over which the strain returns to its mean away from data, as a multiple of the cube
   * root of the template's volume; INFINITY: never. 0 (default): by how much of it was seen.
   */
  double screening;
  /**
   * Poisson's ratio of the tissue, above 0 and below 0.5. Default: 0.3.
   */
  double poisson;
  /**
   * 1: attachments are met whatever the markers say. 0 (default): they are weighed.
   */
  uint32_t hard_attachments;
  /**
   * Gauss-Newton iterations allowed. Default: 80; 0 stands for it, too.
   */
  uint32_t max_iterations;
  /**
   * Threads to use, up to 1024; 0 (default): all. The result does not depend on it.
   */
  uint32_t thread_count;
  /**
   * 1: the published formulation, for comparison. 0 (default): the improved one.
   */
  uint32_t paper;
  /**
   * 1 (default): template points far from every marker are pulled back, except beyond the ends of
   * a scan that cuts the organ. 0: they are left alone.
   */
  uint32_t reverse_term;
  /**
   * Leave at 0.
   */
  uint32_t reserved;
  /**
   * How often the shape reached may be filled with new tets, where a very large change has made the
   * old ones so flat that nothing more is gained. Default: 3; 0: never. The result's tets are the new ones.
   */
  uint32_t max_remeshes;
  /**
   * Leave at 0.
   */
  uint32_t reserved_too;
} MlgReshapingOptions;

/**
 * Writes the defaults. `struct_size`: `sizeof *out_options`.
 */
MlgStatus mlg_reshaping_options_init(MlgReshapingOptions *out_options, size_t struct_size);

/**
 * Makes a problem of a carried template, without data yet. Free with `mlg_reshaping_free`.
 */
MlgStatus mlg_reshaping_new(const MlgTetrahedralization *template_tets,
                            MlgReshaping **out_problem,
                            MlgError *error);

/**
 * Sets the markers: points of the person's surface, without correspondence. Replaces earlier ones.
 *
 * `points`: `3 * count` coordinates, finite, in the template's unit and frame. `weights`: `count`
 * numbers, 0 or more, or NULL for 1 throughout.
 */
MlgStatus mlg_reshaping_set_markers(MlgReshaping *problem,
                                    const double *points,
                                    const double *weights,
                                    size_t count,
                                    MlgError *error);

/**
 * Sets each marker's own noise, in place of the `tolerance` of all. `sigmas`: `count` numbers, finite
 * and 0 or more, as many as there are markers; 0 stands for the tolerance. Other markers forget it.
 */
MlgStatus mlg_reshaping_set_marker_sigmas(MlgReshaping *problem,
                                          const double *sigmas,
                                          size_t count,
                                          MlgError *error);

/**
 * Sets the landmarks: template points with known targets. Replaces earlier ones.
 *
 * `template_points` and `targets`: `3 * count` coordinates each, finite; the template points lie
 * on or in the template at rest. `weights`: `count` numbers, 0 or more, or NULL for 1 throughout.
 */
MlgStatus mlg_reshaping_set_landmarks(MlgReshaping *problem,
                                      const double *template_points,
                                      const double *targets,
                                      const double *weights,
                                      size_t count,
                                      MlgError *error);

/**
 * Like `mlg_reshaping_set_landmarks`, the template points being vertices of the surface:
 * `template_vertices` holds `count` indices from 0.
 */
MlgStatus mlg_reshaping_set_landmarks_at_vertices(MlgReshaping *problem,
                                                  const uint32_t *template_vertices,
                                                  const double *targets,
                                                  const double *weights,
                                                  size_t count,
                                                  MlgError *error);

/**
 * Makes landmarks pins: they end within a distance of their targets, whatever the markers say. `within`:
 * `count` lengths, as many as there are landmarks; 0: at the target itself; below 0: no pin, weighed
 * against the markers by the `landmark_tolerance`. Other landmarks forget it.
 */
MlgStatus mlg_reshaping_set_pins(MlgReshaping *problem,
                                 const double *within,
                                 size_t count,
                                 MlgError *error);

/**
 * Sets the attachments: template points that are held at their targets mechanically, such as the
 * places where a muscle grows on a bone. Replaces earlier ones. Arrays as for
 * `mlg_reshaping_set_landmarks`.
 */
MlgStatus mlg_reshaping_set_attachments(MlgReshaping *problem,
                                        const double *template_points,
                                        const double *targets,
                                        const double *weights,
                                        size_t count,
                                        MlgError *error);

/**
 * Like `mlg_reshaping_set_attachments`, the template points being vertices of the surface:
 * `template_vertices` holds `count` indices from 0.
 */
MlgStatus mlg_reshaping_set_attachments_at_vertices(MlgReshaping *problem,
                                                    const uint32_t *template_vertices,
                                                    const double *targets,
                                                    const double *weights,
                                                    size_t count,
                                                    MlgError *error);

/**
 * Sets the vertices of the surface that stay where they are. Replaces earlier ones. `vertices`:
 * `count` indices from 0.
 */
MlgStatus mlg_reshaping_set_fixed(MlgReshaping *problem,
                                  const uint32_t *vertices,
                                  size_t count,
                                  MlgError *error);

/**
 * Frees a problem. NULL and handles freed already are allowed. Runs started from it go on.
 */
void mlg_reshaping_free(MlgReshaping *problem);

/* ================================================================================================
 * Landmarks and attachments: places on a template and their targets, from files or bones.
 * ================================================================================================ */

/**
 * Vertex of a pair whose place is no vertex of the template.
 */
#define MLG_NO_VERTEX UINT32_MAX

/**
 * Makes pairs of template points and targets, `3 * count` coordinates each. `weights`: `count` numbers, 0
 * or more, or NULL for 1 throughout. `labels`: `count` strings, any of them NULL, or NULL for none;
 * a pair without one is called by its number. Free with `mlg_pairs_free`.
 */
MlgStatus mlg_pairs_new(const double *template_points,
                        const double *targets,
                        const double *weights,
                        const char *const *labels,
                        size_t count,
                        MlgPairs **out_pairs,
                        MlgError *error);

/**
 * Reads landmarks. `path`: a CSV file with `template_x,template_y,template_z` or `vertex`, and
 * `target_x,target_y,target_z`, and where they are there `label`, `weight`, `within`; or a marker file with points on the template, if `person_path` is
 * the marker file with the same labels on the person (else NULL). `template_surface`: where the
 * places are looked up. Free with `mlg_pairs_free`.
 */
MlgStatus mlg_pairs_load_landmarks(const MlgTriMesh *template_surface,
                                   const char *path,
                                   const char *person_path,
                                   MlgPairs **out_pairs,
                                   MlgError *error);

/**
 * Reads attachments from a CSV file: the template's place (`template_x`, ... or `vertex`), its
 * target (`target_x`, ...), and where they are there the template's bone point
 * (`template_bone_x`, ...), `label` and `weight`. `keep_gap`: 1 to keep the template's distance
 * between muscle and bone, turned as the bone is; 0 to go to the target itself. Free with
 * `mlg_pairs_free`.
 */
MlgStatus mlg_pairs_load_attachments(const MlgTriMesh *template_surface,
                                     const char *path,
                                     uint32_t keep_gap,
                                     MlgPairs **out_pairs,
                                     MlgError *error);

/**
 * Attaches a template to a bone: each vertex of the bone within `distance` of the template holds
 * the template's point nearest to it, at the distance it has there. `bone`: the bone beside the
 * template at rest. `person_bone`: the same vertices where the person has them (`bone` itself if it
 * stays). Free with `mlg_pairs_free`.
 */
MlgStatus mlg_pairs_from_bone(const MlgTriMesh *template_surface,
                              const MlgTriMesh *bone,
                              const MlgTriMesh *person_bone,
                              double distance,
                              MlgPairs **out_pairs,
                              MlgError *error);

/**
 * Attaches chosen vertices of a template to a bone: each holds at the bone's vertex nearest to it, at the distance
 * it has there. `vertices`: `count` indices of the template. `bone` and `person_bone` as in
 * `mlg_pairs_from_bone`. Free with `mlg_pairs_free`.
 */
MlgStatus mlg_pairs_from_vertices(const MlgTriMesh *template_surface,
                                  const uint32_t *vertices,
                                  size_t count,
                                  const MlgTriMesh *bone,
                                  const MlgTriMesh *person_bone,
                                  MlgPairs **out_pairs,
                                  MlgError *error);

/**
 * The places on the template: `3 * *out_count` coordinates, borrowed until the pairs are freed.
 * NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_pairs_template_points(const MlgPairs *pairs, size_t *out_count);

/**
 * The template's vertices: `*out_count` indices, `MLG_NO_VERTEX` where the file names none;
 * borrowed until the pairs are freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const uint32_t *mlg_pairs_template_vertices(const MlgPairs *pairs,
                                            size_t *out_count);

/**
 * The targets: `3 * *out_count` coordinates, borrowed until the pairs are freed. NULL for a handle
 * that is not valid. `out_count`: may be NULL.
 */
const double *mlg_pairs_targets(const MlgPairs *pairs, size_t *out_count);

/**
 * The weights: `*out_count` numbers, borrowed until the pairs are freed. NULL for a handle that is
 * not valid. `out_count`: may be NULL.
 */
const double *mlg_pairs_weights(const MlgPairs *pairs, size_t *out_count);

/**
 * How far each landmark that is a pin may end from its target, below 0 for those that are none:
 * `*out_count` numbers, borrowed until the pairs are freed. NULL for a handle that is not valid.
 * `out_count`: may be NULL.
 */
const double *mlg_pairs_within(const MlgPairs *pairs, size_t *out_count);

/**
 * The name of one pair: UTF-8, borrowed until the pairs are freed. NULL if `index` is not below the
 * count or the handle is not valid.
 */
const char *mlg_pairs_label(const MlgPairs *pairs, size_t index);

/**
 * What was left out, such as labels that only one file has: a sentence in UTF-8, borrowed until the
 * pairs are freed; NULL if nothing was.
 */
const char *mlg_pairs_warning(const MlgPairs *pairs);

/**
 * Frees pairs. NULL and handles freed already are allowed.
 */
void mlg_pairs_free(MlgPairs *pairs);

/**
 * Sets the landmarks of a problem; replaces earlier ones. Like `mlg_reshaping_set_landmarks`, with
 * the names and vertices that `pairs` has.
 */
MlgStatus mlg_reshaping_set_landmark_pairs(MlgReshaping *problem,
                                           const MlgPairs *pairs,
                                           MlgError *error);

/**
 * Sets the attachments of a problem; replaces earlier ones. Like `mlg_reshaping_set_attachments`,
 * with the names and vertices that `pairs` has.
 */
MlgStatus mlg_reshaping_set_attachment_pairs(MlgReshaping *problem,
                                             const MlgPairs *pairs,
                                             MlgError *error);

/**
 * Sets the vertices that stay from a CSV file with `vertex`, or `x,y,z`, or both; replaces earlier
 * ones. `path`: UTF-8.
 */
MlgStatus mlg_reshaping_load_fixed(MlgReshaping *problem, const char *path, MlgError *error);

/* ================================================================================================
 * Before a reshaping: where the template is to lie.
 * ================================================================================================ */

/**
 * Turn and move only.
 */
#define MLG_ALIGN_RIGID 0

/**
 * Turn, move and scale.
 */
#define MLG_ALIGN_SIMILARITY 1

/**
 * Finds where to put a template so that the markers lie on its surface. Three or more landmarks
 * that are not on one line decide alone; otherwise at least three markers are needed.
 *
 * `freedom`: `MLG_ALIGN_RIGID` or `MLG_ALIGN_SIMILARITY`. `markers`: `3 * marker_count`
 * coordinates. `landmarks` and `landmark_targets`: `3 * landmark_count` coordinates each, places on
 * the template and where they are on the person. Either may be NULL if its count is 0.
 * `out_person_from_template`: room for 16 numbers, a 4x4 matrix, row by row.
 */
MlgStatus mlg_tri_mesh_align(const MlgTriMesh *template_surface,
                             uint32_t freedom,
                             const double *markers,
                             size_t marker_count,
                             const double *landmarks,
                             const double *landmark_targets,
                             size_t landmark_count,
                             double *out_person_from_template,
                             MlgError *error);

/**
 * Finds the motion that brings points nearest to their targets, in the sense of least squares (Horn 1987,
 * Umeyama 1991). One pair gives a translation; where pairs leave the rotation open it is the smallest.
 *
 * `freedom`: `MLG_ALIGN_RIGID` or `MLG_ALIGN_SIMILARITY`. `points` and `targets`: `3 * count`
 * coordinates each, at least one pair. `out_targets_from_points`: room for 16 numbers, a 4x4 matrix,
 * row by row.
 */
MlgStatus mlg_points_align(uint32_t freedom,
                           const double *points,
                           const double *targets,
                           size_t count,
                           double *out_targets_from_points,
                           MlgError *error);

/* ================================================================================================
 * Findings: what is suspicious before a reshaping is run, and what mends it.
 * ================================================================================================ */

/**
 * What a finding is about.
 */
typedef enum MlgConcern {
  /**
   * Too few points.
   */
  MLG_CONCERN_AMOUNT = 0,
  /**
   * The template's surface: holes, flipped triangles.
   */
  MLG_CONCERN_SURFACE = 1,
  /**
   * Template and person are in two units.
   */
  MLG_CONCERN_UNIT = 2,
  /**
   * One is in LPS, the other in RAS.
   */
  MLG_CONCERN_FRAME = 3,
  /**
   * Y is up in one, Z in the other.
   */
  MLG_CONCERN_UP_AXIS = 4,
  /**
   * The template lies somewhere else.
   */
  MLG_CONCERN_PLACE = 5,
  /**
   * The template is of the other side of the body.
   */
  MLG_CONCERN_SIDE = 6,
  /**
   * Two landmarks have each other's targets.
   */
  MLG_CONCERN_EXCHANGE = 7,
  /**
   * Landmarks or attachments are not on the template, or contradict each other.
   */
  MLG_CONCERN_LANDMARKS = 8,
  /**
   * The attachments do not hold the body.
   */
  MLG_CONCERN_ATTACHMENTS = 9,
} MlgConcern;

/**
 * What becomes of a run all the same.
 */
typedef enum MlgSeverity {
  /**
   * A good result, perhaps less than could be.
   */
  MLG_SEVERITY_NOTE = 0,
  /**
   * Probably nonsense.
   */
  MLG_SEVERITY_DOUBTFUL = 1,
  /**
   * Nonsense: the command line refuses to begin.
   */
  MLG_SEVERITY_REFUSED = 2,
} MlgSeverity;

/**
 * A finding. Lengths are in the template's unit.
 */
typedef struct MlgFinding {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * A number of `MlgConcern`.
   */
  uint32_t concern;
  /**
   * A number of `MlgSeverity`.
   */
  uint32_t severity;
  /**
   * How far the person's points are from the template on average; NAN where that is not the matter.
   */
  double distance;
  /**
   * How far they are once it is mended; NAN where that is not known.
   */
  double mended_distance;
  /**
   * 1 if `motion` mends it.
   */
  uint32_t has_motion;
  /**
   * 1 if swapping the targets of the landmarks `first` and `second` mends it.
   */
  uint32_t has_exchange;
  /**
   * A landmark, by its number from 0.
   */
  uint32_t first;
  /**
   * The other one.
   */
  uint32_t second;
  /**
   * Where to move the template: a 4x4 matrix, row by row, for points as columns. A mirror image
   * where its determinant is below 0. The identity if `has_motion` is 0.
   */
  double motion[16];
} MlgFinding;

/**
 * The name of an `MlgConcern`, e.g. "UP_AXIS"; "UNKNOWN" for other numbers. Static, never NULL.
 */
const char *mlg_concern_name(uint32_t concern);

/**
 * The name of an `MlgSeverity`, e.g. "DOUBTFUL"; "UNKNOWN" for other numbers. Static, never NULL.
 */
const char *mlg_severity_name(uint32_t severity);

/**
 * Checks a problem's template, markers and pairs against each other, as the command line does before
 * it starts: other units, another frame, contradictory landmarks, holes. What cannot work is an
 * error. What may be a mistake is written into `buffer`, one sentence per line: UTF-8,
 * zero-terminated, cut to `capacity` bytes. `buffer` may be NULL if `capacity` is 0. `out_length`:
 * bytes of the whole text without the zero; may be NULL. `mlg_tri_mesh_inspect` tells more.
 */
MlgStatus mlg_reshaping_check(const MlgReshaping *problem,
                              char *buffer,
                              size_t capacity,
                              size_t *out_length,
                              MlgError *error);

/**
 * Looks at a template and what it is to follow before any tets are made: units, frames, up axes, place,
 * side, exchanged or contradictory landmarks, holes. It is no error that something is found.
 *
 * `markers`: `3 * marker_count` coordinates; those that count. `landmarks`, `attachments`: NULL for none.
 * `fixed`: `fixed_count` vertices. Free with `mlg_findings_free`.
 */
MlgStatus mlg_tri_mesh_inspect(const MlgTriMesh *template_surface,
                               const double *markers,
                               size_t marker_count,
                               const MlgPairs *landmarks,
                               const MlgPairs *attachments,
                               const uint32_t *fixed,
                               size_t fixed_count,
                               MlgFindings **out_findings,
                               MlgError *error);

/**
 * How many findings there are; 0 for a handle that is not valid.
 */
size_t mlg_findings_count(const MlgFindings *findings);

/**
 * Tells a finding, a number from 0. `out_finding`: its `struct_size` must be set.
 */
MlgStatus mlg_findings_get(const MlgFindings *findings,
                           size_t index,
                           MlgFinding *out_finding,
                           MlgError *error);

/**
 * What is wrong, and what can be done: one sentence, borrowed until the findings are freed; NULL if there
 * is no such finding.
 */
const char *mlg_findings_text(const MlgFindings *findings,
                              size_t index);

/**
 * Frees findings; NULL is fine.
 */
void mlg_findings_free(MlgFindings *findings);

/* ================================================================================================
 * Reshaping: started, or run to its end.
 * ================================================================================================ */

/**
 * Starts a reshaping on a thread of its own and returns at once. The problem is copied: it may be
 * changed or freed while the run goes on. `options`: NULL for the defaults. Free the run with
 * `mlg_run_free`.
 */
MlgStatus mlg_reshaping_start(const MlgReshaping *problem,
                              const MlgReshapingOptions *options,
                              MlgRun **out_run,
                              MlgError *error);

/**
 * Starts a reshaping from the shape of an earlier result: the quick way after a landmark was moved,
 * markers came or went. `problem` must have the template and tets of the earlier one, `options` the
 * same values; else the run fails with a sentence. The earlier result may be freed at once. All
 * else is as for `mlg_reshaping_start`.
 */
MlgStatus mlg_reshaping_start_again(const MlgReshapingResult *earlier,
                                    const MlgReshaping *problem,
                                    const MlgReshapingOptions *options,
                                    MlgRun **out_run,
                                    MlgError *error);

/**
 * Waits for the end of a reshaping and hands its result over, once. A cancelled run gives its best
 * shape so far, marked by `stop` in its summary, or `MLG_STATUS_CANCELLED` if it had none yet. Free
 * the result with `mlg_reshaping_result_free`, and the run with `mlg_run_free`.
 */
MlgStatus mlg_run_wait_reshaping(MlgRun *run, MlgReshapingResult **out_result, MlgError *error);

/**
 * Reshapes and returns when it is done: `mlg_reshaping_start` and `mlg_run_wait_reshaping` in one.
 * Free the result with `mlg_reshaping_result_free`.
 */
MlgStatus mlg_reshaping_run(const MlgReshaping *problem,
                            const MlgReshapingOptions *options,
                            MlgReshapingResult **out_result,
                            MlgError *error);

/* ================================================================================================
 * What a reshaping gave.
 * ================================================================================================ */

/**
 * Why a reshaping ended. Reaching a limit is no error: the result is there.
 */
typedef enum MlgStop {
  /**
   * The objective no longer falls by a relevant amount.
   */
  MLG_STOP_SETTLED = 0,
  /**
   * All markers are within the tolerance.
   */
  MLG_STOP_TOLERANCE_MET = 1,
  /**
   * No step lowers the objective although it should.
   */
  MLG_STOP_NO_STEP = 2,
  /**
   * The iterations ran out.
   */
  MLG_STOP_ITERATION_LIMIT = 3,
  /**
   * The caller asked to stop.
   */
  MLG_STOP_CANCELLED = 4,
} MlgStop;

/**
 * The course of a reshaping. Lengths are in the template's unit.
 */
typedef struct MlgReshapingSummary {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Why it ended: a number of `MlgStop`.
   */
  uint32_t stop;
  /**
   * Gauss-Newton iterations.
   */
  uint32_t iterations;
  /**
   * Newton steps of all static solves.
   */
  uint32_t newton_steps;
  /**
   * Tets of no or negative volume in the result.
   */
  uint32_t inverted_tets;
  /**
   * Mean distance of the markers to the result; NaN without markers.
   */
  double mean_marker_distance;
  /**
   * Largest distance of a marker to the result; NaN without markers.
   */
  double max_marker_distance;
  /**
   * Seconds it took.
   */
  double seconds;
  /**
   * How often the shape reached was filled with new tets.
   */
  uint32_t remeshes;
  /**
   * Always 0.
   */
  uint32_t reserved;
} MlgReshapingSummary;

/**
 * The name of an `MlgStop`, e.g. "SETTLED"; "UNKNOWN" for other numbers. Static, never NULL.
 */
const char *mlg_stop_name(uint32_t stop);

/**
 * The surface's points, in the template's order: `3 * *out_count` coordinates, borrowed until the
 * result is freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_reshaping_result_points(const MlgReshapingResult *result,
                                          size_t *out_count);

/**
 * The four corners of each tet of the result: `4 * *out_count` indices, borrowed until the result is
 * freed. The tets of the problem, unless new ones were made (`remeshes` in the summary). NULL for a
 * handle that is not valid. `out_count`: may be NULL.
 */
const uint32_t *mlg_reshaping_result_tets(const MlgReshapingResult *result,
                                          size_t *out_count);

/**
 * The points of these tets, in their order: `3 * *out_count` coordinates, borrowed until the result is
 * freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_reshaping_result_tet_points(const MlgReshapingResult *result,
                                              size_t *out_count);

/**
 * The plastic strain Fp of each of these tets, from the template to the person: `9 * *out_count`
 * numbers, a symmetric 3x3 matrix each; borrowed until the result is freed. NULL for a handle that is
 * not valid. `out_count`: may be NULL.
 */
const double *mlg_reshaping_result_plastic_strains(const MlgReshapingResult *result,
                                                   size_t *out_count);

/**
 * The largest principal stretch of the deformation at each vertex of the surface: `*out_count`
 * numbers, 1 where nothing was stretched; borrowed until the result is freed. NULL for a handle that
 * is not valid. `out_count`: may be NULL.
 */
const double *mlg_reshaping_result_max_stretches(const MlgReshapingResult *result,
                                                 size_t *out_count);

/**
 * The smallest principal stretch of the deformation at each vertex of the surface, as
 * `mlg_reshaping_result_max_stretches`.
 */
const double *mlg_reshaping_result_min_stretches(const MlgReshapingResult *result,
                                                 size_t *out_count);

/**
 * Carries other points along by the deformation: vessels inside, a textured mesh around.
 *
 * `points`: `3 * count` coordinates at rest, finite; those outside the tets go with the nearest
 * one. `out_points`: room for `3 * count` coordinates; may be `points` itself.
 */
MlgStatus mlg_reshaping_result_carry(const MlgReshapingResult *result,
                                     const double *points,
                                     size_t count,
                                     double *out_points,
                                     MlgError *error);

/**
 * Writes the deformed tets as `.vtu` (VTK, for ParaView) with the plastic strain, its principal
 * stretches and the inside fraction of each tet and the rest position of each point. `path`: UTF-8.
 */
MlgStatus mlg_reshaping_result_save_tets(const MlgReshapingResult *result,
                                         const char *path,
                                         MlgError *error);

/**
 * Tells how it went. `out_summary`: its `struct_size` must be set.
 */
MlgStatus mlg_reshaping_result_summary(const MlgReshapingResult *result,
                                       MlgReshapingSummary *out_summary,
                                       MlgError *error);

/**
 * Measures the tets of the result. `out_quality`: its `struct_size` must be set.
 */
MlgStatus mlg_reshaping_result_quality(const MlgReshapingResult *result,
                                       MlgTetQuality *out_quality,
                                       MlgError *error);

/**
 * Frees a result. NULL and handles freed already are allowed.
 */
void mlg_reshaping_result_free(MlgReshapingResult *result);

/* ================================================================================================
 * What a reshaping gave: how far markers, landmarks and attachments are from it.
 * ================================================================================================ */

/**
 * The distance of each marker to the result: `*out_count` numbers in the markers' order, borrowed
 * until the result is freed. NULL without markers or for a handle that is not valid. `out_count`:
 * may be NULL.
 */
const double *mlg_reshaping_result_marker_distances(const MlgReshapingResult *result,
                                                    size_t *out_count);

/**
 * The distance of each landmark's place on the result to its target: `*out_count` numbers in the order in
 * which they were set, borrowed until the result is freed. NULL without landmarks or for a handle that is
 * not valid. `out_count`: may be NULL.
 */
const double *mlg_reshaping_result_landmark_distances(const MlgReshapingResult *result,
                                                      size_t *out_count);

/**
 * The distance of each attachment's place on the result to its target: `*out_count` numbers in the order in
 * which they were set, borrowed until the result is freed. NULL without attachments or for a handle that is
 * not valid. `out_count`: may be NULL.
 */
const double *mlg_reshaping_result_attachment_distances(const MlgReshapingResult *result,
                                                        size_t *out_count);

/* ================================================================================================
 * How sure a reshaped template is: plausible shapes, and how far they differ.
 * ================================================================================================ */

/**
 * Size of the result and how sure it is. In the template's unit.
 */
typedef struct MlgUncertaintySummary {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Plausible shapes.
   */
  size_t shapes;
  /**
   * Volume inside the surface; NaN for one that is not closed.
   */
  double volume;
  /**
   * Its standard deviation.
   */
  double volume_sd;
  /**
   * Surface area.
   */
  double area;
  /**
   * Its standard deviation.
   */
  double area_sd;
} MlgUncertaintySummary;

/**
 * Finds plausible shapes beside a result: samples of the posterior, linearized about it. Takes about as
 * long as one iteration.
 *
 * `shapes`: how many, at least 2; 64 give a standard deviation to a tenth of itself. The first ones are the
 * same whatever their number.
 */
MlgStatus mlg_uncertainty_new(const MlgReshapingResult *result,
                              size_t shapes,
                              MlgUncertainty **out_uncertainty,
                              MlgError *error);

/**
 * Standard deviation of each vertex of the surface across it: `*out_count` numbers, borrowed until the object
 * is freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_uncertainty_sd_normal(const MlgUncertainty *uncertainty,
                                        size_t *out_count);

/**
 * Standard deviation of each vertex of the surface in all directions, the root of the mean squared distance,
 * as `mlg_uncertainty_sd_normal`.
 */
const double *mlg_uncertainty_sd(const MlgUncertainty *uncertainty,
                                 size_t *out_count);

/**
 * Gives the surface's points of one plausible shape, in the template's order.
 *
 * `number`: from 0. `out_points`: room for `3 * count` coordinates, `count` the number of the template's
 * vertices.
 */
MlgStatus mlg_uncertainty_shape(const MlgUncertainty *uncertainty,
                                size_t number,
                                double *out_points,
                                size_t count,
                                MlgError *error);

/**
 * Tells the result's size and how sure it is. `out_summary`: its `struct_size` must be set.
 */
MlgStatus mlg_uncertainty_summary(const MlgUncertainty *uncertainty,
                                  MlgUncertaintySummary *out_summary,
                                  MlgError *error);

/**
 * Frees plausible shapes. NULL and handles freed already are allowed.
 */
void mlg_uncertainty_free(MlgUncertainty *uncertainty);

/* ================================================================================================
 * Separation of bodies that overlap: the problem, its options, the run.
 * ================================================================================================ */

/**
 * How to separate. Set with `mlg_separation_options_init`. Lengths are in the bodies' unit.
 */
typedef struct MlgSeparationOptions {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * Distance to leave between surfaces; 0 (default): the median diagonal of the bodies / 2000.
   */
  double gap;
  /**
   * Vertices up to this many edges away from an overlap may move. Default 5.
   */
  uint32_t rings;
  /**
   * Threads to use; 0 (default): all. The result does not depend on it.
   */
  uint32_t thread_count;
} MlgSeparationOptions;

/**
 * Writes the defaults. `struct_size`: `sizeof *out_options`.
 */
MlgStatus mlg_separation_options_init(MlgSeparationOptions *out_options, size_t struct_size);

/**
 * Makes a separation without bodies yet. Free with `mlg_separation_free`.
 */
MlgStatus mlg_separation_new(MlgSeparation **out_problem, MlgError *error);

/**
 * Adds a soft body in its present shape; bodies are numbered from 0 in the order of being added.
 *
 * `name`: UTF-8, unique among bodies and obstacles. `surface`: lies in the tets, also in its present
 * shape; NULL: the boundary of the tets, whose vertices then come in their order in the tet mesh.
 */
MlgStatus mlg_separation_add_body(MlgSeparation *problem,
                                  const char *name,
                                  const MlgTetMesh *tets,
                                  const MlgTriMesh *surface,
                                  MlgError *error);

/**
 * Adds the result of a reshaping as a soft body, with its surface and its markers. `name`: UTF-8,
 * unique. The result may be freed at once.
 */
MlgStatus mlg_separation_add_result(MlgSeparation *problem,
                                    const char *name,
                                    const MlgReshapingResult *result,
                                    MlgError *error);

/**
 * Adds something that does not move, such as a bone; obstacles are numbered after all bodies.
 * `name`: UTF-8, unique. `surface`: may be freed afterwards.
 */
MlgStatus mlg_separation_add_obstacle(MlgSeparation *problem,
                                      const char *name,
                                      const MlgTriMesh *surface,
                                      MlgError *error);

/**
 * Sets markers of the person's surface that a body meets: its surface is held there as far as
 * contact allows; replaces earlier ones. `body`: a number from 0. `points`: `3 * count` coordinates,
 * finite; may be NULL if `count` is 0.
 */
MlgStatus mlg_separation_set_markers(MlgSeparation *problem,
                                     size_t body,
                                     const double *points,
                                     size_t count,
                                     MlgError *error);

/**
 * Starts a separation on a thread of its own and returns at once. The problem is copied: it may be
 * changed or freed while the run goes on. Its preview has the surfaces of all bodies. `options`:
 * NULL for the defaults. Free the run with `mlg_run_free`.
 */
MlgStatus mlg_separation_start(const MlgSeparation *problem,
                               const MlgSeparationOptions *options,
                               MlgRun **out_run,
                               MlgError *error);

/**
 * Waits for the end of a separation and hands its result over, once. A cancelled run gives the shapes
 * with the least overlap so far, marked by `ending` in its summary, or `MLG_STATUS_CANCELLED` if it
 * had none yet. Free the result with `mlg_separation_result_free`, and the run with `mlg_run_free`.
 */
MlgStatus mlg_run_wait_separation(MlgRun *run,
                                  MlgSeparationResult **out_result,
                                  MlgError *error);

/**
 * Separates and returns when it is done: `mlg_separation_start` and `mlg_run_wait_separation` in one.
 * Free the result with `mlg_separation_result_free`.
 */
MlgStatus mlg_separation_run(const MlgSeparation *problem,
                             const MlgSeparationOptions *options,
                             MlgSeparationResult **out_result,
                             MlgError *error);

/**
 * Frees a separation. NULL and handles freed already are allowed. Runs started from it go on.
 */
void mlg_separation_free(MlgSeparation *problem);

/* ================================================================================================
 * What a separation gave.
 * ================================================================================================ */

/**
 * Why a separation ended.
 */
typedef enum MlgEnding {
  /**
   * No contact is left.
   */
  MLG_ENDING_PARTED = 0,
  /**
   * Overlaps no longer shrank; the shapes with the least are the result.
   */
  MLG_ENDING_STALLED = 1,
  /**
   * It was stopped on request; the shapes with the least overlap so far are the result.
   */
  MLG_ENDING_CANCELLED = 2,
} MlgEnding;

/**
 * The course of a separation.
 */
typedef struct MlgSeparationSummary {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Why it ended: an `MlgEnding`.
   */
  uint32_t ending;
  /**
   * 1: no triangle of one surface crosses or lies inside another; decided exactly.
   */
  uint32_t separated;
  /**
   * Rounds of finding contacts and solving.
   */
  uint32_t rounds;
  /**
   * Pairs of surfaces that overlap or did; `mlg_separation_result_overlap` tells about each.
   */
  uint32_t overlap_count;
  /**
   * Seconds it took.
   */
  double seconds;
} MlgSeparationSummary;

/**
 * Two surfaces that overlap or did, before (index 0) and after (index 1). Lengths are in the bodies'
 * unit.
 */
typedef struct MlgOverlap {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Number of the first surface: bodies from 0, then obstacles.
   */
  uint32_t first;
  /**
   * Number of the second.
   */
  uint32_t second;
  /**
   * Largest distance of a vertex inside to the other's surface.
   */
  double depth[2];
  /**
   * Vertices of either that lie inside the other.
   */
  uint32_t vertices_inside[2];
  /**
   * Pairs of triangles that cross.
   */
  uint32_t crossings[2];
} MlgOverlap;

/**
 * What a separation did to one body. Lengths are in the bodies' unit.
 */
typedef struct MlgSeparatedBody {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Vertices of its surface that moved.
   */
  uint32_t moved_vertices;
  /**
   * Tets of no or negative volume.
   */
  uint32_t inverted_tets;
  /**
   * The farthest move.
   */
  double largest_move;
  /**
   * Mean distance of its markers to its surface before (index 0) and after (1), of those outside
   * all obstacles; NaN without any.
   */
  double mean_marker_distance[2];
  /**
   * Largest such distance.
   */
  double max_marker_distance[2];
  /**
   * Markers inside an obstacle, which cannot be met.
   */
  uint32_t markers_inside_obstacles;
  /**
   * 0.
   */
  uint32_t reserved;
} MlgSeparatedBody;

/**
 * The name of an `MlgEnding`, e.g. "PARTED"; "UNKNOWN" for other numbers. Static, never NULL.
 */
const char *mlg_ending_name(uint32_t ending);

/**
 * The points of a body's surface, in its order: `3 * *out_count` coordinates, borrowed until the
 * result is freed. NULL if `body` is not below the count or the handle is not valid. `out_count`: may
 * be NULL.
 */
const double *mlg_separation_result_points(const MlgSeparationResult *result,
                                           size_t body,
                                           size_t *out_count);

/**
 * The points of a body's tets, in their order, as `mlg_separation_result_points`.
 */
const double *mlg_separation_result_tet_points(const MlgSeparationResult *result,
                                               size_t body,
                                               size_t *out_count);

/**
 * Tells how it went. `out_summary`: its `struct_size` must be set.
 */
MlgStatus mlg_separation_result_summary(const MlgSeparationResult *result,
                                        MlgSeparationSummary *out_summary,
                                        MlgError *error);

/**
 * Tells about a pair of surfaces that overlap or did, a number from 0 below `overlap_count` in the
 * summary. `out_overlap`: its `struct_size` must be set.
 */
MlgStatus mlg_separation_result_overlap(const MlgSeparationResult *result,
                                        size_t overlap,
                                        MlgOverlap *out_overlap,
                                        MlgError *error);

/**
 * Tells what was done to a body, a number from 0. `out_body`: its `struct_size` must be set.
 */
MlgStatus mlg_separation_result_body(const MlgSeparationResult *result,
                                     size_t body,
                                     MlgSeparatedBody *out_body,
                                     MlgError *error);

/**
 * Frees a result. NULL and handles freed already are allowed.
 */
void mlg_separation_result_free(MlgSeparationResult *result);

/* ================================================================================================
 * Medical images: slices, and lines on slices.
 * ================================================================================================ */

/**
 * What an image is.
 */
typedef struct MlgVolumeInfo {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * Voxels along each index.
   */
  size_t size[3];
  /**
   * World from voxel: the first three rows of a 4x4 matrix, row by row. An integer index is a
   * voxel's centre.
   */
  double world_from_voxel[12];
  /**
   * Millimetres between voxels along each index.
   */
  double spacing[3];
  /**
   * Smallest and largest value.
   */
  double range[2];
  /**
   * Width and level of the window that suits the image.
   */
  double window[2];
  /**
   * Lowest and highest corner of the box around the image, world.
   */
  double box_low[3];
  /**
   * Highest corner.
   */
  double box_high[3];
} MlgVolumeInfo;

/**
 * A rectangle of pixels in the world. Made by `mlg_volume_plane`, or by the caller.
 */
typedef struct MlgSlicePlane {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * World position of the first (top left) pixel's centre.
   */
  double corner[3];
  /**
   * Step to the next pixel in a row, mm.
   */
  double right[3];
  /**
   * Step to the next row, mm.
   */
  double down[3];
  /**
   * Pixels in a row.
   */
  size_t width;
  /**
   * Rows.
   */
  size_t height;
} MlgSlicePlane;

/**
 * Reads an image: NIfTI (`.nii`, `.nii.gz`), NRRD (`.nrrd`, `.nhdr`), MetaImage (`.mha`, `.mhd`), a
 * folder of DICOM slices, or the series of one DICOM file. `path`: UTF-8. Free with
 * `mlg_volume_free`.
 */
MlgStatus mlg_volume_load(const char *path, MlgVolume **out_volume, MlgError *error);

/**
 * Writes what the image is. Set `out_info->struct_size` before.
 */
MlgStatus mlg_volume_info(const MlgVolume *volume,
                          MlgVolumeInfo *out_info,
                          MlgError *error);

/**
 * What was noticed while reading, such as a tilted gantry: one sentence per line, written as by
 * `mlg_tri_mesh_check`.
 */
MlgStatus mlg_volume_notes(const MlgVolume *volume,
                           char *buffer,
                           size_t capacity,
                           size_t *out_length,
                           MlgError *error);

/**
 * A plane through an image, as large as the image needs, with square pixels. Set
 * `out_plane->struct_size` before.
 *
 * `axis`: three numbers; 0,0,1 is axial seen from the feet, 0,1,0 coronal seen from the front, 1,0,0
 * sagittal seen from the left, other directions are looked along. `position`: mm along the axis.
 * `pixel`: mm; 0: the image's smallest spacing.
 */
MlgStatus mlg_volume_plane(const MlgVolume *volume,
                           const double *axis,
                           double position,
                           double pixel,
                           MlgSlicePlane *out_plane,
                           MlgError *error);

/**
 * Draws a slice into the caller's buffer, row by row from the top.
 *
 * `channels`: 1 (grey) or 4 (red, green, blue, alpha; transparent outside the image).
 * `window`: two numbers, width and level: the values between black and white; NULL takes those of
 * `mlg_volume_info`. `pixels`: `capacity` bytes, at least `width * height * channels`.
 */
MlgStatus mlg_volume_slice(const MlgVolume *volume,
                           const MlgSlicePlane *plane,
                           const double *window,
                           uint32_t channels,
                           uint8_t *pixels,
                           size_t capacity,
                           MlgError *error);

/**
 * Frees an image. NULL and handles freed already are allowed.
 */
void mlg_volume_free(MlgVolume *volume);

/**
 * The lines along which a plane cuts a surface. Free with `mlg_polylines_free`.
 *
 * `points`: `3 * point_count` coordinates in place of the mesh's own, or NULL; `point_count` must be
 * that of the mesh (ignored for NULL). `plane_point`, `plane_normal`: three numbers each.
 */
MlgStatus mlg_tri_mesh_section(const MlgTriMesh *mesh,
                               const double *points,
                               size_t point_count,
                               const double *plane_point,
                               const double *plane_normal,
                               MlgPolylines **out_lines,
                               MlgError *error);

/**
 * The points of all lines, one line after the other: `3 * *out_count` coordinates, borrowed until
 * the lines are freed. NULL without points or for a handle that is not valid. `out_count`: may be
 * NULL.
 */
const double *mlg_polylines_points(const MlgPolylines *lines, size_t *out_count);

/**
 * Where each line begins among the points, and at the end their number: `*out_count` is one more
 * than the number of lines. Borrowed until the lines are freed.
 */
const size_t *mlg_polylines_starts(const MlgPolylines *lines, size_t *out_count);

/**
 * For each line 1 if its last point is joined to its first, else 0. Borrowed until the lines are
 * freed; NULL without lines.
 */
const uint8_t *mlg_polylines_closed(const MlgPolylines *lines, size_t *out_count);

/**
 * Frees lines. NULL and handles freed already are allowed.
 */
void mlg_polylines_free(MlgPolylines *lines);

/* ================================================================================================
 * Medical images from memory, and their voxels.
 * ================================================================================================ */

/**
 * How voxels lie in the world. Set with `mlg_volume_grid_init`.
 */
typedef struct MlgVolumeGrid {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * Voxels along each index.
   */
  size_t size[3];
  /**
   * Millimetres between voxels along each index. Default: 1.
   */
  double spacing[3];
  /**
   * Centre of the first voxel. Default: 0.
   */
  double origin[3];
  /**
   * A 3x3 matrix, row by row, whose columns are the directions of the indices. Default: the world's
   * own axes.
   */
  double directions[9];
  /**
   * 1: origin and directions are in LPS, as those of ITK and DICOM. 0 (default): in RAS.
   */
  uint32_t lps;
  /**
   * Leave at 0.
   */
  uint32_t reserved;
} MlgVolumeGrid;

/**
 * Writes the defaults. `struct_size`: `sizeof *out_grid`.
 */
MlgStatus mlg_volume_grid_init(MlgVolumeGrid *out_grid, size_t struct_size);

/**
 * Makes an image from an array, which is copied.
 *
 * `values`: `size[0] * size[1] * size[2]` of `grid`, the first index fastest; those that are not
 * finite become 0. Labels are whole numbers. Free with `mlg_volume_free`.
 */
MlgStatus mlg_volume_new(const float *values,
                         const MlgVolumeGrid *grid,
                         MlgVolume **out_volume,
                         MlgError *error);

/**
 * The values of all voxels, the first index fastest: `*out_count` numbers, borrowed until the image
 * is freed. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const float *mlg_volume_values(const MlgVolume *volume, size_t *out_count);

/* ================================================================================================
 * Label maps: which labels there are, their outlines, markers on them, their surfaces.
 * ================================================================================================ */

/**
 * How markers are put on the outlines of a label. Set with `mlg_clicks_init`.
 */
typedef struct MlgClicks {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * Millimetres between slices. Default: 9.
   */
  double every;
  /**
   * Millimetres between markers along an outline. Default: 8.
   */
  double spacing;
  /**
   * Standard deviation of a hand's error, mm. Default: 0, none.
   */
  double jitter;
  /**
   * Another number gives other errors. Default: 1.
   */
  uint64_t seed;
} MlgClicks;

/**
 * The labels of a label map, ascending, without 0: writes the first `capacity` of them to
 * `out_labels` and their number to `out_count`. An image whose values are no whole numbers, or more
 * than 4096 different ones, is refused. `out_labels` may be NULL if `capacity` is 0.
 */
MlgStatus mlg_volume_labels(const MlgVolume *labels,
                            uint32_t *out_labels,
                            size_t capacity,
                            size_t *out_count,
                            MlgError *error);

/**
 * The name that the file has for a label (TotalSegmentator's and 3D Slicer's have), in UTF-8, written as by
 * `mlg_tri_mesh_check`; empty where it has none.
 */
MlgStatus mlg_volume_label_name(const MlgVolume *labels,
                                uint32_t label,
                                char *buffer,
                                size_t capacity,
                                size_t *out_length,
                                MlgError *error);

/**
 * The outlines of one label of a label map on a plane, smooth over the voxels' stairs. Free with
 * `mlg_polylines_free`.
 */
MlgStatus mlg_volume_outlines(const MlgVolume *labels,
                              uint32_t label,
                              const MlgSlicePlane *plane,
                              MlgPolylines **out_lines,
                              MlgError *error);

/**
 * Writes the defaults. `struct_size`: `sizeof *out_clicks`.
 */
MlgStatus mlg_clicks_init(MlgClicks *out_clicks, size_t struct_size);

/**
 * Markers on the outlines of one label, as a person would click them on slices. Free with
 * `mlg_markers_free`.
 *
 * `axes`: `3 * axis_count` numbers, one view each as in `mlg_volume_plane`. `clicks`: NULL for the
 * defaults.
 */
MlgStatus mlg_volume_label_markers(const MlgVolume *labels,
                                   uint32_t label,
                                   const double *axes,
                                   size_t axis_count,
                                   const MlgClicks *clicks,
                                   MlgMarkers **out_markers,
                                   MlgError *error);

/**
 * The surface of one label, outwards, smooth over the voxels' stairs; open where the image ends inside
 * the label. Free with `mlg_tri_mesh_free`.
 */
MlgStatus mlg_volume_label_surface(const MlgVolume *labels,
                                   uint32_t label,
                                   MlgTriMesh **out_mesh,
                                   MlgError *error);

/* ================================================================================================
 * Skeletons from arrays: bones and joints.
 * ================================================================================================ */

/**
 * A joint between two bones. Set with `mlg_joint_init`.
 */
typedef struct MlgJoint {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * Its name, UTF-8, unique. As an answer: borrowed until the skeleton is freed.
   */
  const char *name;
  /**
   * Number of the parent bone, from 0.
   */
  uint32_t parent;
  /**
   * Number of the child bone, from 0.
   */
  uint32_t child;
  /**
   * 1 (default), or 0 for a joint that only closes a loop.
   */
  uint32_t in_tree;
  /**
   * 1: the frames below are given. 0 (default): the joint is put in the middle of the narrowest
   * gap between its bones, and the frames are not read.
   */
  uint32_t has_frames;
  /**
   * World from the joint's frame on the parent bone, in the skeleton's pose: a 4x4 matrix, row by
   * row, without scale.
   */
  double world_from_parent_frame[16];
  /**
   * World from the joint's frame on the child bone; the same in the neutral position.
   */
  double world_from_child_frame[16];
  /**
   * Largest rotations in the negative sense about x, y and z of the frame: radians, 0 or more;
   * INFINITY (default) leaves it free.
   */
  double negative_limits[3];
  /**
   * Largest rotations in the positive sense.
   */
  double positive_limits[3];
  /**
   * Largest distance of the two frames' origins, in the skeleton's unit. Below 0 (default): half a
   * percent of the skeleton's diagonal.
   */
  double shift_limit;
} MlgJoint;

/**
 * A bone to make a skeleton of.
 */
typedef struct MlgBone {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * Its name, UTF-8, unique.
   */
  const char *name;
  /**
   * Its surface; may be freed afterwards.
   */
  const MlgTriMesh *surface;
} MlgBone;

/**
 * Writes the defaults of a joint. `struct_size`: `sizeof *out_joint`.
 */
MlgStatus mlg_joint_init(MlgJoint *out_joint, size_t struct_size);

/**
 * Makes a skeleton from arrays, which are copied. `bones`: `bone_count` elements, at least one.
 * `joints`: `joint_count` elements; may be NULL if that is 0. All elements of an array have the same
 * `struct_size`. Free with `mlg_skeleton_free`.
 */
MlgStatus mlg_skeleton_new(const MlgBone *bones,
                           size_t bone_count,
                           const MlgJoint *joints,
                           size_t joint_count,
                           MlgSkeleton **out_skeleton,
                           MlgError *error);

/**
 * Frees a skeleton. NULL and handles freed already are allowed. Objects made from it stay valid.
 */
void mlg_skeleton_free(MlgSkeleton *skeleton);

/* ================================================================================================
 * What is in a skeleton: names, surfaces, joints, angles.
 * ================================================================================================ */

/**
 * Number of bones; 0 for a handle that is not valid.
 */
size_t mlg_skeleton_bone_count(const MlgSkeleton *skeleton);

/**
 * Number of joints; 0 for a handle that is not valid.
 */
size_t mlg_skeleton_joint_count(const MlgSkeleton *skeleton);

/**
 * The name of a bone: UTF-8, borrowed until the skeleton is freed. NULL if `bone` is not below the
 * count or the handle is not valid.
 */
const char *mlg_skeleton_bone_name(const MlgSkeleton *skeleton, size_t bone);

/**
 * The points of a bone: `3 * *out_count` coordinates, borrowed until the skeleton is freed. NULL if
 * `bone` is not below the count or the handle is not valid. `out_count`: may be NULL.
 */
const double *mlg_skeleton_bone_points(const MlgSkeleton *skeleton, size_t bone, size_t *out_count);

/**
 * The triangles of a bone: `3 * *out_count` indices of its own points, borrowed until the skeleton
 * is freed. NULL if `bone` is not below the count or the handle is not valid. `out_count`: may be
 * NULL.
 */
const uint32_t *mlg_skeleton_bone_triangles(const MlgSkeleton *skeleton,
                                            size_t bone,
                                            size_t *out_count);

/**
 * The points of all bones, one bone after the other, as previews have them: `3 * *out_count`
 * coordinates, borrowed until the skeleton is freed. NULL for a handle that is not valid.
 * `out_count`: may be NULL.
 */
const double *mlg_skeleton_points(const MlgSkeleton *skeleton, size_t *out_count);

/**
 * Tells all about a joint, its frames included. `out_joint`: its `struct_size` must be set.
 */
MlgStatus mlg_skeleton_joint(const MlgSkeleton *skeleton,
                             size_t joint,
                             MlgJoint *out_joint,
                             MlgError *error);

/**
 * The named angles of the joints in the skeleton's pose: `*out_count` numbers, radians, borrowed
 * until the skeleton is freed. NULL without such angles or for a handle that is not valid.
 * `out_count`: may be NULL.
 */
const double *mlg_skeleton_angles(const MlgSkeleton *skeleton, size_t *out_count);

/**
 * The name of an angle: UTF-8, borrowed until the skeleton is freed. NULL if `angle` is not below
 * the count or the handle is not valid.
 */
const char *mlg_skeleton_angle_name(const MlgSkeleton *skeleton, size_t angle);

/* ================================================================================================
 * Skeleton files, read and written.
 * ================================================================================================ */

/**
 * Reads a skeleton from a `.skeleton.json` file (its bones' surfaces lie where it says) or an
 * OpenSim 4 `.osim` model (surfaces beside it or in `Geometry/`). `path`: UTF-8. Free with
 * `mlg_skeleton_free`.
 */
MlgStatus mlg_skeleton_load(const char *path, MlgSkeleton **out_skeleton, MlgError *error);

/**
 * What was left out when the skeleton was read, one sentence per line: UTF-8, borrowed until the
 * skeleton is freed; empty if nothing was. NULL for a handle that is not valid.
 */
const char *mlg_skeleton_notes(const MlgSkeleton *skeleton);

/**
 * Writes a skeleton: a name that ends in `.json` takes the skeleton file, with the bones as `.obj`
 * in `bones/` beside it (texture coordinates and groups of bones that were read as `.obj` are kept);
 * `.glb` takes a scene in which each bone hangs on its joint and the soft tissues that the skeleton's file
 * names bend with the bones; a `.json` leaves them out. `path`: UTF-8.
 */
MlgStatus mlg_skeleton_save(const MlgSkeleton *skeleton,
                            const char *path,
                            MlgError *error);

/**
 * Writes a skeleton as a scene `.glb` that moves as a motion file says.
 *
 * `motion_path`: a `.mot`, `.sto` or `.bvh` file. `flipped`: `flipped_count` names of angles whose sign is
 * the opposite of the skeleton's; may be NULL if that is 0. `unit_in_metres`: of the skeleton; 0: as
 * its file says, else millimetres.
 */
MlgStatus mlg_skeleton_save_motion(const MlgSkeleton *skeleton,
                                   const char *motion_path,
                                   const char *const *flipped,
                                   size_t flipped_count,
                                   double unit_in_metres,
                                   const char *path,
                                   MlgError *error);

/**
 * `mlg_skeleton_save_osim_mass` with the template's density.
 */
MlgStatus mlg_skeleton_save_osim(const MlgSkeleton *skeleton,
                                 const char *model_path,
                                 const char *path,
                                 char *buffer,
                                 size_t capacity,
                                 size_t *out_length,
                                 MlgError *error);

/**
 * Writes a person's skeleton into the OpenSim model that its template was converted from: `.osim`, the
 * bones in a folder of its name in `Geometry/` beside it. Joints, default angles, masses, inertias, muscles,
 * wrapping surfaces and markers follow the bones.
 *
 * `model_path`: that model. `kilograms`: mass of the person; 0: the bodies keep the template's density.
 * `path`: UTF-8. What was not carried over is written to `buffer`, one sentence per line: UTF-8,
 * zero-terminated, cut to `capacity` bytes. `buffer` may be NULL if `capacity` is 0. `out_length`: bytes of
 * the whole text without the zero; may be NULL.
 */
MlgStatus mlg_skeleton_save_osim_mass(const MlgSkeleton *skeleton,
                                      const char *model_path,
                                      double kilograms,
                                      const char *path,
                                      char *buffer,
                                      size_t capacity,
                                      size_t *out_length,
                                      MlgError *error);

/* ================================================================================================
 * Motions of skeletons: angles of their joints over time.
 * ================================================================================================ */

/**
 * Makes a motion from arrays, which are copied.
 *
 * `names`: `angle_count` names of angles, UTF-8, as `mlg_skeleton_angle_name` tells them. `times`:
 * `frame_count` seconds, rising. `angles`: `frame_count * angle_count` radians, one frame after the
 * other. None may be NULL unless its count is 0. Free with `mlg_motion_free`.
 */
MlgStatus mlg_motion_new(const MlgSkeleton *skeleton,
                         const char *const *names,
                         size_t angle_count,
                         const double *times,
                         const double *angles,
                         size_t frame_count,
                         MlgMotion **out_motion,
                         MlgError *error);

/**
 * Reads a motion: OpenSim's `.mot` or `.sto`, or `.bvh` whose nodes are named as the bones.
 *
 * `flipped`: `flipped_count` names of angles whose sign is the opposite of the skeleton's; may be NULL
 * if that is 0. `path`: UTF-8. Free with `mlg_motion_free`.
 */
MlgStatus mlg_motion_load(const MlgSkeleton *skeleton,
                          const char *path,
                          const char *const *flipped,
                          size_t flipped_count,
                          MlgMotion **out_motion,
                          MlgError *error);

/**
 * Writes a motion: `.mot` for OpenSim, `.bvh` with the bones as a tree, or `.glb`: a scene of the
 * skeleton that moves. `path`: UTF-8.
 */
MlgStatus mlg_motion_save(const MlgMotion *motion, const char *path, MlgError *error);

/**
 * The times of the frames: `*out_count` seconds, borrowed until the motion is freed. NULL without
 * frames or for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_motion_times(const MlgMotion *motion, size_t *out_count);

/**
 * The angles, one frame after the other, in the order of their names: `*out_count` numbers in all,
 * radians (columns whose names end in `_tx`, `_ty` or `_tz`: lengths as in the file), borrowed until
 * the motion is freed. NULL without any or for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_motion_angles(const MlgMotion *motion,
                                size_t *out_count);

/**
 * The name of an angle: UTF-8, borrowed until the motion is freed. NULL if there is no angle of that
 * number, from 0, or the handle is not valid.
 */
const char *mlg_motion_angle_name(const MlgMotion *motion,
                                  size_t angle);

/**
 * What of the motion the skeleton does not know, in a sentence: UTF-8, borrowed until the motion is
 * freed; empty if it knows all. NULL for a handle that is not valid.
 */
const char *mlg_motion_notes(const MlgMotion *motion);

/**
 * Frees a motion. NULL and handles freed already are allowed.
 */
void mlg_motion_free(MlgMotion *motion);

/* ================================================================================================
 * Shape statistics of a skeleton's bones.
 * ================================================================================================ */

/**
 * Learns the shapes of all bones together, pose removed. Takes seconds for large skeletons.
 *
 * `samples`: `sample_count` skeletons, two or more, such as results of registrations of the
 * template: with its bones and vertices, in any pose. Free with `mlg_shape_model_free`.
 */
MlgStatus mlg_shape_model_fit(const MlgSkeleton *template_skeleton,
                              const MlgSkeleton *const *samples,
                              size_t sample_count,
                              MlgShapeModel **out_model,
                              MlgError *error);

/**
 * Tells how well models fit new persons: for each sample, the root mean square distance from what a
 * model of the others makes of it, in the template's unit. `samples`: as for `mlg_shape_model_fit`,
 * three or more. `out_distances`: room for `sample_count` numbers.
 */
MlgStatus mlg_shape_model_left_out(const MlgSkeleton *template_skeleton,
                                   const MlgSkeleton *const *samples,
                                   size_t sample_count,
                                   double *out_distances,
                                   MlgError *error);

/**
 * Reads a model of a template's bones from a `.h5.json` file, as `mlg_shape_model_save` and scalismo
 * write it. `path`: UTF-8. Free with `mlg_shape_model_free`.
 */
MlgStatus mlg_shape_model_load(const MlgSkeleton *template_skeleton,
                               const char *path,
                               MlgShapeModel **out_model,
                               MlgError *error);

/**
 * Writes a model as `.h5.json`; numbers have single precision there. `path`: UTF-8.
 */
MlgStatus mlg_shape_model_save(const MlgShapeModel *model,
                               const char *path,
                               MlgError *error);

/**
 * How far the surface moves at one standard deviation of each mode, root mean square, in the
 * template's unit: `*out_count` numbers, falling, borrowed until the model is freed. NULL without
 * modes or for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_shape_model_deviations(const MlgShapeModel *model, size_t *out_count);

/**
 * The share of the variance in the first modes: `*out_count` numbers, rising to 1, as
 * `mlg_shape_model_deviations`.
 */
const double *mlg_shape_model_explained(const MlgShapeModel *model, size_t *out_count);

/**
 * Makes a shape: a skeleton in the template's pose, its joints closed.
 *
 * `coefficients`: `count` numbers in standard deviations, of the first modes; the others are 0. May
 * be NULL if `count` is 0: the mean. Free with `mlg_skeleton_free`.
 */
MlgStatus mlg_shape_model_shape(const MlgShapeModel *model,
                                const double *coefficients,
                                size_t count,
                                MlgSkeleton **out_skeleton,
                                MlgError *error);

/**
 * Frees a model. NULL and handles freed already are allowed. Objects made from it stay valid.
 */
void mlg_shape_model_free(MlgShapeModel *model);

/* ================================================================================================
 * Registration of a skeleton: the problem, its options, the run.
 * ================================================================================================ */

/**
 * What the limits of joints are to a registration.
 */
typedef enum MlgLimits {
  /**
   * Walls.
   */
  MLG_LIMITS_HARD = 0,
  /**
   * Where the data insist, a joint turns up to 10 degrees further. The default.
   */
  MLG_LIMITS_SOFT = 1,
  /**
   * Joints turn freely; the bones still hang together.
   */
  MLG_LIMITS_NONE = 2,
} MlgLimits;

/**
 * How to register. Set with `mlg_registration_options_init`. Lengths are in the template's unit.
 */
typedef struct MlgRegistrationOptions {
  /**
   * `sizeof` this struct in the caller's header.
   */
  size_t struct_size;
  /**
   * 1 (default): many orientations of the template are tried. 0: it already lies where the person
   * is.
   */
  uint32_t align;
  /**
   * 1: the loop as published, for comparison. 0 (default): the improved one.
   */
  uint32_t paper;
  /**
   * Iterations per level at most; 0 (default): 30.
   */
  uint32_t max_iterations;
  /**
   * Threads to use; 0 (default): all. The result does not depend on it.
   */
  uint32_t thread_count;
  /**
   * Cluster radii from coarse to fine, INFINITY for one cluster; NULL (default): as the skeleton's
   * file says, else chosen from its size. Read during the call only.
   */
  const double *radii;
  /**
   * Number of radii.
   */
  size_t radius_count;
  /**
   * 1: the target is meant as it is, even if it looks like a mirror image or another unit. 0
   * (default): such a target is refused.
   */
  uint32_t as_is;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * What the joints' limits are to the search: a number of `MlgLimits`. A joint whose file has a rule
   * of its own keeps it.
   */
  uint32_t limits;
  /**
   * 0.
   */
  uint32_t reserved_too;
} MlgRegistrationOptions;

/**
 * Writes the defaults. `struct_size`: `sizeof *out_options`.
 */
MlgStatus mlg_registration_options_init(MlgRegistrationOptions *out_options,
                                        size_t struct_size);

/**
 * Makes a registration of a template, without a target yet. Free with `mlg_registration_free`.
 */
MlgStatus mlg_registration_new(const MlgSkeleton *template_skeleton,
                               MlgRegistration **out_problem,
                               MlgError *error);

/**
 * Sets one surface of all the person's bones, which may be fused; replaces earlier targets. Its
 * normals point outwards.
 */
MlgStatus mlg_registration_set_target(MlgRegistration *problem,
                                      const MlgTriMesh *surface,
                                      MlgError *error);

/**
 * Sets the person's surface of one bone, a number from 0; a target for all bones is dropped. Bones
 * without a surface follow their joints.
 */
MlgStatus mlg_registration_set_bone_target(MlgRegistration *problem,
                                           size_t bone,
                                           const MlgTriMesh *surface,
                                           MlgError *error);

/**
 * Sets an image of the person in place of surfaces. `reference`: an image of the same protocol in which
 * the template lies on the bones. In `person` it must lie near them: a tenth of its diagonal is
 * searched, and again from where that ends, whatever `align` says. Millimetres, RAS.
 */
MlgStatus mlg_registration_set_image(MlgRegistration *problem,
                                     const MlgVolume *person,
                                     const MlgVolume *reference,
                                     MlgError *error);

/**
 * Holds the bones to shapes that statistics know, in place of scaling each by itself. `model`: of this
 * template, or NULL: the one that the template's file names, if any.
 */
MlgStatus mlg_registration_set_shape_model(MlgRegistration *problem,
                                           const MlgShapeModel *model,
                                           MlgError *error);

/**
 * Starts a registration on a thread of its own and returns at once. The problem is copied: it may be
 * changed or freed while the run goes on. `options`: NULL for the defaults. Free the run with
 * `mlg_run_free`.
 */
MlgStatus mlg_registration_start(const MlgRegistration *problem,
                                 const MlgRegistrationOptions *options,
                                 MlgRun **out_run,
                                 MlgError *error);

/**
 * Waits for the end of a registration and hands its result over, once. A cancelled run gives what it
 * has, marked by `cancelled` in its summary. Free the result with `mlg_registration_result_free`,
 * and the run with `mlg_run_free`.
 */
MlgStatus mlg_run_wait_registration(MlgRun *run,
                                    MlgRegistrationResult **out_result,
                                    MlgError *error);

/**
 * Registers and returns when it is done: `mlg_registration_start` and `mlg_run_wait_registration` in
 * one. Free the result with `mlg_registration_result_free`.
 */
MlgStatus mlg_registration_run(const MlgRegistration *problem,
                               const MlgRegistrationOptions *options,
                               MlgRegistrationResult **out_result,
                               MlgError *error);

/**
 * Frees a registration. NULL and handles freed already are allowed. Runs started from it go on.
 */
void mlg_registration_free(MlgRegistration *problem);

/* ================================================================================================
 * What a registration gave.
 * ================================================================================================ */

/**
 * How far a result, or one bone of it, can be trusted.
 */
typedef enum MlgVerdict {
  /**
   * Nothing speaks against it.
   */
  MLG_VERDICT_GOOD = 0,
  /**
   * It may be wrong: look at it.
   */
  MLG_VERDICT_DOUBTFUL = 1,
  /**
   * It is wrong.
   */
  MLG_VERDICT_FAILED = 2,
} MlgVerdict;

/**
 * The course of a registration. Lengths are in the template's unit.
 */
typedef struct MlgRegistrationSummary {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * 1 if it was stopped on request before its end.
   */
  uint32_t cancelled;
  /**
   * Closest-point iterations.
   */
  uint32_t iterations;
  /**
   * Bones whose verdict is not good.
   */
  uint32_t suspicious_bones;
  /**
   * Joints outside their limits.
   */
  uint32_t joints_outside;
  /**
   * Mean of the bones' mean residuals.
   */
  double mean_residual;
  /**
   * Largest residual of any bone.
   */
  double max_residual;
  /**
   * Seconds it took.
   */
  double seconds;
  /**
   * How far the whole can be trusted: a number of `MlgVerdict`.
   */
  uint32_t verdict;
  /**
   * Bones whose verdict is `FAILED`.
   */
  uint32_t failed_bones;
} MlgRegistrationSummary;

/**
 * How a bone fits. Lengths are in the template's unit.
 */
typedef struct MlgBoneFit {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Mean distance to the target, both ways.
   */
  double mean_residual;
  /**
   * Largest such distance.
   */
  double max_residual;
  /**
   * Share of the bone's area that lies on the target, 0 to 1.
   */
  double seen;
  /**
   * 1 if its verdict is not good.
   */
  uint32_t suspicious;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * How far it can be trusted: a number of `MlgVerdict`.
   */
  uint32_t verdict;
  /**
   * Why it is not good: sentences of `mlg_registration_result_bone_reasons`.
   */
  uint32_t reason_count;
} MlgBoneFit;

/**
 * How a joint stands. Lengths are in the template's unit, angles in radians.
 */
typedef struct MlgJointPose {
  /**
   * `sizeof` this struct in the caller's header; set by the caller.
   */
  size_t struct_size;
  /**
   * Its centre.
   */
  double centre[3];
  /**
   * Rotation vector of the child's frame seen from the parent's.
   */
  double rotation[3];
  /**
   * Share of the allowed rotation that is used; 1: on the limit.
   */
  double usage;
  /**
   * Rotation beyond the limit.
   */
  double excess_rotation;
  /**
   * Distance of the two frames' origins.
   */
  double shift;
  /**
   * Shift beyond the limit.
   */
  double excess_shift;
  /**
   * Distance at which the data alone would leave the two bones' points of the joint.
   */
  double seam;
} MlgJointPose;

/**
 * The name of an `MlgVerdict`, e.g. "DOUBTFUL"; "UNKNOWN" for other numbers. Static, never NULL.
 */
const char *mlg_verdict_name(uint32_t verdict);

/**
 * The person's skeleton: bones in the template's vertex order, joint frames inside their limits or as
 * far beyond as these give way (`MlgLimits`). It is an object of its own and may be the template of
 * another registration. Free with `mlg_skeleton_free`.
 */
MlgStatus mlg_registration_result_skeleton(const MlgRegistrationResult *result,
                                           MlgSkeleton **out_skeleton,
                                           MlgError *error);

/**
 * Tells how it went. `out_summary`: its `struct_size` must be set.
 */
MlgStatus mlg_registration_result_summary(const MlgRegistrationResult *result,
                                          MlgRegistrationSummary *out_summary,
                                          MlgError *error);

/**
 * Tells how a bone, a number from 0, fits. `out_fit`: its `struct_size` must be set.
 */
MlgStatus mlg_registration_result_bone_fit(const MlgRegistrationResult *result,
                                           size_t bone,
                                           MlgBoneFit *out_fit,
                                           MlgError *error);

/**
 * Tells how a joint, a number from 0, stands to its limits. `out_pose`: its `struct_size` must be
 * set.
 */
MlgStatus mlg_registration_result_joint_pose(const MlgRegistrationResult *result,
                                             size_t joint,
                                             MlgJointPose *out_pose,
                                             MlgError *error);

/**
 * The coefficients of the shape model, in standard deviations: `*out_count` numbers, borrowed until the
 * result is freed. NULL without a model or for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_registration_result_coefficients(const MlgRegistrationResult *result,
                                                   size_t *out_count);

/**
 * For each vertex of the skeleton, bone after bone, whether it lies on the target, 1 or 0; in an image, how
 * far it finds something like it, 0 to 1: `*out_count` numbers, borrowed until the result is freed. What is
 * not seen is a guess. NULL for a handle that is not valid. `out_count`: may be NULL.
 */
const double *mlg_registration_result_seen(const MlgRegistrationResult *result,
                                           size_t *out_count);

/**
 * Carries a soft tissue surface along with the bones; takes seconds for large ones.
 *
 * `tissue`: in the template's pose. `out_points`: room for 3 coordinates per point of it.
 */
MlgStatus mlg_registration_result_carry(const MlgRegistrationResult *result,
                                        const MlgTriMesh *tissue,
                                        double *out_points,
                                        MlgError *error);

/**
 * Writes why the verdict on a bone, a number from 0, is not good and what can be done about it, one
 * sentence per line, worst first, into `buffer`: UTF-8, zero-terminated, cut to `capacity` bytes; empty
 * for a good bone. `buffer` may be NULL if `capacity` is 0. `out_length`: bytes of the whole text
 * without the zero; may be NULL.
 */
MlgStatus mlg_registration_result_bone_reasons(const MlgRegistrationResult *result,
                                               size_t bone,
                                               char *buffer,
                                               size_t capacity,
                                               size_t *out_length,
                                               MlgError *error);

/**
 * Writes what to look at, first why the verdict on the whole is not good, then the worst bones and
 * joints, one sentence per line, into `buffer`: UTF-8, zero-terminated, cut to
 * `capacity` bytes; empty if there is nothing. `buffer` may be NULL if `capacity` is 0.
 * `out_length`: bytes of the whole text without the zero; may be NULL.
 */
MlgStatus mlg_registration_result_warnings(const MlgRegistrationResult *result,
                                           char *buffer,
                                           size_t capacity,
                                           size_t *out_length,
                                           MlgError *error);

/**
 * Frees a result. NULL and handles freed already are allowed. Objects made from it stay valid.
 */
void mlg_registration_result_free(MlgRegistrationResult *result);

#ifdef __cplusplus
}
#endif

#endif  /* MOULAGE_H */
