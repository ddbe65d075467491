"""The filters in PyMeshLab: filters.py PLUGIN WORK CLI

Geometry is compared with what the command line makes of the same files; what MeshLab keeps beside
positions (texture coordinates, colours, quality, selection) must be equal bit by bit.
"""

import csv
import json
import os

import numpy as np
import pymeshlab
from pymeshlab import PureValue

from separation import separations
from support import OUT, RIGID, add, block, cli, error_of, fails, save_ply, sphere, vertices_of

RESHAPE = "apply_coord_reshape_to_markers"
REGISTER = "apply_coord_register_skeleton"
TETS = "get_tetrahedralization_quality"
DISTANCE = "compute_scalar_by_distance_to_markers_per_vertex"
EXAMPLES = os.path.join(os.path.dirname(__file__), "..", "..", "examples")

SETTLED, TOLERANCE_MET, ITERATION_LIMIT, CANCELLED = 0, 1, 3, 4

POINTS, FACES = sphere()
MARKERS = POINTS[::3] * [1.5, 1, 0.8]


def markers_as_the_command_line():
    template = save_ply(f"{OUT}/template.ply", POINTS, FACES)
    markers = save_ply(f"{OUT}/markers.ply", MARKERS)
    cli("reshape", "--template", template, "--markers", markers, "--tolerance", 0.0078125,
        "--tets", "lattice", "--tet-count", 1500, "-o", f"{OUT}/person.ply")
    wanted = vertices_of(f"{OUT}/person.ply")
    options = dict(tolerance=PureValue(0.0078125), tets="Lattice", tet_count=1500)

    # Texture coordinates, colours, quality and selection beside the positions.
    random = np.random.default_rng(1)
    wedges = random.random((len(FACES) * 3, 2))
    kept = dict(w_tex_coords_matrix=wedges, v_color_matrix=random.random((len(POINTS), 4)),
                v_scalar_array=random.random(len(POINTS)))
    ms = pymeshlab.MeshSet()
    marker_layer = add(ms, MARKERS, label="markers")
    add(ms, POINTS, FACES, "template", **kept)
    ms.compute_selection_by_condition_per_vertex(condselect="x > 0.5")
    mesh = ms.current_mesh()
    before = [mesh.wedge_tex_coord_matrix(), mesh.vertex_color_matrix(), mesh.vertex_scalar_array(),
              mesh.vertex_selection_array(), mesh.face_matrix()]
    figures = ms.apply_filter(RESHAPE, markers=marker_layer, **options)
    mesh = ms.current_mesh()
    after = [mesh.wedge_tex_coord_matrix(), mesh.vertex_color_matrix(), mesh.vertex_scalar_array(),
             mesh.vertex_selection_array(), mesh.face_matrix()]
    for b, a in zip(before, after):
        assert np.array_equal(b, a)
    assert before[3].any() and not before[3].all()
    assert np.array_equal(mesh.vertex_matrix(), wanted), np.abs(mesh.vertex_matrix() - wanted).max()
    assert figures["mean_marker_distance"] < 0.01 and figures["inverted_tets"] == 0
    assert figures["stop"] in (SETTLED, TOLERANCE_MET) and figures["warnings"] == 0, figures

    # Each layer in a frame of its own. No ball: how far that is turned, markers do not say.
    oval = POINTS * [1, 0.8, 0.6]
    oval_markers = MARKERS * [1, 0.8, 0.6]
    cli("reshape", "--template", save_ply(f"{OUT}/oval.ply", oval, FACES), "--markers",
        save_ply(f"{OUT}/oval_markers.ply", oval_markers), "--tolerance", 0.0078125,
        "--tets", "lattice", "--tet-count", 1500, "-o", f"{OUT}/oval_person.ply")
    ms = pymeshlab.MeshSet()
    back = np.linalg.inv(RIGID)
    marker_layer = add(ms, oval_markers @ back[:3, :3].T + back[:3, 3], label="markers")
    ms.set_matrix(transformmatrix=RIGID, freeze=False)
    add(ms, oval, FACES, "template")
    ms.apply_filter(RESHAPE, markers=marker_layer, **options)
    # The matrices' rounding is enough to send the solver another way, to a shape that is as good.
    far = np.abs(ms.current_mesh().vertex_matrix() - vertices_of(f"{OUT}/oval_person.ply")).max()
    assert far < 0.0078125, far
    ms.set_matrix(transformmatrix=RIGID, freeze=False)
    ms.set_current_mesh(marker_layer)
    assert np.array_equal(ms.current_mesh().transform_matrix(), RIGID)

    # Quality: the stretch, the distance to the markers, or how sure it is, equal to the command line's.
    cli("reshape", "--template", template, "--markers", markers, "--tolerance", 0.0078125, "--tets",
        "lattice", "--tet-count", 1500, "--ply-out", f"{OUT}/maps.ply", "-o", f"{OUT}/person.ply")
    maps = {
        "Largest stretch": "stretch", "Distance to the nearest marker": "marker_distance",
        "Standard deviation across the surface": "sd_normal",
    }
    for choice, name in maps.items():
        values = scalar_of(f"{OUT}/maps.ply", name)
        ms = pymeshlab.MeshSet()
        marker_layer = add(ms, MARKERS)
        add(ms, POINTS, FACES)
        figures = ms.apply_filter(RESHAPE, markers=marker_layer, quality=choice, **options)
        assert 0 < figures["volume_sd"] < 0.1 * figures["volume"] and 0 < figures["area_sd"] < 0.1 * figures["area"], figures
        found = ms.current_mesh().vertex_scalar_array()
        assert np.allclose(found, values, rtol=1e-5, atol=1e-7), np.abs(found - values).max()
        colours = ms.current_mesh().vertex_color_matrix()
        assert (colours[found.argmax()] == [1, 0, 0, 1]).all() and (colours[found.argmin()] == [0, 0, 1, 1]).all()
    print("reshape: as the command line; all else kept; matrices; quality")


