"""Where anatomical surfaces touch or overlap, how deep, since when, and what to do about it."""

from . import medial
from ._errors import FileError, InputError, InputTypeError, InUseError, MusculoCollideError
from ._native import __version__
from .field import DistanceField
from .joint import Cartilage, ContactMeasures, JointContact, SurfaceContact
from .mesh import Mesh, from_trimesh, read_mesh, to_trimesh, write_mesh
from .motion import Turn
from .plan import DetectedPair, Plan, PlannedPair
from .results import (
    BodyChange,
    BrokenLimit,
    Depth,
    Measures,
    NearVertices,
    Overlap,
    Pair,
    Pairs,
    Remaining,
    Resolution,
    ShortGap,
    TiedVertices,
)
from .scene import Scene
from .step import ContactStep, Material, StepReport
from .surface import ClosestPoints, Surface
from .sweep import Sweep, SweptContacts, SweptPair

__all__ = [
    "BodyChange",
    "BrokenLimit",
    "Cartilage",
    "ClosestPoints",
    "ContactMeasures",
    "ContactStep",
    "Depth",
    "DetectedPair",
    "DistanceField",
    "FileError",
    "InUseError",
    "InputError",
    "InputTypeError",
    "JointContact",
    "Material",
    "Measures",
    "Mesh",
    "MusculoCollideError",
    "NearVertices",
    "Overlap",
    "Pair",
    "Pairs",
    "Plan",
    "PlannedPair",
    "Remaining",
    "Resolution",
    "Scene",
    "ShortGap",
    "StepReport",
    "Surface",
    "SurfaceContact",
    "Sweep",
    "SweptContacts",
    "SweptPair",
    "TiedVertices",
    "Turn",
    "__version__",
    "from_trimesh",
    "medial",
    "read_mesh",
    "to_trimesh",
    "write_mesh",
]
