"""Signed distance fields of bones."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _native
from ._checks import Progress
from ._record import Record


@dataclass(frozen=True, eq=False)
class MeasuredError(Record):
    """Difference from exact distances at sample points; elsewhere it may be larger."""

    points: int
    rms: float
    max: float


class DistanceField:
    """Signed distances on a regular grid, negative inside.

    >>> vertices = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> field = DistanceField.build(vertices, faces, spacing=1.0)
    >>> field.query([[8.0, 8.0, -2.0]]).round(4)
    array([2.])
    """

    def __init__(self, native: _native.Field) -> None:
        self._native = native
        grid = native.grid()
        self.origin: tuple[float, float, float] = grid["origin"]
        self.spacing: float = grid["spacing"]
        self.dims: tuple[int, int, int] = grid["dims"]
        self.bytes: int = grid["bytes"]

    @classmethod
    def build(
        cls,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        spacing: float,
        padding: float | None = None,
        truncation: float | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> DistanceField:
        """Build the field of a surface.

        ``padding`` is 10 spacings unless given. Distances beyond ``truncation`` are stored as that; unless
        it is given, none is, and a query returns distances everywhere in the grid. The program's fields
        have a truncation of 15 spacings, which takes less time.
        """
        # A progress function may change the arrays that were given.
        x = _arrays.points(vertices, "vertices").copy()
        corners = _arrays.faces(faces, "faces").copy()
        return cls(
            _native.Field.build(
                x,
                corners,
                _checks.number(spacing, "spacing"),
                _checks.optional_number(padding, "padding"),
                _checks.optional_number(truncation, "truncation"),
                _checks.threads(threads),
                _checks.progress(progress),
            )
        )

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> DistanceField:
        """Read a field from an NRRD or VTI file."""
        return cls(_native.Field.read(_checks.path(path)))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the field as NRRD or VTI, by the path's extension."""
        self._native.write(_checks.path(path))

    def query(
        self, points: npt.ArrayLike, *, cubic: bool = False, threads: int | None = None
    ) -> npt.NDArray[np.float64]:
        """Return the signed distances of points (n × 3), infinite outside the grid.

        Points that are not finite are refused. An array of float64 in row order is read where it is.
        """
        return self._query(points, cubic, False, threads)[0]

    def query_with_gradients(
        self, points: npt.ArrayLike, *, cubic: bool = False, threads: int | None = None
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return signed distances (n) and their gradients (n × 3)."""
        distances, gradients = self._query(points, cubic, True, threads)
        assert gradients is not None
        return distances, gradients

    def _query(
        self, points: npt.ArrayLike, cubic: bool, gradients: bool, threads: int | None
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None]:
        x = _arrays.points(points, "points")
        return self._native.query(x, bool(cubic), gradients, _checks.threads(threads))

    def values(self) -> npt.NDArray[np.float32]:
        """Return a copy of the values at the nodes, with the axes (z, y, x)."""
        x, y, z = self.dims
        return self._native.values().reshape(z, y, x)

    @property
    def measured_error(self) -> MeasuredError | None:
        """Error near the surface, at sample points; ``None`` for a field from a file.

        Wrong signs count, unless the surface is open.
        """
        measured = self._native.report()["measured_error"]
        return MeasuredError(*measured) if measured else None

    @property
    def error_bound(self) -> float | None:
        """Error near the surface that is never exceeded, where one is proved."""
        bound: float | None = self._native.report()["error_bound"]
        return bound

    @property
    def warnings(self) -> list[str]:
        """Properties of the surface that make the field unreliable."""
        warnings: list[str] = self._native.report()["warnings"]
        return warnings

    def __repr__(self) -> str:
        x, y, z = self.dims
        return f"<DistanceField of {x} × {y} × {z} nodes, spacing {self.spacing:g}>"
