"""Motions of bodies during a step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks
from ._errors import InputError

Placement = tuple[list[float], list[float]]
"""Rotation, row by row, and translation."""


@dataclass(frozen=True)
class Turn:
    """Rigid turn about an axis through a center, right-handed, by an angle of any size.

    >>> round(Turn(axis=(0, 0, 1), center=(0, 0, 0), degrees=180).angle, 4)
    3.1416
    """

    axis: tuple[float, float, float]
    """Direction of the axis, of any length above 0."""
    center: tuple[float, float, float]
    """Point on the axis."""
    degrees: float

    def __post_init__(self) -> None:
        axis, center = vector(self.axis, "axis"), vector(self.center, "center")
        if not any(axis):
            raise InputError("the axis of a turn is zero: it has no direction")
        degrees = _checks.number(self.degrees, "degrees")
        if not math.isfinite(degrees):
            raise InputError(f"a turn by {degrees} degrees is not finite")
        object.__setattr__(self, "degrees", degrees)
        object.__setattr__(self, "axis", axis)
        object.__setattr__(self, "center", center)

    @property
    def angle(self) -> float:
        """The angle in radians."""
        return math.radians(self.degrees)


class Posed(NamedTuple):
    """Rigid motion to a pose, as the native module reads it."""

    pose: Placement
    center: tuple[float, float, float] | None


Motion = npt.ArrayLike | Turn
"""Positions at the end (n × 3), a 4 × 4 matrix for a rigid body, or a turn."""


def placement(name: str, matrix: npt.ArrayLike) -> Placement:
    """Return the rotation and the translation of a 4 × 4 matrix."""
    given = _arrays.numbers_of_any_shape(matrix, f"the numbers of the pose of {name!r}")
    given = given.astype(np.float64)
    if given.shape != (4, 4):
        raise InputError(f"a pose of {name!r} is a 4 × 4 matrix, not an array of shape {given.shape}")
    rotation = given[:3, :3]
    is_rotation = (
        np.isfinite(given).all()
        and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        and np.linalg.det(rotation) > 0
    )
    if not is_rotation or not np.array_equal(given[3], [0.0, 0.0, 0.0, 1.0]):
        raise InputError(f"the pose of {name!r} is not a rotation with a translation")
    return rotation.ravel().tolist(), given[:3, 3].tolist()


def native(
    moves: Mapping[str, Motion], centers: Mapping[str, Sequence[float]]
) -> list[tuple[str, _arrays.Points | Turn | Posed]]:
    """Return motions by name as the native module reads them."""
    found: list[tuple[str, _arrays.Points | Turn | Posed]] = []
    for name, motion in moves.items():
        _checks.name(name)
        if isinstance(motion, Turn):
            found.append((name, motion))
        elif _is_matrix(motion, name):
            center = centers.get(name)
            about = vector(center, f"center of {name!r}") if center is not None else None
            found.append((name, Posed(placement(name, motion), about)))
        else:
            # A progress function may change the array that was given.
            found.append((name, _arrays.points(motion, f"vertices of {name!r}").copy()))

    # A center without effect is that of another body, or a mistyped name.
    posed = {name for name, motion in found if isinstance(motion, Posed)}
    for name in centers:
        if name not in posed:
            raise InputError(f"{name!r} has a center, and moves by no pose that turns about it")
    return found


def _is_matrix(motion: npt.ArrayLike, name: str) -> bool:
    return _arrays.numbers_of_any_shape(motion, f"vertices of {name!r}").shape == (4, 4)


def vector(given: Sequence[float], what: str) -> tuple[float, float, float]:
    """Return three finite numbers."""
    try:
        x, y, z = (_checks.number(number, what) for number in given)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} is three numbers, not {given!r}") from error
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(f"{what} is {given!r}, which is not finite")
    return x, y, z
