"""moulage puts a template of an organ, bone or skeleton into one person's shape: numpy in, numpy out.

    tets = moulage.Tetrahedralization(moulage.TriMesh.load("liver.obj"))
    problem = moulage.Reshaping(tets)
    problem.set_markers(moulage.Markers.load("clicks.csv"))
    result = problem.run(moulage.ReshapingOptions(tolerance=0.3))
    result.points
"""

from .findings import Finding, inspect
from .interface import VERSION_MAJOR, VERSION_MINOR, VERSION_PATCH
from .markers import Markers, Pairs
from .meshes import Surface, TetMesh, TriMesh, align
from .motions import Motion
from .native import CANCELLED, Error, LibraryError, library
from .registration import Registration, RegistrationOptions
from .registration_result import BoneFit, JointPose, RegistrationResult, RegistrationSummary
from .reshaping import Reshaping, ReshapingOptions
from .reshaping_result import ReshapingResult, ReshapingSummary
from .runs import Progress, Run
from .separation import (
    Overlap, SeparatedBody, Separation, SeparationOptions, SeparationResult, SeparationSummary,
)
from .shape_models import ShapeModel, left_out
from .skeletons import Joint, Skeleton
from .tets import Tetrahedralization, TetQuality
from .uncertainty import Uncertainty, UncertaintySummary
from .volumes import Clicks, Image, Plane, Volume, VolumeInfo, section

__all__ = [
    "CANCELLED", "BoneFit", "Clicks", "Error", "Finding", "Image", "Joint", "JointPose", "LibraryError", "Markers", "Motion", "Overlap",
    "Pairs", "Plane", "Progress", "Registration", "RegistrationOptions", "RegistrationResult", "RegistrationSummary",
    "Reshaping", "ReshapingOptions", "ReshapingResult", "ReshapingSummary", "Run", "SeparatedBody", "Separation",
    "SeparationOptions", "SeparationResult", "SeparationSummary", "ShapeModel", "Skeleton", "Surface", "TetMesh", "TetQuality",
    "Tetrahedralization", "TriMesh", "Uncertainty", "UncertaintySummary", "Volume", "VolumeInfo", "align", "check_library",
    "inspect", "left_out", "section", "version",
]

__version__ = f"{VERSION_MAJOR}.{VERSION_MINOR}.{VERSION_PATCH}"


def check_library() -> None:
    """Load the native library.

    Raises
    ------
    LibraryError
        Says what is wrong with it.
    """
    library()


def version() -> str:
    """Tell the version of the native library.

    Returns
    -------
    str
    """
    found: bytes = library().mlg_version_string()
    return found.decode()