def solver_settings():
    template, markers = f"{OUT}/template.ply", f"{OUT}/markers.ply"
    cli("reshape", "--template", template, "--markers", markers, "--tolerance", 0.0078125, "--smoothness", 0.25,
        "--screening", 2, "--poisson", 0.25, "--max-iterations", 40, "--tets", "lattice", "--tet-count", 1500,
        "-o", f"{OUT}/set.ply")
    options = dict(tolerance=PureValue(0.0078125), tets="Lattice", tet_count=1500)

    def reshaped(selected="", **settings):
        ms = pymeshlab.MeshSet()
        marker_layer = add(ms, MARKERS)
        add(ms, POINTS, FACES)
        if selected:
            ms.compute_selection_by_condition_per_vertex(condselect=selected)
        figures = ms.apply_filter(RESHAPE, markers=marker_layer, **options, **settings)
        # A mesh dies with its set.
        return ms, figures

    ms, _ = reshaped(smoothness=0.25, screening=2, poisson=0.25, max_iterations=40)
    assert np.array_equal(ms.current_mesh().vertex_matrix(), vertices_of(f"{OUT}/set.ply"))

    ms, figures = reshaped(quality="Largest stretch", colorize=False, max_iterations=1)
    assert figures["stop"] == ITERATION_LIMIT and figures["warnings"] == 1, figures
    assert (ms.current_mesh().vertex_color_matrix() == 1).all()
    ms, figures = reshaped(seconds=0.001, max_iterations=0)
    assert figures["stop"] == CANCELLED and figures["warnings"] == 1, figures
    assert figures["mean_marker_distance"] < 0.2

    low = POINTS[:, 2] < -0.9
    ms, _ = reshaped(selected="z < -0.9", fix_selected=True)
    off = np.linalg.norm(ms.current_mesh().vertex_matrix() - POINTS, axis=1)
    assert low.sum() > 10 and off[low].max() < 0.0078125 and off[~low].max() > 0.3, off[low].max()
    print("reshape: the solver's settings, time, colours, vertices that stay")


def scalar_of(path, name):
    """A property of the vertices of a PLY file that the command line wrote."""
    with open(path, "rb") as f:
        data = f.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    head = data[:end].decode().split("\n")
    count = next(int(line.split()[2]) for line in head if line.startswith("element vertex"))
    kinds = {"double": "<f8", "float": "<f4", "uchar": "u1"}
    names = []
    for line in head[head.index(f"element vertex {count}") + 1:]:
        if not line.startswith("property"):
            break
        names.append((line.split()[2], kinds[line.split()[1]]))
    if "format ascii 1.0" in head:
        rows = data[end:].decode().split("\n")[:count]
        column = [n for n, _ in names].index(name)
        return np.array([float(row.split()[column]) for row in rows])
    return np.frombuffer(data, dtype=names, count=count, offset=end)[name]


