"""Contact step of a simulator: positions, velocities and loads, corrected in place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _native
from ._checks import Progress
from ._errors import InputError, InputTypeError
from ._settings import StepSettings
from .field import DistanceField
from .motion import vector, placement
from ._record import Record, Vector
from .scene import Scene

States = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Material:
    """Material of the contacts of one pair: hard and without friction unless it says otherwise."""

    clearance: float = 0.0
    """Distance that is kept free."""
    friction: float = 0.0
    """Coulomb's coefficient, of sticking where sliding has another one."""
    dynamic_friction: float | None = None
    """Coefficient of sliding; that of ``friction`` unless given."""
    stiffness: float | None = None
    """Force per depth of a soft contact; ``None`` for a hard one."""
    damping: float = 0.0
    """Force per speed of a soft contact."""
    permanent: str | None = None
    """``sticking`` or ``sliding`` for contacts that never open, once they are attached."""
    attach_within: float = 0.0
    """Gap beyond the clearance up to which permanent contacts are attached at the start."""


@dataclass(frozen=True, eq=False)
class StepReport(Record):
    """Contacts of one step, and what their corrections did."""

    contacts: int
    """Contacts as detected last."""
    rounds: int
    """Corrections of positions, with contacts detected anew after each."""
    depth_before: float
    """Largest depth of hard contacts at the start."""
    depth: float
    """Largest depth of hard contacts as detected last."""
    approach_before: float
    """Largest speed of approach before velocities are corrected."""
    approach: float
    """The same after."""
    impulse: Vector
    """Momentum given by bones and fixed particles."""
    force: Vector
    """Force of bones and fixed particles, where accelerations or forces were corrected."""
    kinetic_energy: float
    """Change of the kinetic energy by the correction of velocities."""
    rigid_work: float
    """Work of moving bones and fixed particles in it: the kinetic energy of hard contacts that are
    solved grows by at most as much."""
    contact_energy: float
    """Energy of soft contacts at the start of the move."""
    unknown_sides: int
    """Vertices inside a body that were never seen outside: they leave by the nearest side."""
    fallbacks: list[tuple[str, str, str]]
    """Pairs that were detected exactly though they have another method, with the reasons."""
    unheld_overlaps: list[tuple[str, str]]
    """Pairs that overlap where no contact touches."""
    swept_contacts: int | None
    """Contacts met during the move that were added; ``None`` unless asked for."""
    free_share: float | None
    """Share of the move before which no other contact begins; ``None`` unless asked for."""


