"""What include/moulage.h declares, for ctypes: constants, structs, functions. tests/python compares the two."""

import ctypes
from ctypes import POINTER, Structure, c_char, c_char_p, c_double, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p

from . import whole_numbers

ABI_VERSION = 1

TETS = {"auto": 0, "tetgen": 1, "lattice": 2, "given": 3}
STOPS = ("settled", "tolerance_met", "no_step", "iteration_limit", "cancelled")
ENDINGS = ("parted", "stalled", "cancelled")
ALIGN = {"rigid": 0, "similarity": 1}
NO_VERTEX = 0xFFFFFFFF
RUN_ENDED = 1
CANCELLED = 1


class MlgError(Structure):
    _fields_ = [("status", c_uint32), ("message", c_char * 512)]


class Versioned(Structure):
    """A struct whose first field is its size."""

    def __init__(self):
        super().__init__()
        self.struct_size = ctypes.sizeof(self)

    def __setattr__(self, name, value):
        kind = dict(self._fields_).get(name)
        super().__setattr__(name, whole_numbers.whole(kind, value, name) if kind in whole_numbers.KINDS else value)

    def fields(self):
        """The values by name, without the size."""
        return {name: getattr(self, name) for name, _ in self._fields_[1:]}


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


class MlgClicks(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("every", c_double),
        ("spacing", c_double),
        ("jitter", c_double),
        ("seed", c_uint64),
    ]


class MlgBone(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("name", c_char_p),
        ("surface", c_void_p),
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


class MlgRegistrationOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("align", c_uint32),
        ("paper", c_uint32),
        ("max_iterations", c_uint32),
        ("thread_count", c_uint32),
        ("radii", c_void_p),
        ("radius_count", c_size_t),
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
    ]