def landmarks_alignment_and_bones():
    names = {"top": 0, "bottom": len(POINTS) - 1, "front": 1 + 5 * 16, "left": 1 + 5 * 16 + 4}

    def pp(path, place):
        points = "".join(f'<point active="1" name="{n}" x="{p[0]!r}" y="{p[1]!r}" z="{p[2]!r}"/>'
                         for n, p in ((n, list(map(float, place(v)))) for n, v in names.items()))
        with open(path, "w") as f:
            f.write(f"<!DOCTYPE PickedPoints><PickedPoints><DocumentData/>{points}</PickedPoints>")
        return path

    person = lambda v: POINTS[v] * [1.5, 1, 0.8]
    back = np.linalg.inv(RIGID)
    on_template = pp(f"{OUT}/template.pp", lambda v: POINTS[v])
    on_person = pp(f"{OUT}/person.pp", lambda v: back[:3, :3] @ person(v) + back[:3, 3])
    ms = pymeshlab.MeshSet()
    marker_layer = add(ms, MARKERS @ back[:3, :3].T + back[:3, 3])
    ms.set_matrix(transformmatrix=RIGID, freeze=False)
    add(ms, POINTS, FACES)
    options = dict(markers=marker_layer, template_landmarks=on_template, person_landmarks=on_person,
                   landmark_tolerance=PureValue(0.0078125), tolerance=PureValue(0.0078125), tets="Lattice",
                   tet_count=1500)
    figures = ms.apply_filter(RESHAPE, **options)
    moved = ms.current_mesh().vertex_matrix()
    for vertex in names.values():
        assert np.linalg.norm(moved[vertex] - person(vertex)) < 0.05
    assert figures["mean_marker_distance"] < 0.01

    # A template that lies elsewhere, twice as large: its landmarks bring it to the person.
    far = POINTS * 2 + [30, 0, 0]
    ms.clear()
    marker_layer = add(ms, MARKERS)
    add(ms, far, FACES)
    options.update(markers=marker_layer, align="Turn, move and scale",
                   template_landmarks=pp(f"{OUT}/far.pp", lambda v: far[v]),
                   person_landmarks=pp(f"{OUT}/near.pp", person))
    ms.apply_filter(RESHAPE, **options)
    moved = ms.current_mesh().vertex_matrix()
    assert all(np.linalg.norm(moved[v] - person(v)) < 0.05 for v in names.values())

    # A bone at the top that the person has 0.5 higher.
    bone = POINTS[:17] * 1.01
    ms.clear()
    bone_layer = add(ms, bone)
    there_layer = add(ms, bone + [0, 0, 0.5])
    marker_layer = add(ms, POINTS[-40:])
    add(ms, POINTS, FACES)
    ms.apply_filter(RESHAPE, markers=marker_layer, bone=bone_layer, person_bone=there_layer,
                    attachment_distance=PureValue(0.05), tets="Lattice", tet_count=1500)
    moved = ms.current_mesh().vertex_matrix()
    assert abs(moved[0][2] - 1.5) < 0.1, moved[0]

    # Markers that contradict the bone: it wins where that is said.
    off = []
    for hard in (False, True):
        ms.clear()
        bone_layer = add(ms, bone)
        there_layer = add(ms, bone + [0, 0, 0.5])
        marker_layer = add(ms, POINTS)
        add(ms, POINTS, FACES)
        ms.apply_filter(RESHAPE, markers=marker_layer, bone=bone_layer, person_bone=there_layer,
                        attachment_distance=PureValue(0.05), attachment_tolerance=PureValue(0.05),
                        hard_attachments=hard, tets="Lattice", tet_count=1500)
        off.append(abs(ms.current_mesh().vertex_matrix()[0][2] - 1.5))
    assert off[1] < 0.06 and off[1] < off[0], off
    print("reshape: landmarks in .pp, alignment, attachments")


