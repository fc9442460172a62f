"""Detection at rate: a method for each pair of bodies, within a tolerance."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _checks, _native
from ._checks import Progress
from ._record import Record
from .scene import Scene


@dataclass(frozen=True, eq=False)
class PlannedPair(Record):
    """Method for a pair of bodies."""

    a: str
    b: str
    method: str
    """``exact``, ``coarse`` or ``field``."""
    bound: float
    """Error of the depth that is not exceeded."""
    measured_error: float | None
    """Largest error at sample points, where some were measured."""
    predicted_seconds: float
    """Predicted time of the pair in a frame, by one thread of this machine.

    It follows what is counted as frames are detected. Before the first one it is 0 where no method but
    ``exact`` could have paid.
    """


@dataclass(frozen=True, eq=False, repr=False)
class DetectedPair(Record):
    """Two bodies in contact in one frame."""

    a: str
    b: str
    method: str
    state: str
    """``apart``, ``overlapping``, or ``undecided`` where the method cannot tell."""
    depth: tuple[float, float]
    """Certified bracket on the depth."""
    min_gap: float | None
    """Smallest gap of a vertex, negative inside."""
    gaps: npt.NDArray[np.float64]
    """Gaps of the contacts (k)."""
    normals: npt.NDArray[np.float64]
    """Their unit normals (k × 3)."""

    def __repr__(self) -> str:
        lower, upper = self.depth
        return (
            f"<DetectedPair {self.a} × {self.b}: {self.state}, depth {lower:.4g} to {upper:.4g}, "
            f"{len(self.gaps)} contacts>"
        )


class Plan:
    """Methods for all pairs of a scene that may meet, with the structures that they need.

    >>> box = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> scene = Scene()
    >>> scene.add("bone", box, faces, rigid=True)
    >>> scene.add("muscle", np.add(box, 1.0), faces)
    >>> plan = Plan(scene, tolerance=0.5)
    >>> plan.detect()[0].state
    'overlapping'
    """

    def __init__(
        self,
        scene: Scene,
        *,
        tolerance: float,
        margin: float = 0.0,
        max_displacement: float = 0.0,
        frames: int = 1,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Choose what costs least over ``frames`` and is proved to be within ``tolerance``.

        Times are predicted for this machine, whose speed is measured first, over a millisecond; those of
        a whole frame, which ``str(plan)`` begins with, for ``threads``.
        """
        self._native = _native.Plan(
            _checks.instance(scene, Scene, "the scene"),
            _checks.number(tolerance, "tolerance"),
            _checks.number(margin, "margin"),
            _checks.number(max_displacement, "max_displacement"),
            _checks.count(frames, "frames"),
            _checks.threads(threads),
            _checks.progress(progress),
        )

    @property
    def pairs(self) -> tuple[PlannedPair, ...]:
        """Methods of the planned pairs, in the order of the bodies."""
        return tuple(PlannedPair(**pair) for pair in self._native.pairs())

    def detect(self, *, threads: int | None = None) -> tuple[DetectedPair, ...]:
        """Detect all pairs where the scene's bodies are now."""
        return tuple(DetectedPair(**pair) for pair in self._native.detect(_checks.threads(threads)))

    def respond(self, *, clearance: float = 0.0) -> None:
        """Move soft bodies out of the contacts that were detected last, once."""
        self._native.respond(_checks.number(clearance, "clearance"))

    def __str__(self) -> str:
        return self._native.text()

    def __repr__(self) -> str:
        methods = Counter(pair.method for pair in self.pairs)
        listed = ", ".join(f"{number} {method}" for method, number in sorted(methods.items()))
        return f"<Plan of {methods.total()} pairs: {listed}>" if methods else "<Plan of no pairs>"
