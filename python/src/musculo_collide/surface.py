"""Exact questions of points to one surface."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _native
from ._from_native import overlap_from
from ._record import ArrayTuple
from .results import Depth, Overlap


class _ClosestPoints(NamedTuple):
    points: npt.NDArray[np.float64]
    """The closest points (n × 3)."""
    faces: npt.NDArray[np.uint32]
    """Faces that hold them (n); of several the one of the lowest number."""
    distances: npt.NDArray[np.float64]
    """Distances to the points asked for (n)."""


class ClosestPoints(ArrayTuple, _ClosestPoints):
    """Closest points of a surface, one for each point of the query."""

    __slots__ = ()


class Surface:
    """Surface with a tree, for queries of many points.

    Points that are not finite, or have coordinates beyond 1e30, are refused.

    >>> surface = Surface([[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]],
    ...                   [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> surface.signed_distance([[8, 8, -2], [8, 8, 2]])
    array([ 2., -2.])
    """

    def __init__(self, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> None:
        x = _arrays.points(vertices, "vertices")
        self._native = _native.Surface(x, _arrays.faces(faces, "faces"))

    def __reduce__(self) -> tuple[type[Surface], tuple[Any, ...]]:
        return Surface, (self.vertices, self.faces)

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """A copy of the positions (n × 3)."""
        return self._native.vertices()

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """A copy of the faces (m × 3)."""
        return self._native.faces()

    @property
    def no_inside(self) -> str | None:
        """Reason why the surface has no inside; ``None`` where it has one."""
        return self._native.no_inside()

    def contains(self, points: npt.ArrayLike, *, threads: int | None = None) -> npt.NDArray[np.bool_]:
        """Return which points (n × 3) are inside, exactly. Those on the surface are not."""
        return self._native.contains(_arrays.points(points, "points"), _checks.threads(threads))

    def signed_distance(
        self, points: npt.ArrayLike, *, threads: int | None = None
    ) -> npt.NDArray[np.float64]:
        """Return the distances of points (n × 3) from the surface, negative inside."""
        return self._native.signed_distance(_arrays.points(points, "points"), _checks.threads(threads))

    def closest_points(self, points: npt.ArrayLike, *, threads: int | None = None) -> ClosestPoints:
        """Return the closest points of the surface."""
        x = _arrays.points(points, "points")
        return ClosestPoints(*self._native.closest_points(x, _checks.threads(threads)))

    def overlap(self, other: Surface) -> Overlap | None:
        """Measure what both surfaces share: volume, areas and curve; ``None`` where it is nothing.

        ``Scene.check`` has the depths and vertices of both as well.
        """
        found = self._native.overlap(_checks.instance(other, Surface, "the other surface")._native)
        return overlap_from(found) if found["regions"] else None

    def depths(self, other: Surface, *, width: float | None = None) -> tuple[Depth | None, Depth | None]:
        """Bracket the greatest depth of this surface in the other body, and of the other in this one.

        Brackets are no wider than ``width``, or 1 % unless given. ``None`` where nothing of a surface is
        inside, or where the other has no inside, covers a place twice or is inside out.
        """
        native = _checks.instance(other, Surface, "the other surface")._native
        found = self._native.depths(native, _checks.optional_number(width, "width"))
        of_this, of_other = (Depth(**depth) if depth else None for depth in found)
        return of_this, of_other

    def __repr__(self) -> str:
        return f"<Surface of {len(self.vertices)} vertices, {len(self.faces)} faces>"