def liver():
    options = ["--tolerance", 0.25, "--landmark-tolerance", 15, "--tets", "lattice", "--tet-count", 2000]
    cli("reshape", "--template", f"{EXAMPLES}/liver/template.obj", "--markers",
        f"{EXAMPLES}/liver/markers.csv", "--landmarks", f"{EXAMPLES}/liver/landmarks.csv", *options,
        "-o", f"{OUT}/liver_cli.ply", "--report", f"{OUT}/liver_report")
    wanted = vertices_of(f"{OUT}/liver_cli.ply")
    with open(f"{EXAMPLES}/liver/markers.csv") as f:
        rows = csv.DictReader(line for line in f if not line.startswith("#"))
        markers = np.array([[float(row[c]) for c in ("x_mm", "y_mm", "z_mm")] for row in rows])
    ms = pymeshlab.MeshSet()
    marker_layer = add(ms, markers, label="markers")
    ms.load_new_mesh(f"{EXAMPLES}/liver/template.obj")
    figures = ms.apply_filter(RESHAPE, markers=marker_layer, tolerance=PureValue(0.25), tets="Lattice",
                              tet_count=2000, template_landmarks=f"{EXAMPLES}/liver/landmarks.csv",
                              landmark_tolerance=PureValue(15))
    far = np.abs(ms.current_mesh().vertex_matrix() - wanted).max()
    assert far == 0, f"{far} mm from the command line's"
    with open(f"{OUT}/liver_report/report.json") as f:
        reported = json.load(f)["marker_distance"]["after"]
    assert abs(figures["mean_marker_distance"] - reported["mean"]) < 1e-3, (figures, reported)
    assert abs(figures["max_marker_distance"] - reported["max"]) < 1e-3, (figures, reported)
    print(f"liver: as the command line, markers {figures['mean_marker_distance']:.3f} mm off on average")


def skeletons():
    thigh, faces = block(np.zeros(3), np.array([10, 2, 3.0]))
    shank, _ = block(np.array([18, 0, 0.0]), np.array([7, 1.5, 2.5]))
    person = lambda p: p * [1.2, 1, 1] + [3, -2, 1]
    both = np.vstack([thigh, shank]), np.vstack([faces, faces + len(thigh)])
    ms = pymeshlab.MeshSet()
    thigh_layer = add(ms, thigh, faces, "thigh")
    shank_layer = add(ms, shank @ RIGID[:3, :3] - RIGID[:3, 3] @ RIGID[:3, :3], faces, "shank")
    ms.set_matrix(transformmatrix=RIGID, freeze=False)
    target = add(ms, person(both[0]), both[1], "scan")
    saved = f"{OUT}/person.skeleton.json"
    figures = ms.apply_filter(REGISTER, target=target, joints="thigh-shank", align=False, save=saved)
    assert figures["verdict"] < 2 and figures["failed_bones"] == 0, figures
    assert figures["joints_outside"] == 0 and figures["mean_residual"] < 0.05, figures
    found = ms.mesh(thigh_layer).vertex_matrix()
    assert np.abs(found - person(thigh)).max() < 0.5
    moved = ms.mesh(shank_layer).transformed_vertex_matrix()
    assert np.abs(moved - person(shank)).max() < 0.5
    assert np.array_equal(ms.mesh(target).vertex_matrix(), person(both[0]))
    error_of(ms, REGISTER, "does not name two visible bone layers", target=target, joints="thigh-foot")

    # The file, put on the same surface again: bones without a layer get one.
    ms = pymeshlab.MeshSet()
    target = add(ms, person(both[0]), both[1], "scan")
    ms.apply_filter(REGISTER, target=target, skeleton=saved, align=False)
    assert ms.mesh_number() == 3
    again = {m.label(): m for m in ms}
    assert np.abs(again["thigh"].vertex_matrix() - found).max() < 0.1

    small = add(ms, person(both[0]) / 1000, both[1], "in metres")
    error_of(ms, REGISTER, "as if it were in metres", target=small, skeleton=saved, align=False)

    # The command line's own answer to the same question.
    scan = save_ply(f"{OUT}/scan.ply", person(both[0]), both[1])
    cli("register", saved, "--target", scan, "--no-align", "-o", f"{OUT}/registered")
    for name in ("thigh", "shank"):
        wanted = vertices_of(f"{OUT}/registered/bones/{name}.obj")
        assert np.array_equal(again[name].vertex_matrix(), wanted), name

    ms = pymeshlab.MeshSet()
    target = add(ms, person(both[0]), both[1], "scan")
    error_of(ms, REGISTER, "There is no bone", target=target)
    error_of(ms, REGISTER, "nowhere.skeleton.json", target=target, skeleton="nowhere.skeleton.json")
    add(ms, thigh[:5], label="thigh")
    ms.set_current_mesh(target)
    error_of(ms, REGISTER, "has 5 vertices and the bone of that name", target=target, skeleton=saved)
    print("register: layers with joints, a file, as the command line")


