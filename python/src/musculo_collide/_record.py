"""Base of the results: values with names, as dictionaries, tables and HTML."""

from __future__ import annotations

import dataclasses
import html
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Vector = tuple[float, float, float]
Table = dict[str, npt.NDArray[Any]]

PARTS = {"covers_twice": ("a", "b"), "inside_vertices": ("a", "b"), "self_crossings": ("before", "after")}
"""Names of two values in a table that are not a lower and an upper bound."""


class Record:
    """Base of the results."""

    def to_dict(self) -> dict[str, Any]:
        """Return names and values; nested results are dictionaries, arrays stay arrays."""
        return {field.name: _plain(getattr(self, field.name)) for field in dataclasses.fields(self)}  # type: ignore[arg-type]

    def to_table(self) -> Table:
        """Return columns that ``pandas.DataFrame`` or ``polars.DataFrame`` take as they are.

        There is one row per entry of the result's arrays, or one row of its numbers where it has none.
        What is undefined is NaN.
        """
        arrays = {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        return columns_of(arrays) if arrays else table([self])

    def _repr_html_(self) -> str:
        return _html(self, {name: cell(value) for name, value in _numbers(self).items()})

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        names = [field.name for field in dataclasses.fields(self)]  # type: ignore[arg-type]
        return all(_same(getattr(self, name), getattr(other, name)) for name in names)

    __hash__ = None  # type: ignore[assignment]


class ArrayTuple:
    """Base of the results that are named tuples of arrays."""

    __slots__ = ()

    def to_dict(self) -> dict[str, npt.NDArray[Any]]:
        """Return names and arrays."""
        return {name: getattr(self, name) for name in self._names()}

    def to_table(self) -> Table:
        """Return columns with one row per entry of the arrays, vectors as three of them."""
        return columns_of(self.to_dict())

    def _names(self) -> tuple[str, ...]:
        names: tuple[str, ...] = getattr(self, "_fields")
        return names

    def _repr_html_(self) -> str:
        shapes = {name: " × ".join(map(str, array.shape)) for name, array in self.to_dict().items()}
        return _html(self, shapes)

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return False
        return all(_same(getattr(self, name), getattr(other, name)) for name in self._names())

    def __ne__(self, other: object) -> bool:
        return not self == other


def table(records: Sequence[Record]) -> Table:
    """Return columns with one row per record, of its names and numbers."""
    rows = [_numbers(record) for record in records]
    columns = dict.fromkeys(name for row in rows for name in row)
    return {name: _column([row.get(name) for row in rows]) for name in columns}


def _column(values: list[Any]) -> npt.NDArray[Any]:
    """Return a column; numbers that are missing are NaN, and words empty."""
    known = [value for value in values if value is not None]
    if known and all(isinstance(value, str) for value in known):
        return np.array([value or "" for value in values], dtype=str)
    if len(known) == len(values):
        return np.array(values)
    return np.array([number_or_nan(value) for value in values], dtype=np.float64)


def columns_of(arrays: dict[str, npt.NDArray[Any]]) -> Table:
    """Return arrays as columns, vectors as three of them."""
    columns: Table = {}
    for name, array in arrays.items():
        if array.ndim == 1:
            columns[name] = array
        else:
            axes = "xyz" if array.shape[1] == 3 else range(array.shape[1])
            columns |= {f"{name}.{axis}": array[:, i] for i, axis in enumerate(axes)}
    return columns


def _numbers(record: Record) -> dict[str, Any]:
    """Return the names and numbers of a record, those of nested records by dotted names."""
    found: dict[str, Any] = {}
    for name, value in vars(record).items():
        if isinstance(value, Record):
            found |= {f"{name}.{inner}": number for inner, number in _numbers(value).items()}
        elif isinstance(value, tuple) and len(value) in (2, 3) and all(isinstance(x, (int, float)) for x in value):
            axes = PARTS.get(name, ("lower", "upper")) if len(value) == 2 else ("x", "y", "z")
            found |= {f"{name}.{axis}": number for axis, number in zip(axes, value)}
        elif value is None or isinstance(value, (bool, int, float, str)):
            found[name] = value
    return found


def _html(result: object, cells: dict[str, str]) -> str:
    """Return a table of names and values."""
    rows = [f"<tr><th>{name}</th><td>{html.escape(value)}</td></tr>" for name, value in cells.items()]
    return f"<table><caption>{html.escape(type(result).__name__)}</caption><tbody>{''.join(rows)}</tbody></table>"


def _plain(value: Any) -> Any:
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if isinstance(value, tuple) and value and isinstance(value[0], Record):
        return [item.to_dict() for item in value]
    return value


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b)
    return bool(a == b)


def number_or_nan(value: float | None) -> float:
    """Return a number; NaN where it is undefined."""
    return float("nan") if value is None else value


def shown(value: float | None) -> str:
    """Return a number in a few digits."""
    return "unknown" if value is None else f"{value:.4g}"


def cell(value: Any) -> str:
    """Return a value as a cell of a table shows it."""
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
