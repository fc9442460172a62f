"""First contacts of bodies during a step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._record import Record, Table


@dataclass(frozen=True, eq=False)
class SweptContacts(Record):
    """First contacts of two bodies during a step, by time."""

    times: npt.NDArray[np.float64]
    """Times in 0 … 1 before which no contact begins (k). Never late."""
    latest: npt.NDArray[np.float64]
    """Ends of the intervals in which the contacts begin (k)."""
    normals: npt.NDArray[np.float64]
    """Unit normals (k × 3)."""
    edge_edge: npt.NDArray[np.bool_]
    """True for two edges, false for a vertex and a face (k)."""
    certain: npt.NDArray[np.bool_]
    """True if the contact is proven, rather than only not excluded by rounding (k)."""
    at_start: npt.NDArray[np.bool_]
    """True if it may have been there at the start (k)."""


@dataclass(frozen=True, eq=False, repr=False)
class SweptPair(Record):
    """Two bodies that meet during a step."""

    a: str
    b: str
    contacts: SweptContacts

    @property
    def first_time(self) -> float:
        """Time of the first contact."""
        return float(self.contacts.times[0])

    def __repr__(self) -> str:
        return f"<SweptPair {self.a} × {self.b}: first contact at {self.first_time:.6g}>"


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Record):
    """First contacts of a step."""

    largest_free_step: float
    """Share of the step before which no contact begins: 1 where nothing meets. Never too large."""
    candidates: int
    """Pairs of primitives that were queried."""
    pairs: tuple[SweptPair, ...]

    def to_table(self) -> Table:
        """Return columns with one row per contact, pair after pair."""
        counts = np.array([len(pair.contacts.times) for pair in self.pairs], dtype=np.int64)
        bodies = {key: np.array([getattr(pair, key) for pair in self.pairs], dtype=str) for key in ("a", "b")}
        names = {key: np.repeat(column, counts) for key, column in bodies.items()}

        # Without pairs, the columns are those of no contacts.
        parts = [pair.contacts.to_table() for pair in self.pairs] or [_no_contacts().to_table()]
        return names | {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}

    def __repr__(self) -> str:
        return f"<Sweep: free up to {self.largest_free_step:.6g}, {len(self.pairs)} pairs meet>"


def _no_contacts() -> SweptContacts:
    """Return no contacts, whose table has all columns."""
    numbers, flags = np.empty(0), np.empty(0, dtype=np.bool_)
    return SweptContacts(
        times=numbers, latest=numbers, normals=np.empty((0, 3)), edge_edge=flags, certain=flags, at_start=flags
    )