def tets_and_distances():
    ms = pymeshlab.MeshSet()
    marker_layer = add(ms, np.array([[0, 0, 3.0], [0, 0, -1]]))
    add(ms, POINTS, FACES)
    figures = ms.apply_filter(TETS, tets="Lattice", tet_count=1500, save=f"{OUT}/tets.vtu")
    assert 1000 < figures["tet_count"] < 3000 and figures["inverted_tets"] == 0
    assert 0 < figures["min_dihedral"] < 60 < figures["max_dihedral"] < 180
    assert figures["dihedral_histogram"].sum() == 6 * figures["tet_count"]
    assert os.path.getsize(f"{OUT}/tets.vtu") > 10000
    assert np.array_equal(ms.current_mesh().vertex_matrix(), POINTS)
    figures = ms.apply_filter(DISTANCE, markers=marker_layer)
    assert figures["mean_marker_distance"] == 1 and figures["max_marker_distance"] == 2
    quality = ms.current_mesh().vertex_scalar_array()
    assert quality[0] == 2 and quality[-1] == 0
    colours = ms.current_mesh().vertex_color_matrix()
    assert not np.array_equal(colours[0], colours[-1])
    ms.apply_filter(DISTANCE, markers=marker_layer, colorize=False)
    print("tets and distances")


def mistakes():
    ms = pymeshlab.MeshSet()
    empty = add(ms, MARKERS, label="nothing")
    ms.set_selection_all()
    ms.meshing_remove_selected_vertices()
    few = add(ms, MARKERS[:2], label="few")
    inches = add(ms, MARKERS * 1000, label="inches")
    marker_layer = add(ms, MARKERS, label="markers")
    own = add(ms, POINTS, FACES, "template")
    error_of(ms, RESHAPE, "markers are the template itself", markers=own)
    error_of(ms, RESHAPE, 'layer "nothing" has no points', markers=empty)
    error_of(ms, RESHAPE, "do not determine a shape", markers=few)
    error_of(ms, RESHAPE, "bring both to one unit", markers=inches)
    error_of(ms, RESHAPE, "a tet count of 3 cannot be met", markers=marker_layer, tet_count=3)
    error_of(ms, RESHAPE, "max_iterations is -5; it must be 0 or more", markers=marker_layer, max_iterations=-5)
    error_of(ms, RESHAPE, "tet_count is -1", markers=marker_layer, tet_count=-1)
    error_of(ms, RESHAPE, "smoothness is -1", markers=marker_layer, smoothness=-1)
    error_of(ms, RESHAPE, "Poisson's ratio must lie", markers=marker_layer, poisson=0.5)
    error_of(ms, RESHAPE, "No vertex of the current layer is selected", markers=marker_layer, fix_selected=True)
    error_of(ms, RESHAPE, "nowhere.pp", markers=marker_layer, template_landmarks="nowhere.pp",
             person_landmarks="nowhere.pp")
    error_of(ms, RESHAPE, "need landmarks on the template", markers=marker_layer,
             person_landmarks="nowhere.pp")
    error_of(ms, RESHAPE, "no vertex of the bone is within", markers=marker_layer, bone=inches,
             attachment_distance=PureValue(0.01))
    error_of(ms, RESHAPE, "tetgen", markers=marker_layer, tets="TetGen", tetgen="/nowhere/tetgen")
    error_of(ms, DISTANCE, "markers are the surface itself", markers=own)
    ms.set_current_mesh(marker_layer)
    fails("", lambda: ms.apply_filter(TETS))
    fails("", lambda: pymeshlab.MeshSet().apply_filter(RESHAPE))
    print("mistakes")


def scripts():
    ms = pymeshlab.MeshSet()
    marker_layer = add(ms, MARKERS)
    add(ms, POINTS, FACES)
    script = f"{OUT}/reshape.mlx"
    with open(script, "w") as f:
        f.write(f"""<!DOCTYPE FilterScript><FilterScript><filter name="Reshape Template to Markers">
            <Param type="RichMesh" name="markers" value="{marker_layer}"/>
            <Param type="RichAbsPerc" name="tolerance" value="0.0078125" min="0" max="10"/>
            <Param type="RichEnum" name="tets" value="2" enum_cardinality="3" enum_val0="Automatic"
             enum_val1="TetGen" enum_val2="Lattice"/>
            <Param type="RichInt" name="tet_count" value="1500"/>
            </filter></FilterScript>""")
    ms.load_filter_script(script)
    ms.apply_filter_script()
    assert np.array_equal(ms.current_mesh().vertex_matrix(), vertices_of(f"{OUT}/person.ply"))
    print(".mlx script")


markers_as_the_command_line()
solver_settings()
landmarks_alignment_and_bones()
skeletons()
separations()
tets_and_distances()
mistakes()
scripts()
liver()
print("filters: good")
