"""What include/moulage.h declares, for ctypes: constants, structs, functions. Made by python/make_interface.py; do not
edit. Handles and arrays travel as plain addresses; `native` makes them."""

from ctypes import (
    POINTER, Structure, c_char, c_char_p, c_double, c_float, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p,
)
from typing import Any

from .versioned import Versioned

ABI_VERSION = 1
VERSION_MAJOR = 0
VERSION_MINOR = 1
VERSION_PATCH = 0
ERROR_MESSAGE_SIZE = 512
RUN_RUNNING = 0
RUN_ENDED = 1
STAGE_SIZE = 64
TETS_AUTO = 0
TETS_TETGEN = 1
TETS_LATTICE = 2
TETS_GIVEN = 3
NO_VERTEX = 4294967295
ALIGN_RIGID = 0
ALIGN_SIMILARITY = 1
TETS = {"auto": TETS_AUTO, "tetgen": TETS_TETGEN, "lattice": TETS_LATTICE, "given": TETS_GIVEN}
ALIGN = {"rigid": ALIGN_RIGID, "similarity": ALIGN_SIMILARITY}
STATUS = (
    "ok",
    "cancelled",
    "null_argument",
    "invalid_argument",
    "unsupported",
    "io",
    "parse",
    "singular",
    "diverged",
    "panic",
    "external_program",
)
CONCERN = (
    "amount",
    "surface",
    "unit",
    "frame",
    "up_axis",
    "place",
    "side",
    "exchange",
    "landmarks",
    "attachments",
)
SEVERITY = (
    "note",
    "doubtful",
    "refused",
)
STOP = (
    "settled",
    "tolerance_met",
    "no_step",
    "iteration_limit",
    "cancelled",
)
ENDING = (
    "parted",
    "stalled",
    "cancelled",
)
LIMITS = (
    "hard",
    "soft",
    "none",
)
VERDICT = (
    "good",
    "doubtful",
    "failed",
)


class MlgError(Structure):
    _fields_ = [
        ("status", c_uint32),
        ("message", c_char * 512),
    ]


class MlgProgress(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("state", c_uint32),
        ("iteration", c_uint32),
        ("fraction", c_double),
        ("energy", c_double),
        ("mean_error", c_double),
        ("max_error", c_double),
        ("seconds", c_double),
        ("stage", c_char * 64),
    ]


class MlgTetrahedralizationOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("method", c_uint32),
        ("tet_count", c_uint32),
        ("tetgen_path", c_char_p),
    ]


class MlgTetQuality(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("tet_count", c_uint32),
        ("inverted_count", c_uint32),
        ("volume", c_double),
        ("min_dihedral", c_double),
        ("max_dihedral", c_double),
        ("min_radius_ratio", c_double),
        ("mean_radius_ratio", c_double),
        ("dihedral_histogram", c_uint32 * 18),
    ]


class MlgReshapingOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("tolerance", c_double),
        ("landmark_tolerance", c_double),
        ("attachment_tolerance", c_double),
        ("smoothness", c_double),
        ("screening", c_double),
        ("poisson", c_double),
        ("hard_attachments", c_uint32),
        ("max_iterations", c_uint32),
        ("thread_count", c_uint32),
        ("paper", c_uint32),
        ("reverse_term", c_uint32),
        ("reserved", c_uint32),
        ("max_remeshes", c_uint32),
        ("reserved_too", c_uint32),
    ]


class MlgFinding(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("concern", c_uint32),
        ("severity", c_uint32),
        ("distance", c_double),
        ("mended_distance", c_double),
        ("has_motion", c_uint32),
        ("has_exchange", c_uint32),
        ("first", c_uint32),
        ("second", c_uint32),
        ("motion", c_double * 16),
    ]


class MlgReshapingSummary(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("stop", c_uint32),
        ("iterations", c_uint32),
        ("newton_steps", c_uint32),
        ("inverted_tets", c_uint32),
        ("mean_marker_distance", c_double),
        ("max_marker_distance", c_double),
        ("seconds", c_double),
        ("remeshes", c_uint32),
        ("reserved", c_uint32),
    ]


class MlgUncertaintySummary(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("shapes", c_size_t),
        ("volume", c_double),
        ("volume_sd", c_double),
        ("area", c_double),
        ("area_sd", c_double),
    ]


class MlgSeparationOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("gap", c_double),
        ("rings", c_uint32),
        ("thread_count", c_uint32),
    ]


class MlgSeparationSummary(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("ending", c_uint32),
        ("separated", c_uint32),
        ("rounds", c_uint32),
        ("overlap_count", c_uint32),
        ("seconds", c_double),
    ]