class MlgBoneFit(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("mean_residual", c_double),
        ("max_residual", c_double),
        ("seen", c_double),
        ("suspicious", c_uint32),
        ("reserved", c_uint32),
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


# Handles and arrays travel as plain addresses: `pointer` and `array` below make them.
_HANDLE, _ARRAY, _OUT, _ERROR = c_void_p, c_void_p, POINTER(c_void_p), POINTER(MlgError)
_COUNT, _OUT_COUNT, _PATH = c_size_t, POINTER(c_size_t), c_char_p
_PAIRS = (_HANDLE, _ARRAY, _ARRAY, _ARRAY, _COUNT, _ERROR)
_GETTER = (_HANDLE, _OUT_COUNT)

# Functions that return a status; the last argument is the error.
CALLS = {
    "tri_mesh_new": (_ARRAY, _COUNT, _ARRAY, _COUNT, _OUT, _ERROR),
    "tri_mesh_load": (_PATH, _OUT, _ERROR),
    "tri_mesh_save": (_HANDLE, _ARRAY, _COUNT, _PATH, _ERROR),
    "tri_mesh_check": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "tri_mesh_align": (
        _HANDLE, c_uint32, _ARRAY, _COUNT, _ARRAY, _ARRAY, _COUNT, _ARRAY, _ERROR,
    ),
    "tri_mesh_section": (_HANDLE, _ARRAY, _COUNT, _ARRAY, _ARRAY, _OUT, _ERROR),
    "tet_mesh_new": (_ARRAY, _COUNT, _ARRAY, _COUNT, _OUT, _ERROR),
    "tet_mesh_load": (_PATH, _OUT, _ERROR),
    "tet_mesh_save": (_HANDLE, _PATH, _ERROR),
    "markers_new": (_ARRAY, _ARRAY, POINTER(c_char_p), _COUNT, _OUT, _ERROR),
    "markers_save": (_HANDLE, _PATH, _ERROR),
    "markers_load": (_PATH, _OUT, _ERROR),
    "tetrahedralization_run": (_HANDLE, POINTER(MlgTetrahedralizationOptions), _OUT, _ERROR),
    "tetrahedralization_start": (_HANDLE, POINTER(MlgTetrahedralizationOptions), _OUT, _ERROR),
    "tetrahedralization_from_tets": (_HANDLE, _HANDLE, _OUT, _ERROR),
    "tetrahedralization_quality": (_HANDLE, POINTER(MlgTetQuality), _ERROR),
    "pairs_load_landmarks": (_HANDLE, _PATH, _PATH, _OUT, _ERROR),
    "pairs_load_attachments": (_HANDLE, _PATH, c_uint32, _OUT, _ERROR),
    "pairs_from_bone": (_HANDLE, _HANDLE, _HANDLE, c_double, _OUT, _ERROR),
    "reshaping_new": (_HANDLE, _OUT, _ERROR),
    "reshaping_set_markers": (_HANDLE, _ARRAY, _ARRAY, _COUNT, _ERROR),
    "reshaping_set_landmarks": _PAIRS,
    "reshaping_set_landmarks_at_vertices": _PAIRS,
    "reshaping_set_attachments": _PAIRS,
    "reshaping_set_attachments_at_vertices": _PAIRS,
    "reshaping_set_fixed": (_HANDLE, _ARRAY, _COUNT, _ERROR),
    "reshaping_check": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "reshaping_start": (_HANDLE, POINTER(MlgReshapingOptions), _OUT, _ERROR),
    "reshaping_start_again": (_HANDLE, _HANDLE, POINTER(MlgReshapingOptions), _OUT, _ERROR),
    "run_poll": (_HANDLE, POINTER(MlgProgress), _ERROR),
    "run_preview_points": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "run_wait_tetrahedralization": (_HANDLE, _OUT, _ERROR),
    "run_wait_reshaping": (_HANDLE, _OUT, _ERROR),
    "separation_new": (_OUT, _ERROR),
    "separation_add_body": (_HANDLE, _PATH, _HANDLE, _HANDLE, _ERROR),
    "separation_add_result": (_HANDLE, _PATH, _HANDLE, _ERROR),
    "separation_add_obstacle": (_HANDLE, _PATH, _HANDLE, _ERROR),
    "separation_set_markers": (_HANDLE, _COUNT, _ARRAY, _COUNT, _ERROR),
    "separation_start": (_HANDLE, POINTER(MlgSeparationOptions), _OUT, _ERROR),
    "run_wait_separation": (_HANDLE, _OUT, _ERROR),
    "separation_result_summary": (_HANDLE, POINTER(MlgSeparationSummary), _ERROR),
    "separation_result_overlap": (_HANDLE, _COUNT, POINTER(MlgOverlap), _ERROR),
    "separation_result_body": (_HANDLE, _COUNT, POINTER(MlgSeparatedBody), _ERROR),
    "volume_load": (_PATH, _OUT, _ERROR),
    "volume_info": (_HANDLE, POINTER(MlgVolumeInfo), _ERROR),
    "volume_notes": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "volume_plane": (_HANDLE, _ARRAY, c_double, c_double, POINTER(MlgSlicePlane), _ERROR),
    "volume_slice": (_HANDLE, POINTER(MlgSlicePlane), _ARRAY, c_uint32, _ARRAY, _COUNT, _ERROR),
    "volume_labels": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "volume_label_markers": (_HANDLE, c_uint32, _ARRAY, _COUNT, POINTER(MlgClicks), _OUT, _ERROR),
    "volume_label_surface": (_HANDLE, c_uint32, _OUT, _ERROR),
    "skeleton_new": (POINTER(MlgBone), _COUNT, POINTER(MlgJoint), _COUNT, _OUT, _ERROR),
    "skeleton_load": (_PATH, _OUT, _ERROR),
    "skeleton_save": (_HANDLE, _PATH, _ERROR),
    "skeleton_save_motion": (_HANDLE, _PATH, POINTER(c_char_p), _COUNT, c_double, _PATH, _ERROR),
    "skeleton_save_osim": (_HANDLE, _PATH, _PATH, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "motion_new": (_HANDLE, POINTER(c_char_p), _COUNT, _ARRAY, _ARRAY, _COUNT, _OUT, _ERROR),
    "motion_load": (_HANDLE, _PATH, POINTER(c_char_p), _COUNT, _OUT, _ERROR),
    "motion_save": (_HANDLE, _PATH, _ERROR),
    "skeleton_joint": (_HANDLE, _COUNT, POINTER(MlgJoint), _ERROR),
    "shape_model_fit": (_HANDLE, _ARRAY, _COUNT, _OUT, _ERROR),
    "shape_model_left_out": (_HANDLE, _ARRAY, _COUNT, _ARRAY, _ERROR),
    "shape_model_load": (_HANDLE, _PATH, _OUT, _ERROR),
    "shape_model_save": (_HANDLE, _PATH, _ERROR),
    "shape_model_shape": (_HANDLE, _ARRAY, _COUNT, _OUT, _ERROR),
    "registration_new": (_HANDLE, _OUT, _ERROR),
    "registration_set_target": (_HANDLE, _HANDLE, _ERROR),
    "registration_set_bone_target": (_HANDLE, _COUNT, _HANDLE, _ERROR),
    "registration_set_image": (_HANDLE, _HANDLE, _HANDLE, _ERROR),
    "registration_set_shape_model": (_HANDLE, _HANDLE, _ERROR),
    "registration_start": (_HANDLE, POINTER(MlgRegistrationOptions), _OUT, _ERROR),
    "run_wait_registration": (_HANDLE, _OUT, _ERROR),
    "registration_result_skeleton": (_HANDLE, _OUT, _ERROR),
    "registration_result_summary": (_HANDLE, POINTER(MlgRegistrationSummary), _ERROR),
    "registration_result_bone_fit": (_HANDLE, _COUNT, POINTER(MlgBoneFit), _ERROR),
    "registration_result_joint_pose": (_HANDLE, _COUNT, POINTER(MlgJointPose), _ERROR),
    "registration_result_carry": (_HANDLE, _HANDLE, _ARRAY, _ERROR),
    "registration_result_warnings": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "reshaping_result_carry": (_HANDLE, _ARRAY, _COUNT, _ARRAY, _ERROR),
    "reshaping_result_summary": (_HANDLE, POINTER(MlgReshapingSummary), _ERROR),
    "reshaping_result_quality": (_HANDLE, POINTER(MlgTetQuality), _ERROR),
}
# Functions that return a value: its type, then the arguments.
GETTERS = {
    "abi_version": (c_uint32,),
    "version_string": (c_char_p,),
    "tetrahedralization_options_init": (
        c_uint32, POINTER(MlgTetrahedralizationOptions), c_size_t,
    ),
    "reshaping_options_init": (c_uint32, POINTER(MlgReshapingOptions), c_size_t),
    "separation_options_init": (c_uint32, POINTER(MlgSeparationOptions), c_size_t),
    "separation_result_points": (POINTER(c_double), _HANDLE, c_size_t, _OUT_COUNT),
    "separation_result_tet_points": (POINTER(c_double), _HANDLE, c_size_t, _OUT_COUNT),
    "clicks_init": (c_uint32, POINTER(MlgClicks), c_size_t),
    "joint_init": (c_uint32, POINTER(MlgJoint), c_size_t),
    "registration_options_init": (c_uint32, POINTER(MlgRegistrationOptions), c_size_t),
    "tri_mesh_points": (POINTER(c_double), *_GETTER),
    "tri_mesh_triangles": (POINTER(c_uint32), *_GETTER),
    "tet_mesh_points": (POINTER(c_double), *_GETTER),
    "tet_mesh_tets": (POINTER(c_uint32), *_GETTER),
    "markers_points": (POINTER(c_double), *_GETTER),
    "markers_weights": (POINTER(c_double), *_GETTER),
    "markers_label": (c_char_p, _HANDLE, c_size_t),
    "pairs_template_points": (POINTER(c_double), *_GETTER),
    "pairs_template_vertices": (POINTER(c_uint32), *_GETTER),
    "pairs_targets": (POINTER(c_double), *_GETTER),
    "pairs_weights": (POINTER(c_double), *_GETTER),
    "pairs_label": (c_char_p, _HANDLE, c_size_t),
    "pairs_warning": (c_char_p, _HANDLE),
    "tetrahedralization_points": (POINTER(c_double), *_GETTER),
    "tetrahedralization_tets": (POINTER(c_uint32), *_GETTER),
    "tetrahedralization_inside_fractions": (POINTER(c_double), *_GETTER),
    "tetrahedralization_method": (c_uint32, _HANDLE),
    "tetrahedralization_boundary_kept": (c_uint32, _HANDLE),
    "tetrahedralization_warning_count": (c_size_t, _HANDLE),
    "tetrahedralization_warning": (c_char_p, _HANDLE, c_size_t),
    "reshaping_result_points": (POINTER(c_double), *_GETTER),
    "reshaping_result_tet_points": (POINTER(c_double), *_GETTER),
    "reshaping_result_plastic_strains": (POINTER(c_double), *_GETTER),
    "reshaping_result_marker_distances": (POINTER(c_double), *_GETTER),
    "reshaping_result_max_stretches": (POINTER(c_double), *_GETTER),
    "reshaping_result_min_stretches": (POINTER(c_double), *_GETTER),
    "polylines_points": (POINTER(c_double), *_GETTER),
    "polylines_starts": (POINTER(c_size_t), *_GETTER),
    "polylines_closed": (POINTER(c_uint8), *_GETTER),
    "skeleton_bone_count": (c_size_t, _HANDLE),
    "skeleton_joint_count": (c_size_t, _HANDLE),
    "skeleton_bone_name": (c_char_p, _HANDLE, c_size_t),
    "skeleton_bone_points": (POINTER(c_double), _HANDLE, c_size_t, _OUT_COUNT),
    "skeleton_bone_triangles": (POINTER(c_uint32), _HANDLE, c_size_t, _OUT_COUNT),
    "skeleton_points": (POINTER(c_double), *_GETTER),
    "skeleton_angles": (POINTER(c_double), *_GETTER),
    "skeleton_angle_name": (c_char_p, _HANDLE, c_size_t),
    "skeleton_notes": (c_char_p, _HANDLE),
    "motion_times": (POINTER(c_double), *_GETTER),
    "motion_angles": (POINTER(c_double), *_GETTER),
    "motion_angle_name": (c_char_p, _HANDLE, c_size_t),
    "motion_notes": (c_char_p, _HANDLE),
    "shape_model_deviations": (POINTER(c_double), *_GETTER),
    "shape_model_explained": (POINTER(c_double), *_GETTER),
    "registration_result_coefficients": (POINTER(c_double), *_GETTER),
    "run_cancel": (None, _HANDLE),
    **{
        f"{kind}_free": (None, _HANDLE)
        for kind in ("tri_mesh", "tet_mesh", "markers", "pairs", "tetrahedralization", "reshaping",
                     "run", "reshaping_result", "volume", "polylines", "skeleton", "registration",
                     "registration_result", "separation", "separation_result",
                     "shape_model", "motion")
    },
}