class ContactStep:
    """Contact step of a simulator, with the memory that it carries from step to step.

    It stands before the move: forces change velocities, then this step corrects positions and
    velocities, then velocities move the particles. All arrays have one row per vertex of the scene,
    body after body (``scene.particles(name)``), and are changed where they are.

    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> scene = Scene()
    >>> scene.add("bone", [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]], faces, rigid=True)
    >>> scene.add("muscle", [[1, 1, -8], [3, 1, -8], [1, 3, -8], [1, 1, 0.5]], faces)
    >>> step = ContactStep(scene, margin=0.5)
    >>> x = scene.particle_positions()
    >>> v = np.zeros_like(x)
    >>> step.correct(x, v, h=0.01).depth_before
    0.5
    """

    def __init__(
        self,
        scene: Scene,
        *,
        margin: float,
        tolerance: float = 0.0,
        material: Material = Material(),
    ) -> None:
        """Respond to gaps up to ``margin``, above 0; kept structures may miss ``tolerance``."""
        self._scene = _checks.instance(scene, Scene, "the scene")
        length, error = _checks.number(margin, "margin"), _checks.number(tolerance, "tolerance")
        self._native = _native.Step(scene, length, error, _material(material))

    def set_material(self, a: str, b: str, material: Material) -> None:
        """Set the material of one pair.

        One that is not permanent lets go of contacts that were attached by another one before.
        """
        self._native.set_material(_checks.name(a), _checks.name(b), _material(material))

    def set_field(self, name: str, field: DistanceField) -> None:
        """Detect the pairs of a bone by its field, which was built where the bone was added.

        Of this, :meth:`set_coarse` and :meth:`set_balls`, the last one that is called holds for a pair.
        """
        _checks.instance(field, DistanceField, "the field")
        self._native.set_field(_checks.name(name), field._native)

    def set_coarse(
        self,
        name: str,
        *,
        deviation: float | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Detect the pairs of a body by a coarser surface, which follows it as it deforms.

        It deviates by at most ``deviation``, half of the step's tolerance unless given. Where it comes
        to deviate by more than the tolerance, its pairs are detected exactly: ``fallbacks`` names them.
        """
        length = _checks.optional_number(deviation, "deviation")
        self._native.set_coarse(_checks.name(name), length, _checks.threads(threads), _checks.progress(progress))

    def set_balls(
        self,
        name: str,
        *,
        tolerance: float,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Find what comes near a body by balls within ``tolerance`` of its surface.

        They follow the body as it deforms, and its surface measures what they find. Where the surface
        comes to extend beyond them by the step's tolerance more, its pairs are detected exactly:
        ``fallbacks`` names them.
        """
        length = _checks.number(tolerance, "tolerance")
        self._native.set_balls(_checks.name(name), length, _checks.threads(threads), _checks.progress(progress))

    def move_bone(
        self,
        name: str,
        matrix: npt.ArrayLike,
        *,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        spin: Sequence[float] = (0.0, 0.0, 0.0),
        about: Sequence[float] | None = None,
    ) -> None:
        """Place a bone by a 4 × 4 matrix, and set its motion there, which holds until the next call.

        ``velocity`` is that of the point ``about`` (of the matrix's translation unless given),
        ``spin`` the angular velocity in radians per time.
        """
        pose = placement(_checks.name(name), matrix)
        center = vector(pose[1] if about is None else about, "about")
        self._native.move_bone(name, pose, vector(velocity, "velocity"), vector(spin, "spin"), center)

    def __repr__(self) -> str:
        return f"<ContactStep over {self._scene!r}>"

    def correct(
        self,
        x: States,
        v: States,
        *,
        h: float,
        inverse_mass: npt.ArrayLike | None = None,
        accelerations: States | None = None,
        forces: States | None = None,
        depth_tolerance: float = 0.0,
        max_rounds: int = 4,
        iterations: int = 10,
        swept: bool = False,
        threads: int | None = None,
    ) -> StepReport:
        """Correct positions, velocities, and accelerations or forces, before a move of length ``h``.

        Arrays are float64 in row order, writable, and no two of them overlap: what is not so is
        refused, never copied. ``inverse_mass`` is 1 unless given, 0 where a particle is fixed. After
        an exception, corrections that were made stay. ``swept`` also corrects velocities by contacts
        that are met during the move. The scene then has the corrected positions.
        """
        for array, what in ((x, "x"), (v, "v"), (accelerations, "accelerations"), (forces, "forces")):
            if array is not None:
                _require_states(array, what)
        mass = np.ones(len(x)) if inverse_mass is None else _arrays.numbers(inverse_mass, "inverse_mass")
        settings = StepSettings(
            h=_checks.number(h, "h"),
            depth_tolerance=_checks.number(depth_tolerance, "depth_tolerance"),
            max_rounds=_checks.count(max_rounds, "max_rounds"),
            iterations=_checks.count(iterations, "iterations"),
            swept=bool(swept),
        )
        found = self._native.correct(x, v, mass, accelerations, forces, settings, _checks.threads(threads))
        return StepReport(**found)


def _material(material: object) -> Material:
    """Return a material whose values are of their types."""
    given = _checks.instance(material, Material, "the material")
    _checks.number(given.clearance, "clearance")
    _checks.number(given.friction, "friction")
    _checks.optional_number(given.dynamic_friction, "dynamic_friction")
    _checks.optional_number(given.stiffness, "stiffness")
    _checks.number(given.damping, "damping")
    _checks.number(given.attach_within, "attach_within")
    if given.permanent is not None:
        _checks.instance(given.permanent, str, "permanent", "a string")
    return given


def _require_states(array: object, what: str) -> None:
    """Refuse an array that could not be changed where it is."""
    if not isinstance(array, np.ndarray):
        raise InputTypeError(f"{what} is changed in place: it is a numpy array, not {type(array).__name__}")
    if array.dtype != np.float64 or not array.dtype.isnative:
        raise InputTypeError(f"{what} is changed in place: its numbers are float64, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{what} is n × 3 numbers, not an array of shape {array.shape}")
    if not array.flags.c_contiguous or not array.flags.aligned:
        raise InputError(f"{what} is changed in place: its rows follow each other in memory")