class MlgOverlap(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("first", c_uint32),
        ("second", c_uint32),
        ("depth", c_double * 2),
        ("vertices_inside", c_uint32 * 2),
        ("crossings", c_uint32 * 2),
    ]


class MlgSeparatedBody(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("moved_vertices", c_uint32),
        ("inverted_tets", c_uint32),
        ("largest_move", c_double),
        ("mean_marker_distance", c_double * 2),
        ("max_marker_distance", c_double * 2),
        ("markers_inside_obstacles", c_uint32),
        ("reserved", c_uint32),
    ]


class MlgVolumeInfo(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("size", c_size_t * 3),
        ("world_from_voxel", c_double * 12),
        ("spacing", c_double * 3),
        ("range", c_double * 2),
        ("window", c_double * 2),
        ("box_low", c_double * 3),
        ("box_high", c_double * 3),
    ]


class MlgSlicePlane(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("corner", c_double * 3),
        ("right", c_double * 3),
        ("down", c_double * 3),
        ("width", c_size_t),
        ("height", c_size_t),
    ]


class MlgVolumeGrid(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("size", c_size_t * 3),
        ("spacing", c_double * 3),
        ("origin", c_double * 3),
        ("directions", c_double * 9),
        ("lps", c_uint32),
        ("reserved", c_uint32),
    ]


class MlgClicks(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("every", c_double),
        ("spacing", c_double),
        ("jitter", c_double),
        ("seed", c_uint64),
    ]


class MlgJoint(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("name", c_char_p),
        ("parent", c_uint32),
        ("child", c_uint32),
        ("in_tree", c_uint32),
        ("has_frames", c_uint32),
        ("world_from_parent_frame", c_double * 16),
        ("world_from_child_frame", c_double * 16),
        ("negative_limits", c_double * 3),
        ("positive_limits", c_double * 3),
        ("shift_limit", c_double),
    ]


class MlgBone(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("name", c_char_p),
        ("surface", c_void_p),
    ]


class MlgRegistrationOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("align", c_uint32),
        ("paper", c_uint32),
        ("max_iterations", c_uint32),
        ("thread_count", c_uint32),
        ("radii", c_void_p),
        ("radius_count", c_size_t),
        ("as_is", c_uint32),
        ("reserved", c_uint32),
        ("limits", c_uint32),
        ("reserved_too", c_uint32),
    ]


class MlgRegistrationSummary(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("cancelled", c_uint32),
        ("iterations", c_uint32),
        ("suspicious_bones", c_uint32),
        ("joints_outside", c_uint32),
        ("mean_residual", c_double),
        ("max_residual", c_double),
        ("seconds", c_double),
        ("verdict", c_uint32),
        ("failed_bones", c_uint32),
    ]


class MlgBoneFit(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("mean_residual", c_double),
        ("max_residual", c_double),
        ("seen", c_double),
        ("suspicious", c_uint32),
        ("reserved", c_uint32),
        ("verdict", c_uint32),
        ("reason_count", c_uint32),
    ]


class MlgJointPose(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("centre", c_double * 3),
        ("rotation", c_double * 3),
        ("usage", c_double),
        ("excess_rotation", c_double),
        ("shift", c_double),
        ("excess_shift", c_double),
        ("seam", c_double),
    ]


