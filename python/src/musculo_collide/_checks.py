"""Checks of single values, with messages that name them."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from ._errors import InputError, InputTypeError

T = TypeVar("T")
Progress = Callable[[float], object]

LARGEST_COUNT = 2**63 - 1
"""The largest number that the native module reads; it refuses most of them by their values."""


def number(value: object, what: str) -> float:
    """Return a real number as a float."""
    if isinstance(value, (str, bytes)) or not hasattr(value, "__float__"):
        raise InputTypeError(f"{what} is a number, not {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise InputTypeError(f"{what} is a number, not {value!r}") from error
    except OverflowError as error:
        raise InputError(f"{what} is {value}, which is too large") from error


def optional_number(value: object, what: str) -> float | None:
    """Return a real number as a float, or ``None``."""
    return None if value is None else number(value, what)


def count(value: object, what: str) -> int:
    """Return a whole number."""
    try:
        found = operator.index(value)  # type: ignore[arg-type]
    except TypeError as error:
        raise InputTypeError(f"{what} is a whole number, not {value!r}") from error
    if abs(found) > LARGEST_COUNT:
        raise InputError(f"{what} is {found}, which is too large")
    return found


def optional_count(value: object, what: str) -> int | None:
    """Return a whole number, or ``None``."""
    return None if value is None else count(value, what)


def threads(value: object) -> int | None:
    """Return a number of threads, or ``None``."""
    return optional_count(value, "threads")


def name(value: object) -> str:
    """Return the name of a body."""
    found = instance(value, str, "the name of a body", "a string")
    try:
        found.encode()
    except UnicodeEncodeError as error:
        raise InputError(f"the name of a body is {found!r}, which is no text: {error}") from error
    return found


def names(value: object, what: str) -> list[str]:
    """Return the names of bodies; a single string is none."""
    if isinstance(value, str):
        raise InputTypeError(f"{what} is a list of names, not the string {value!r}")
    return [name(item) for item in instance(value, Iterable, what, "a list of names")]  # type: ignore[type-abstract]


def progress(value: object) -> Progress | None:
    """Return a progress function, or ``None``."""
    if value is not None and not callable(value):
        raise InputTypeError(f"progress is a function of the finished share, not {value!r}")
    return value


def mapping(value: object, what: str) -> Mapping[Any, Any]:
    """Return a mapping."""
    return instance(value, Mapping, what, "a dictionary")  # type: ignore[type-abstract]


def path(value: object) -> str:
    """Return the path of a file."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputTypeError(f"the path of a file is a string or a path, not {type(value).__name__}")
    found = os.fsdecode(value)
    try:
        os.fsencode(found)
    except UnicodeEncodeError as error:
        raise InputError(f"the path of a file is {found!r}, which no file has: {error}") from error
    return found


def instance(value: object, kind: type[T], what: str, wanted: str | None = None) -> T:
    """Return a value of a class."""
    if not isinstance(value, kind):
        raise InputTypeError(f"{what} is {wanted or kind.__name__}, not {type(value).__name__}")
    return value
