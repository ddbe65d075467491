"""A program with types that uses every public name of the package: run, and read by mypy --strict.

    python tests/python/every_class.py
"""

import tempfile
from pathlib import Path

import numpy
from numpy.typing import NDArray

import moulage

Floats = NDArray[numpy.float64]


def cube(size: float = 1.0) -> moulage.TriMesh:
    points = [(x, y, z) for x in (0, size) for y in (0, size) for z in (0, size)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return moulage.TriMesh(points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def extent(surface: moulage.Surface) -> Floats:
    points = moulage.TriMesh.of(surface).points
    extents: Floats = points.max(axis=0) - points.min(axis=0)
    return extents


def reshape(folder: Path) -> moulage.ReshapingResult:
    filling: moulage.Run[moulage.Tetrahedralization] = moulage.Tetrahedralization.start(cube(), "lattice", 300)
    tets = filling.wait()
    quality: moulage.TetQuality = tets.quality
    assert quality["inverted_count"] == 0 and moulage.TetMesh(tets.points, tets.tets).tets.shape[1] == 4
    moulage.Markers([(1.5, 0.5, 0.5)], labels=["side"]).save(folder / "markers.csv")
    markers = moulage.Markers.load(folder / "markers.csv")
    (folder / "pairs.csv").write_text(
        "vertex,target_x,target_y,target_z\n" + "".join(f"{i},{1.5 * x},{y},{z}\n" for i, (x, y, z) in enumerate(cube().points))
    )
    pairs: moulage.Pairs = moulage.Pairs.load_landmarks(cube(), folder / "pairs.csv")
    doubts: list[moulage.Finding] = moulage.inspect(cube(), markers, pairs, fixed=[0])
    assert [(d.concern, d.severity) for d in doubts] == [("amount", "note")]
    assert abs(moulage.align(cube().points, cube().points) - numpy.eye(4)).max() < 1e-12
    problem = moulage.Reshaping(tets)
    problem.set_markers(markers)
    problem.set_landmarks(pairs)
    seen: list[moulage.Progress] = []
    result = problem.run(moulage.ReshapingOptions(landmark_tolerance=0.01), progress=seen.append)
    summary: moulage.ReshapingSummary = result.summary
    assert summary["inverted_tets"] == 0 and seen[-1].ended
    assert abs(extent(result.surface)[0] - 1.5) < 0.05
    sure: moulage.Uncertainty = result.uncertainty(4)
    size: moulage.UncertaintySummary = sure.summary
    assert size["shapes"] == len(sure) == 4 and sure.shape(3).shape == (8, 3)
    return result


def separate(result: moulage.ReshapingResult) -> None:
    problem = moulage.Separation()
    problem.add_result("cube", result)
    problem.add_obstacle("bone", cube(0.1))
    apart: moulage.SeparationResult = problem.run(moulage.SeparationOptions(rings=3))
    summary: moulage.SeparationSummary = apart.summary
    overlaps: list[moulage.Overlap] = apart.overlaps
    body: moulage.SeparatedBody = apart.body(0)
    assert len(overlaps) == summary["overlap_count"] and body["inverted_tets"] == 0


def register(folder: Path) -> None:
    template = moulage.Skeleton([("bone", cube())])
    larger = moulage.Skeleton([("bone", cube(1.1))])
    registration = moulage.Registration(template)
    registration.set_bone_target("bone", larger.bone("bone"))
    registered: moulage.RegistrationResult = registration.run(moulage.RegistrationOptions(align=False))
    summary: moulage.RegistrationSummary = registered.summary
    fit: moulage.BoneFit = registered.bone_fit("bone")
    assert fit["verdict"] == summary["verdict"] == "good"
    two = moulage.Skeleton([("a", cube()), ("b", cube(2))], [moulage.Joint("j", 0, 1)])
    motion = moulage.Motion(two, [0, 1], {})
    motion.save(folder / "still.mot")
    jointed = moulage.Registration(two)
    jointed.set_target(two.surface)
    pose: moulage.JointPose = jointed.run(moulage.RegistrationOptions(align=False, max_iterations=1)).joint_pose(0)
    assert pose["shift"] < 0.1
    samples = [moulage.Skeleton([("bone", cube(size))]) for size in (0.9, 1.0, 1.2)]
    model = moulage.ShapeModel(template, samples)
    assert len(model.deviations) > 0 and len(moulage.left_out(template, samples)) == 3


def images() -> None:
    k, j, i = numpy.meshgrid(*[numpy.arange(-6, 7)] * 3, indexing="ij")
    image: moulage.Image = moulage.Volume.from_array(3.0 * (i**2 + j**2 + k**2 < 20))
    volume = moulage.Volume.of(image)
    info: moulage.VolumeInfo = volume.info
    plane: moulage.Plane = volume.plane((0, 0, 1), 6.0)
    assert info["size"].tolist() == [13, 13, 13] and len(volume.outlines(3, plane)) == 1
    assert len(volume.label_markers(3, clicks=moulage.Clicks(every=2, spacing=2)).points) > 10
    assert len(moulage.section(volume.label_surface(3), plane.centre, (0, 0, 1))) == 1


def errors() -> None:
    try:
        moulage.check_library()
        moulage.TriMesh.load("no such file.obj")
    except moulage.LibraryError:
        raise
    except moulage.Error as error:
        assert error.status != moulage.CANCELLED and "no such file" in str(error)
    assert moulage.version() == moulage.__version__


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        separate(reshape(Path(made)))
        register(Path(made))
    images()
    errors()
    text = Path(__file__).read_text()
    left = [name for name in moulage.__all__ if f"moulage.{name}" not in text]
    assert not left, f"not used: {left}"
    print(f"{len(moulage.__all__)} names used")
