"""Medial surfaces: volumes as balls, with the cones and slabs between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _native
from ._checks import Progress
from ._record import Record, Table


@dataclass(frozen=True, eq=False, repr=False)
class MedialSurface(Record):
    """Balls of a closed surface, with the primitives between them."""

    centers: npt.NDArray[np.float64]
    """Centers of the balls (n × 3)."""
    radii: npt.NDArray[np.float64]
    """Their radii (n)."""
    slabs: npt.NDArray[np.uint32]
    """Balls of each slab (k × 3)."""
    cones: npt.NDArray[np.uint32]
    """Balls of each cone (k × 2)."""
    rms_deviation: float
    """Root mean square deviation from the surface, measured."""
    max_deviation: float
    """Deviation in either direction that is not exceeded."""

    def to_table(self) -> Table:
        """Return columns with one row per ball."""
        x, y, z = self.centers.T
        return {"x": x, "y": y, "z": z, "radius": self.radii}

    def __repr__(self) -> str:
        return (
            f"<MedialSurface of {len(self.radii)} balls, {len(self.slabs)} slabs, "
            f"{len(self.cones)} cones, within {self.max_deviation:.4g}>"
        )


def generate(
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    *,
    balls: int | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> MedialSurface:
    """Generate a medial surface of a closed surface, by number of balls or by tolerance."""
    # A progress function may change the arrays that were given.
    x = _arrays.points(vertices, "vertices").copy()
    corners = _arrays.faces(faces, "faces").copy()
    found = _native.generate_medial(
        x,
        corners,
        _checks.optional_count(balls, "balls"),
        _checks.optional_number(tolerance, "tolerance"),
        _checks.threads(threads),
        _checks.progress(progress),
    )
    return MedialSurface(**found)
