"""Arrays as the native module reads them: row order, float64 points, int64 faces."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputTypeError, InputError

Points = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]


def points(array: npt.ArrayLike, what: str) -> Points:
    """Return points (n × 3) as float64 in row order: the array itself where it is that already."""
    given = _numbers(array, what, "fiu")
    if given.ndim != 2 or given.shape[1] != 3:
        raise InputError(f"{what} are n × 3 numbers, not an array of shape {given.shape}")
    return np.require(given, np.float64, ["C", "A"])


def faces(array: npt.ArrayLike, what: str) -> Faces:
    """Return corners of faces (m × 3) as int64 in row order.

    Also takes the flat lists of PyVista (3, a, b, c, 3, …).
    """
    given = _numbers(array, what, "iu")
    if given.ndim == 1 and given.size % 4 == 0 and (given[::4] == 3).all():
        given = given.reshape(-1, 4)[:, 1:]
    if given.ndim != 2 or given.shape[1] != 3:
        raise InputError(f"{what} are m × 3 numbers of vertices, not an array of shape {given.shape}")
    if given.dtype == np.uint64 and given.size and int(given.max()) > np.iinfo(np.int64).max:
        raise InputError(f"{what} have the corner {given.max()}, which no mesh has")
    return np.require(given, np.int64, ["C", "A"])


def indices(array: npt.ArrayLike, what: str) -> list[int]:
    """Return numbers of vertices as a list."""
    given = _numbers(array, what, "iu")
    if given.ndim != 1:
        raise InputError(f"{what} are a list of numbers, not an array of shape {given.shape}")
    for number in given:
        if not 0 <= number < 2**32:
            raise InputError(f"{what} have the number {number}, which no vertex has")
    return [int(number) for number in given]


def numbers(array: npt.ArrayLike, what: str) -> npt.NDArray[np.float64]:
    """Return a list of numbers as float64: the array itself where it is that already."""
    given = _numbers(array, what, "fiu")
    if given.ndim != 1:
        raise InputError(f"{what} is a list of numbers, not an array of shape {given.shape}")
    return np.require(given, np.float64, ["C", "A"])


def numbers_of_any_shape(array: npt.ArrayLike, what: str) -> npt.NDArray[Any]:
    """Return an array of real numbers."""
    return _numbers(array, what, "fiu")


def _numbers(array: npt.ArrayLike, what: str, kinds: str) -> npt.NDArray[Any]:
    if np.ma.is_masked(array):
        raise InputError(f"{what} are partly masked: leave out what is to be left out")
    try:
        given = np.asarray(array)
    except ValueError as error:
        raise InputError(f"{what} are no array of numbers: {error}") from error
    if given.size == 0 and given.dtype.kind == "f" and kinds == "iu":
        given = given.astype(np.int64)
    if given.dtype.kind not in kinds:
        wanted = "whole numbers" if kinds == "iu" else "real numbers"
        raise InputTypeError(f"{what} are {wanted}, not {given.dtype}")
    return given