# Functions that return a status; the last argument is the error.
CALLS: dict[str, tuple[Any, ...]] = {
    "tri_mesh_new": (c_void_p, c_size_t, c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "tri_mesh_load": (c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "tri_mesh_save": (c_void_p, c_void_p, c_size_t, c_char_p, POINTER(MlgError)),
    "tri_mesh_check": (c_void_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "tet_mesh_new": (c_void_p, c_size_t, c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "tet_mesh_load": (c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "tet_mesh_save": (c_void_p, c_char_p, POINTER(MlgError)),
    "tri_mesh_distances_to_points": (c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "tri_mesh_distances_of_points": (c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "tri_mesh_closest_points": (c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "tri_mesh_interpolate": (c_void_p, c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "markers_new": (c_void_p, c_void_p, POINTER(c_char_p), c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "markers_load": (c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "markers_save": (c_void_p, c_char_p, POINTER(MlgError)),
    "run_poll": (c_void_p, POINTER(MlgProgress), POINTER(MlgError)),
    "run_wait_for": (c_void_p, c_double, c_void_p, POINTER(MlgError)),
    "run_preview_points": (c_void_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "tetrahedralization_run": (c_void_p, POINTER(MlgTetrahedralizationOptions), POINTER(c_void_p), POINTER(MlgError)),
    "tetrahedralization_start": (c_void_p, POINTER(MlgTetrahedralizationOptions), POINTER(c_void_p), POINTER(MlgError)),
    "run_wait_tetrahedralization": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "tetrahedralization_from_tets": (c_void_p, c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "tetrahedralization_quality": (c_void_p, POINTER(MlgTetQuality), POINTER(MlgError)),
    "reshaping_new": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "reshaping_set_markers": (c_void_p, c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_marker_sigmas": (c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_landmarks": (c_void_p, c_void_p, c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_landmarks_at_vertices": (c_void_p, c_void_p, c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_pins": (c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_attachments": (c_void_p, c_void_p, c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_attachments_at_vertices": (c_void_p, c_void_p, c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "reshaping_set_fixed": (c_void_p, c_void_p, c_size_t, POINTER(MlgError)),
    "pairs_new": (c_void_p, c_void_p, c_void_p, POINTER(c_char_p), c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "pairs_load_landmarks": (c_void_p, c_char_p, c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "pairs_load_attachments": (c_void_p, c_char_p, c_uint32, POINTER(c_void_p), POINTER(MlgError)),
    "pairs_from_bone": (c_void_p, c_void_p, c_void_p, c_double, POINTER(c_void_p), POINTER(MlgError)),
    "pairs_from_vertices": (c_void_p, c_void_p, c_size_t, c_void_p, c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "reshaping_set_landmark_pairs": (c_void_p, c_void_p, POINTER(MlgError)),
    "reshaping_set_attachment_pairs": (c_void_p, c_void_p, POINTER(MlgError)),
    "reshaping_load_fixed": (c_void_p, c_char_p, POINTER(MlgError)),
    "tri_mesh_align": (
        c_void_p, c_uint32, c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError),
    ),
    "points_align": (c_uint32, c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "reshaping_check": (c_void_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "tri_mesh_inspect": (
        c_void_p, c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError),
    ),
    "findings_get": (c_void_p, c_size_t, POINTER(MlgFinding), POINTER(MlgError)),
    "reshaping_start": (c_void_p, POINTER(MlgReshapingOptions), POINTER(c_void_p), POINTER(MlgError)),
    "reshaping_start_again": (c_void_p, c_void_p, POINTER(MlgReshapingOptions), POINTER(c_void_p), POINTER(MlgError)),
    "run_wait_reshaping": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "reshaping_run": (c_void_p, POINTER(MlgReshapingOptions), POINTER(c_void_p), POINTER(MlgError)),
    "reshaping_result_carry": (c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "reshaping_result_save_tets": (c_void_p, c_char_p, POINTER(MlgError)),
    "reshaping_result_summary": (c_void_p, POINTER(MlgReshapingSummary), POINTER(MlgError)),
    "reshaping_result_quality": (c_void_p, POINTER(MlgTetQuality), POINTER(MlgError)),
    "uncertainty_new": (c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "uncertainty_shape": (c_void_p, c_size_t, c_void_p, c_size_t, POINTER(MlgError)),
    "uncertainty_summary": (c_void_p, POINTER(MlgUncertaintySummary), POINTER(MlgError)),
    "separation_new": (POINTER(c_void_p), POINTER(MlgError)),
    "separation_add_body": (c_void_p, c_char_p, c_void_p, c_void_p, POINTER(MlgError)),
    "separation_add_result": (c_void_p, c_char_p, c_void_p, POINTER(MlgError)),
    "separation_add_obstacle": (c_void_p, c_char_p, c_void_p, POINTER(MlgError)),
    "separation_set_markers": (c_void_p, c_size_t, c_void_p, c_size_t, POINTER(MlgError)),
    "separation_start": (c_void_p, POINTER(MlgSeparationOptions), POINTER(c_void_p), POINTER(MlgError)),
    "run_wait_separation": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "separation_run": (c_void_p, POINTER(MlgSeparationOptions), POINTER(c_void_p), POINTER(MlgError)),
    "separation_result_summary": (c_void_p, POINTER(MlgSeparationSummary), POINTER(MlgError)),
    "separation_result_overlap": (c_void_p, c_size_t, POINTER(MlgOverlap), POINTER(MlgError)),
    "separation_result_body": (c_void_p, c_size_t, POINTER(MlgSeparatedBody), POINTER(MlgError)),
    "volume_load": (c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "volume_info": (c_void_p, POINTER(MlgVolumeInfo), POINTER(MlgError)),
    "volume_notes": (c_void_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "volume_plane": (c_void_p, c_void_p, c_double, c_double, POINTER(MlgSlicePlane), POINTER(MlgError)),
    "volume_slice": (c_void_p, POINTER(MlgSlicePlane), c_void_p, c_uint32, c_void_p, c_size_t, POINTER(MlgError)),
    "tri_mesh_section": (c_void_p, c_void_p, c_size_t, c_void_p, c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "volume_new": (c_void_p, POINTER(MlgVolumeGrid), POINTER(c_void_p), POINTER(MlgError)),
    "volume_labels": (c_void_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "volume_label_name": (c_void_p, c_uint32, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "volume_outlines": (c_void_p, c_uint32, POINTER(MlgSlicePlane), POINTER(c_void_p), POINTER(MlgError)),
    "volume_label_markers": (
        c_void_p, c_uint32, c_void_p, c_size_t, POINTER(MlgClicks), POINTER(c_void_p), POINTER(MlgError),
    ),
    "volume_label_surface": (c_void_p, c_uint32, POINTER(c_void_p), POINTER(MlgError)),
    "skeleton_new": (POINTER(MlgBone), c_size_t, POINTER(MlgJoint), c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "skeleton_joint": (c_void_p, c_size_t, POINTER(MlgJoint), POINTER(MlgError)),
    "skeleton_load": (c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "skeleton_save": (c_void_p, c_char_p, POINTER(MlgError)),
    "skeleton_save_motion": (c_void_p, c_char_p, POINTER(c_char_p), c_size_t, c_double, c_char_p, POINTER(MlgError)),
    "skeleton_save_osim": (c_void_p, c_char_p, c_char_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "skeleton_save_osim_mass": (
        c_void_p, c_char_p, c_double, c_char_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError),
    ),
    "motion_new": (
        c_void_p, POINTER(c_char_p), c_size_t, c_void_p, c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError),
    ),
    "motion_load": (c_void_p, c_char_p, POINTER(c_char_p), c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "motion_save": (c_void_p, c_char_p, POINTER(MlgError)),
    "shape_model_fit": (c_void_p, c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "shape_model_left_out": (c_void_p, c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "shape_model_load": (c_void_p, c_char_p, POINTER(c_void_p), POINTER(MlgError)),
    "shape_model_save": (c_void_p, c_char_p, POINTER(MlgError)),
    "shape_model_shape": (c_void_p, c_void_p, c_size_t, POINTER(c_void_p), POINTER(MlgError)),
    "registration_new": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "registration_set_target": (c_void_p, c_void_p, POINTER(MlgError)),
    "registration_set_bone_target": (c_void_p, c_size_t, c_void_p, POINTER(MlgError)),
    "registration_set_image": (c_void_p, c_void_p, c_void_p, POINTER(MlgError)),
    "registration_set_shape_model": (c_void_p, c_void_p, POINTER(MlgError)),
    "registration_start": (c_void_p, POINTER(MlgRegistrationOptions), POINTER(c_void_p), POINTER(MlgError)),
    "run_wait_registration": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "registration_run": (c_void_p, POINTER(MlgRegistrationOptions), POINTER(c_void_p), POINTER(MlgError)),
    "registration_result_skeleton": (c_void_p, POINTER(c_void_p), POINTER(MlgError)),
    "registration_result_summary": (c_void_p, POINTER(MlgRegistrationSummary), POINTER(MlgError)),
    "registration_result_bone_fit": (c_void_p, c_size_t, POINTER(MlgBoneFit), POINTER(MlgError)),
    "registration_result_joint_pose": (c_void_p, c_size_t, POINTER(MlgJointPose), POINTER(MlgError)),
    "registration_result_carry": (c_void_p, c_void_p, c_void_p, POINTER(MlgError)),
    "registration_result_bone_reasons": (c_void_p, c_size_t, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
    "registration_result_warnings": (c_void_p, c_void_p, c_size_t, POINTER(c_size_t), POINTER(MlgError)),
}
# Functions that return a value: its type, then the arguments.
GETTERS: dict[str, tuple[Any, ...]] = {
    "abi_version": (c_uint32,),
    "version_string": (c_char_p,),
    "status_name": (c_char_p, c_uint32),
    "tri_mesh_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "tri_mesh_triangles": (POINTER(c_uint32), c_void_p, POINTER(c_size_t)),
    "tri_mesh_free": (None, c_void_p),
    "tet_mesh_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "tet_mesh_tets": (POINTER(c_uint32), c_void_p, POINTER(c_size_t)),
    "tet_mesh_free": (None, c_void_p),
    "markers_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "markers_sigmas": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "markers_weights": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "markers_label": (c_char_p, c_void_p, c_size_t),
    "markers_free": (None, c_void_p),
    "run_cancel": (None, c_void_p),
    "run_free": (None, c_void_p),
    "tetrahedralization_options_init": (c_uint32, POINTER(MlgTetrahedralizationOptions), c_size_t),
    "tetrahedralization_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "tetrahedralization_tets": (POINTER(c_uint32), c_void_p, POINTER(c_size_t)),
    "tetrahedralization_inside_fractions": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "tetrahedralization_method": (c_uint32, c_void_p),
    "tetrahedralization_boundary_kept": (c_uint32, c_void_p),
    "tetrahedralization_warning_count": (c_size_t, c_void_p),
    "tetrahedralization_warning": (c_char_p, c_void_p, c_size_t),
    "tetrahedralization_free": (None, c_void_p),
    "reshaping_options_init": (c_uint32, POINTER(MlgReshapingOptions), c_size_t),
    "reshaping_free": (None, c_void_p),
    "pairs_template_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "pairs_template_vertices": (POINTER(c_uint32), c_void_p, POINTER(c_size_t)),
    "pairs_targets": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "pairs_weights": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "pairs_within": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "pairs_label": (c_char_p, c_void_p, c_size_t),
    "pairs_warning": (c_char_p, c_void_p),
    "pairs_free": (None, c_void_p),
    "concern_name": (c_char_p, c_uint32),
    "severity_name": (c_char_p, c_uint32),
    "findings_count": (c_size_t, c_void_p),
    "findings_text": (c_char_p, c_void_p, c_size_t),
    "findings_free": (None, c_void_p),
    "stop_name": (c_char_p, c_uint32),
    "reshaping_result_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_tets": (POINTER(c_uint32), c_void_p, POINTER(c_size_t)),
    "reshaping_result_tet_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_plastic_strains": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_max_stretches": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_min_stretches": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_free": (None, c_void_p),
    "reshaping_result_marker_distances": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_landmark_distances": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "reshaping_result_attachment_distances": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "uncertainty_sd_normal": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "uncertainty_sd": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "uncertainty_free": (None, c_void_p),
    "separation_options_init": (c_uint32, POINTER(MlgSeparationOptions), c_size_t),
    "separation_free": (None, c_void_p),
    "ending_name": (c_char_p, c_uint32),
    "separation_result_points": (POINTER(c_double), c_void_p, c_size_t, POINTER(c_size_t)),
    "separation_result_tet_points": (POINTER(c_double), c_void_p, c_size_t, POINTER(c_size_t)),
    "separation_result_free": (None, c_void_p),
    "volume_free": (None, c_void_p),
    "polylines_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "polylines_starts": (POINTER(c_size_t), c_void_p, POINTER(c_size_t)),
    "polylines_closed": (POINTER(c_uint8), c_void_p, POINTER(c_size_t)),
    "polylines_free": (None, c_void_p),
    "volume_grid_init": (c_uint32, POINTER(MlgVolumeGrid), c_size_t),
    "volume_values": (POINTER(c_float), c_void_p, POINTER(c_size_t)),
    "clicks_init": (c_uint32, POINTER(MlgClicks), c_size_t),
    "joint_init": (c_uint32, POINTER(MlgJoint), c_size_t),
    "skeleton_free": (None, c_void_p),
    "skeleton_bone_count": (c_size_t, c_void_p),
    "skeleton_joint_count": (c_size_t, c_void_p),
    "skeleton_bone_name": (c_char_p, c_void_p, c_size_t),
    "skeleton_bone_points": (POINTER(c_double), c_void_p, c_size_t, POINTER(c_size_t)),
    "skeleton_bone_triangles": (POINTER(c_uint32), c_void_p, c_size_t, POINTER(c_size_t)),
    "skeleton_points": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "skeleton_angles": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "skeleton_angle_name": (c_char_p, c_void_p, c_size_t),
    "skeleton_notes": (c_char_p, c_void_p),
    "motion_times": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "motion_angles": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "motion_angle_name": (c_char_p, c_void_p, c_size_t),
    "motion_notes": (c_char_p, c_void_p),
    "motion_free": (None, c_void_p),
    "shape_model_deviations": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "shape_model_explained": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "shape_model_free": (None, c_void_p),
    "registration_options_init": (c_uint32, POINTER(MlgRegistrationOptions), c_size_t),
    "registration_free": (None, c_void_p),
    "verdict_name": (c_char_p, c_uint32),
    "registration_result_coefficients": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "registration_result_seen": (POINTER(c_double), c_void_p, POINTER(c_size_t)),
    "registration_result_free": (None, c_void_p),
}
