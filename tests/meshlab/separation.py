"""Separate Overlapping Layers, beside the command line on the same tets and surfaces."""

import json

import numpy as np
import pymeshlab

from support import OUT, RIGID, add, cli, error_of, save_ply, sphere, vertices_of

CANCELLED = 2
SEPARATE = "apply_coord_separate_layers"
OPTIONS = dict(tets="Lattice", tet_count=1500)
POINTS, FACES = sphere()
PLACES = {"left": [0, 0, 0], "right": [1.7, 0.1, 0.05], "bone_1": [0.8, -1.5, 0]}


def scene(*names):
    """A ball for each name."""
    ms = pymeshlab.MeshSet()
    return ms, {name: add(ms, POINTS + PLACES[name], FACES, name) for name in names}


def as_the_command_line():
    """Two balls that overlap, and both a third one that is fixed; then nothing overlaps."""
    ms, layers = scene(*PLACES)
    for name in ("left", "right"):
        ms.set_current_mesh(layers[name])
        ms.apply_filter("get_tetrahedralization_quality", save=f"{OUT}/{name}.vtu", **OPTIONS)
    files = {name: save_ply(f"{OUT}/{name}.ply", POINTS + place, FACES) for name, place in PLACES.items()}
    cli("separate", f"{OUT}/left.vtu", f"{OUT}/right.vtu", "--surfaces", files["left"], files["right"], "--fixed",
        files["bone_1"], "-o", f"{OUT}/apart")
    with open(f"{OUT}/apart/separation.json") as f:
        wanted = json.load(f)
    figures = ms.apply_filter(SEPARATE, fixed="bone*", **OPTIONS)
    assert figures["separated"] and wanted["separated"], figures
    assert figures["overlaps_before"] == len(wanted["overlaps"]) == 3 and figures["overlaps_after"] == 0, figures
    assert figures["deepest_before"] > 0.2 and figures["deepest_after"] == 0, figures
    for name in ("left", "right"):
        points = ms.mesh(layers[name]).vertex_matrix()
        far = np.abs(points - vertices_of(f"{OUT}/apart/{name}.ply")).max()
        assert far == 0, f"{name}: {far} from the command line's"
    moved = [body["moved"] for body in wanted["bodies"]]
    assert figures["moved_vertices"] == sum(moved) > 0
    assert np.array_equal(ms.mesh(layers["bone_1"]).vertex_matrix(), POINTS + PLACES["bone_1"])

    before = ms.mesh(layers["left"]).vertex_matrix()
    figures = ms.apply_filter(SEPARATE, fixed="bone_1", **OPTIONS)
    assert figures["overlaps_before"] == figures["moved_vertices"] == 0
    assert np.array_equal(ms.mesh(layers["left"]).vertex_matrix(), before)


def each_layer_in_a_frame_of_its_own():
    ms, layers = scene("left")
    back = np.linalg.inv(RIGID)
    layers["right"] = add(ms, (POINTS + PLACES["right"]) @ back[:3, :3].T + back[:3, 3], FACES, "right")
    ms.set_matrix(transformmatrix=RIGID, freeze=False)
    figures = ms.apply_filter(SEPARATE, **OPTIONS)
    assert figures["separated"] and figures["overlaps_before"] == 1, figures
    assert np.array_equal(ms.mesh(layers["right"]).transform_matrix(), RIGID)
    left, right = (ms.mesh(layers[name]).transformed_vertex_matrix() for name in ("left", "right"))
    axis = np.array(PLACES["right"]) / np.linalg.norm(PLACES["right"])
    assert (left @ axis).max() < (right @ axis).min() + 0.1


def mean_move(mesh, name):
    return np.linalg.norm(mesh.vertex_matrix() - POINTS - PLACES[name], axis=1).mean()


def markers_hold_their_surface():
    moves = []
    for markers in ("", "left-left-clicks"):
        ms, layers = scene("left", "right")
        add(ms, POINTS[::2] + PLACES["left"], label="left-clicks")
        figures = ms.apply_filter(SEPARATE, markers=markers, **OPTIONS)
        assert figures["separated"], figures
        moves.append([mean_move(ms.mesh(layers[name]), name) for name in layers])
    (left, right), (left_held, right_held) = moves
    assert left_held < 0.5 * left and right_held > right, moves


def time_runs_out():
    """Three bodies in one place take minutes to part."""
    ms = pymeshlab.MeshSet()
    for number in range(3):
        add(ms, POINTS * (1 + 0.01 * number), FACES, f"body{number}")
    figures = ms.apply_filter(SEPARATE, seconds=1, tets="Lattice", tet_count=500)
    assert figures["ending"] == CANCELLED and not figures["separated"] and figures["warnings"] == 1, figures


def mistakes():
    ms, layers = scene("left", "right")
    error_of(ms, SEPARATE, "do not name a layer that may move", markers="left-nothing")
    error_of(ms, SEPARATE, 'called "femur"', fixed="femur")
    error_of(ms, SEPARATE, "nothing to separate", fixed="left, right")
    error_of(ms, SEPARATE, "ring", rings=0, **OPTIONS)
    error_of(ms, SEPARATE, "rings is -1; it must be 0 or more", rings=-1, **OPTIONS)
    error_of(ms, SEPARATE, "seconds is -1", seconds=-1, **OPTIONS)
    # A hidden layer does not count.
    ms.set_current_mesh(layers["right"])
    ms.set_current_mesh_visibility(False)
    error_of(ms, SEPARATE, "nothing to separate")


def separations():
    as_the_command_line()
    each_layer_in_a_frame_of_its_own()
    markers_hold_their_surface()
    time_runs_out()
    mistakes()
    print("separate: as the command line; fixed and hidden layers; matrices; markers; mistakes")
