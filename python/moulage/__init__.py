"""moulage puts a template of an organ or bone into one person's shape: numpy in, numpy out.

    tets = moulage.Tetrahedralization(moulage.TriMesh.load("liver.obj"))
    problem = moulage.Reshaping(tets)
    problem.set_markers(moulage.Markers.load("clicks.csv").points)
    result = problem.run(tolerance=0.3)
    result.points
"""

from .motions import Motion
from .native import CANCELLED, Error, LibraryError, library
from .registration import Registration, RegistrationResult
from .reshaping import Reshaping, ReshapingResult, default_options
from .separation import Separation, SeparationResult
from .shape_models import ShapeModel, left_out
from .shapes import Markers, Pairs, TetMesh, TriMesh
from .skeletons import Joint, Skeleton
from .tets import Progress, Run, Tetrahedralization
from .volumes import Plane, Volume, section

__all__ = [
    "CANCELLED", "Error", "Joint", "LibraryError", "Markers", "Motion", "Pairs", "Plane", "Progress", "Registration",
    "RegistrationResult", "Reshaping", "ReshapingResult", "Run", "Separation", "SeparationResult", "ShapeModel", "Skeleton",
    "TetMesh", "Tetrahedralization", "TriMesh", "Volume", "check_library", "default_options", "left_out", "section",
    "version",
]


def check_library():
    """Loads the native library; LibraryError says what is wrong with it."""
    library()


def version():
    """The version of the native library."""
    return library().mlg_version_string().decode()
