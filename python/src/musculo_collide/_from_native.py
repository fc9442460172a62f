"""Results of the records that the native module returns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .results import (
    BodyChange,
    BrokenLimit,
    Depth,
    Measures,
    NearVertices,
    Overlap,
    Pair,
    Pairs,
    Remaining,
    Resolution,
    ShortGap,
    TiedVertices,
)
from .sweep import Sweep, SweptContacts, SweptPair


def overlap_from(record: dict[str, Any]) -> Overlap:
    """Return the overlap of a native record."""
    overlap = dict(record)
    overlap["total"] = Measures(**overlap["total"])
    overlap["regions"] = tuple(Measures(**region) for region in overlap["regions"])
    overlap["no_inside"] = tuple(overlap["no_inside"])
    overlap["covers_twice"] = tuple(overlap["covers_twice"])
    return Overlap(**overlap)


def pair_from(record: dict[str, Any]) -> Pair:
    """Return the pair of a native record."""
    record = dict(record)
    if record["overlap"] is not None:
        record["overlap"] = overlap_from(record["overlap"])
    for key in ("depth_of_a_in_b", "depth_of_b_in_a"):
        record[key] = Depth(**record[key]) if record[key] is not None else None
    for key in ("vertices_of_a", "vertices_of_b"):
        record[key] = NearVertices(**record[key])
    return Pair(**record)


def pairs_from(records: Sequence[dict[str, Any]]) -> Pairs:
    """Return the pairs of native records."""
    return Pairs([pair_from(record) for record in records])


def sweep_from(record: dict[str, Any]) -> Sweep:
    """Return the step of a native record."""
    pairs = [
        SweptPair(pair["a"], pair["b"], SweptContacts(**pair["contacts"])) for pair in record["pairs"]
    ]
    return Sweep(record["largest_free_step"], record["candidates"], tuple(pairs))


def resolution_from(record: dict[str, Any]) -> Resolution:
    """Return the resolution of a native record."""
    record = dict(record)
    record["before"] = pairs_from(record["before"])
    record["after"] = pairs_from(record["after"])
    record["bodies"] = tuple(BodyChange(**body) for body in record["bodies"])
    record["remaining"] = tuple(Remaining(**left) for left in record["remaining"])
    record["broken_limits"] = tuple(BrokenLimit(**broken) for broken in record["broken_limits"])
    record["ties"] = tuple(TiedVertices(**tie) for tie in record["ties"])
    record["self_overlaps"] = tuple(record["self_overlaps"])
    record["short_gaps"] = tuple(ShortGap(**short) for short in record["short_gaps"])
    return Resolution(**record)
