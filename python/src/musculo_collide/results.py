"""Results as small immutable classes.

Each prints what a person wants to know, compares by value, can be pickled, and has ``to_dict()``.
"""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from ._record import Record, Table, Vector, cell, number_or_nan, shown, table


@dataclass(frozen=True, eq=False)
class Measures(Record):
    """What two bodies share, or one separate contact region of it. Lengths in the scene's unit."""

    volume: float | None
    """Volume of the intersection; ``None`` where a body has no inside."""
    centroid: Vector | None
    """Center of mass of the intersection."""
    area_of_a_inside_b: float | None
    """Area of a's surface strictly inside b."""
    area_of_b_inside_a: float | None
    """Area of b's surface strictly inside a."""
    touching_area: float
    """Area in which faces of opposite normals coincide: the bodies touch from outside."""
    flush_area: float
    """Area in which faces of equal normals coincide."""
    curve_length: float
    """Length of the curve in which the surfaces cross."""
    curve_loops: int
    """Closed loops of that curve."""
    curve_arcs: int
    """Open arcs of that curve, which end at the border of an open surface."""
    normal: Vector
    """Area-weighted mean normal of a's surface inside b; zero where the normals cancel."""
    inside_vertices: tuple[int, int]
    """Vertices of a inside b, and of b inside a."""


@dataclass(frozen=True, eq=False)
class Overlap(Record):
    """Overlap of two bodies: of the whole, and of each separate region, the largest first."""

    total: Measures
    regions: tuple[Measures, ...]
    has_ties: bool
    """True if the surfaces touch without crossing, or coincide, somewhere."""
    no_inside: tuple[str | None, str | None]
    """Reasons for which a, and b, have no inside."""
    covers_twice: tuple[bool, bool]
    """True if a, or b, covers some place more than once."""


@dataclass(frozen=True, eq=False)
class Depth(Record):
    """Certified bracket on the greatest depth of one surface inside the other body."""

    lower: float
    """A depth that is attained, at ``point``."""
    upper: float
    """A depth that no point of the surface exceeds."""
    point: Vector
    """The deepest point found."""
    face: int
    """The face that holds it."""
    foot: Vector
    """The nearest point of the other surface."""
    is_narrow: bool
    """False if the search ended before the bracket was as narrow as asked."""


@dataclass(frozen=True, eq=False)
class NearVertices(Record):
    """Vertices of one body that are inside the other or within the margin, ascending."""

    inside_count: int | None
    """Number of vertices inside; ``None`` where the other body has no inside."""
    no_inside: str | None
    """The reason for that."""
    vertices: npt.NDArray[np.uint32]
    """Numbers of the vertices (k)."""
    gaps: npt.NDArray[np.float64]
    """Signed distances to the other surface, negative inside (k)."""
    feet: npt.NDArray[np.float64]
    """Closest points of the other surface (k × 3)."""
    faces: npt.NDArray[np.uint32]
    """Faces that hold them (k)."""
    normals: npt.NDArray[np.float64]
    """Unit normals out of the other surface (k × 3)."""


@dataclass(frozen=True, eq=False, repr=False)
class Pair(Record):
    """Two bodies that overlap, or are within the margin of each other."""

    a: str
    b: str
    overlaps: bool
    """True if faces cross or a vertex is inside. Surfaces that only touch do not overlap."""
    coincidence: str | None
    """Way in which both bodies are the same, where they are."""
    overlap: Overlap | None
    """Volume, areas and curve, where the surfaces share some."""
    depth_of_a_in_b: Depth | None
    """Greatest depth of a's surface inside b."""
    depth_of_b_in_a: Depth | None
    """Greatest depth of b's surface inside a."""
    near_area_of_a: tuple[float, float] | None
    """Bounds on the area of a within the margin of b, for pairs that do not overlap."""
    near_area_of_b: tuple[float, float] | None
    """Bounds on the area of b within the margin of a."""
    max_vertex_depth: float
    """Depth of the deepest vertex. It depends on the mesh: ``depth`` does not."""
    min_gap: float | None
    """Smallest signed distance of a vertex, negative inside."""
    distance: float | None
    """Distance of the surfaces; 0 where they meet, ``None`` beyond the margin."""
    crossing_faces: npt.NDArray[np.uint32]
    """Faces of a and of b that properly cross (k × 2)."""
    vertices_of_a: NearVertices
    """Vertices of a against b."""
    vertices_of_b: NearVertices
    """Vertices of b against a."""

    @property
    def volume(self) -> float | None:
        """Volume that both bodies share; ``None`` where one has no inside."""
        return self.overlap.total.volume if self.overlap else None

    @property
    def depth(self) -> tuple[float, float] | None:
        """Certified bracket on the larger of both depths.

        ``None`` where nothing is inside, and where one of both is undefined: it may be the larger one.
        """
        if self._has_undefined_depth():
            return None
        depths = [depth for depth in (self.depth_of_a_in_b, self.depth_of_b_in_a) if depth]
        if not depths:
            return None
        return max(depth.lower for depth in depths), max(depth.upper for depth in depths)

    def _has_undefined_depth(self) -> bool:
        """Return whether the depth in one body is undefined although places are inside it."""
        for side, vertices in enumerate((self.vertices_of_b, self.vertices_of_a)):
            # Nothing is inside a surface with open edges, but for what it surrounds.
            if vertices.inside_count is None:
                if (vertices.gaps < 0.0).any():
                    return True
            elif self.overlap and (self.overlap.covers_twice[side] or self.overlap.no_inside[side]):
                return True
        return False

    def __repr__(self) -> str:
        return f"<Pair {self.a} × {self.b}: {self.summary()}>"

    def to_table(self) -> Table:
        """Return columns with one row, those of :meth:`Pairs.to_table`."""
        return Pairs([self]).to_table()

    def summary(self) -> str:
        """Return a line on what the pair has in common."""
        if not self.overlaps:
            return "touching" if self.distance == 0.0 else f"apart by {shown(self.distance)}"
        parts = ["overlap"]
        if self.depth:
            parts.append(f"depth {shown(self.depth[0])}")
        if self.volume is not None:
            parts.append(f"volume {shown(self.volume)}")
        return ", ".join(parts)

    def numbers(self) -> dict[str, float]:
        """Return all numbers of the pair by the names that the program's JSON has."""
        record: dict[str, Any] = {
            "overlaps": self.overlaps,
            "depth_of_a_in_b": self.depth_of_a_in_b,
            "depth_of_b_in_a": self.depth_of_b_in_a,
            "max_vertex_depth": self.max_vertex_depth,
            "min_gap": self.min_gap,
            "distance": self.distance,
            "vertices_of_a_inside_b": self.vertices_of_a.inside_count,
            "vertices_of_b_inside_a": self.vertices_of_b.inside_count,
            "crossing_face_pairs": len(self.crossing_faces),
            "nearest_vertex.vertex": self._nearest_vertex(),
        }
        if self.overlap:
            record["overlap"] = self.overlap.total
            record["overlap.has_ties"] = self.overlap.has_ties
        for key, area in (("near_area_of_a", self.near_area_of_a), ("near_area_of_b", self.near_area_of_b)):
            if area:
                record[f"{key}.lower"], record[f"{key}.upper"] = area

        numbers: dict[str, float] = {}
        for key, value in record.items():
            if isinstance(value, Record):
                parts = {f"{key}.{name}": part for name, part in value.to_dict().items()}
            else:
                parts = {key: value}
            numbers |= {name: float(part) for name, part in parts.items() if isinstance(part, (bool, int, float))}
        return numbers

    def _nearest_vertex(self) -> int | None:
        """Return the vertex of the smallest gap, of a where both bodies have one."""
        nearest, gap = None, float("inf")
        for side in (self.vertices_of_a, self.vertices_of_b):
            if len(side.gaps) and side.gaps.min() < gap:
                gap = side.gaps.min()
                nearest = int(side.vertices[side.gaps.argmin()])
        return nearest


class Pairs(Sequence[Pair]):
    """Pairs of bodies in one state, in the order of the bodies."""

    def __init__(self, pairs: Sequence[Pair]) -> None:
        self._pairs = tuple(pairs)

    @overload
    def __getitem__(self, key: int) -> Pair: ...
    @overload
    def __getitem__(self, key: slice) -> Pairs: ...
    @overload
    def __getitem__(self, key: tuple[str, str]) -> Pair: ...
    def __getitem__(self, key: int | slice | tuple[str, str]) -> Pair | Pairs:
        """Return a pair by number or by both names in whichever order."""
        if isinstance(key, slice):
            return Pairs(self._pairs[key])
        if not isinstance(key, tuple):
            return self._pairs[key]
        for pair in self._pairs:
            if key in ((pair.a, pair.b), (pair.b, pair.a)):
                return pair
        raise KeyError(key)

    def __len__(self) -> int:
        return len(self._pairs)

    def __iter__(self) -> Iterator[Pair]:
        return iter(self._pairs)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pairs) and self._pairs == other._pairs

    __hash__ = None  # type: ignore[assignment]

    @property
    def overlapping(self) -> Pairs:
        """The pairs that overlap."""
        return Pairs([pair for pair in self if pair.overlaps])

    def to_dict(self) -> list[dict[str, Any]]:
        """Return the pairs as dictionaries."""
        return [pair.to_dict() for pair in self]

    def to_table(self) -> Table:
        """Return columns that ``pandas.DataFrame`` or ``polars.DataFrame`` take as they are.

        What is undefined is NaN.
        """
        rows = [_row(pair) for pair in self]
        kinds: dict[str, Any] = {"a": str, "b": str, "overlaps": bool, "crossing_face_pairs": np.int64}
        columns = list(_row(None))
        return {
            name: np.array([row[name] for row in rows], dtype=kinds.get(name, np.float64))
            for name in columns
        }

    def to_long_table(self, subject: str = "", *, frame: int = 0, time: float | None = None) -> Table:
        """Return one row per number of every pair: subject, frame, time, a, b, measure, value.

        Rows and names are those of the program's ``check --table``; tables of several subjects and
        frames may be joined. Truth values are 0 or 1, and what is undefined has no row.
        """
        rows = [
            (pair.a, pair.b, measure, value) for pair in self for measure, value in sorted(pair.numbers().items())
        ]
        count = len(rows)
        return {
            "subject": np.array([subject] * count, dtype=str),
            "frame": np.full(count, frame),
            "time": np.full(count, number_or_nan(time)),
            "a": np.array([row[0] for row in rows], dtype=str),
            "b": np.array([row[1] for row in rows], dtype=str),
            "measure": np.array([row[2] for row in rows], dtype=str),
            "value": np.array([row[3] for row in rows], dtype=np.float64),
        }

    def __repr__(self) -> str:
        lines = [f"{len(self.overlapping)} of {len(self)} pairs overlap"]
        lines += [f"  {pair.a} × {pair.b}: {pair.summary()}" for pair in self]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        table = self.to_table()
        head = "".join(f"<th>{name}</th>" for name in table)
        rows = []
        for values in zip(*table.values()):
            cells = "".join(f"<td>{html.escape(cell(value))}</td>" for value in values)
            rows.append(f"<tr>{cells}</tr>")
        return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _row(pair: Pair | None) -> dict[str, Any]:
    """Return one row of the table; for ``None`` one without values."""
    total = pair.overlap.total if pair and pair.overlap else None
    depth = pair.depth if pair else None
    return {
        "a": pair.a if pair else "",
        "b": pair.b if pair else "",
        "overlaps": bool(pair and pair.overlaps),
        "volume": number_or_nan(total.volume if total else None),
        "depth_lower": number_or_nan(depth[0] if depth else None),
        "depth_upper": number_or_nan(depth[1] if depth else None),
        "area_of_a_inside_b": number_or_nan(total.area_of_a_inside_b if total else None),
        "area_of_b_inside_a": number_or_nan(total.area_of_b_inside_a if total else None),
        "curve_length": number_or_nan(total.curve_length if total else None),
        "distance": number_or_nan(pair.distance if pair else None),
        "max_vertex_depth": pair.max_vertex_depth if pair else 0.0,
        "crossing_face_pairs": len(pair.crossing_faces) if pair else 0,
    }


@dataclass(frozen=True, eq=False, repr=False)
class BodyChange(Record):
    """Displacement and deformation of one body."""

    name: str
    displacements: npt.NDArray[np.float64]
    """Displacement of each vertex (n × 3)."""
    moved: int
    """Vertices that moved at all."""
    max_displacement: float
    strain: float
    """Largest change of an edge's length over its length, or over the mean edge where that is longer."""
    volume_ratio: float | None
    """Volume over the volume at the start; ``None`` where the body has no inside."""
    flipped_faces: int
    self_crossings: tuple[int, int]
    """Crossing pairs of the body's own faces, at the start and now."""

    def __repr__(self) -> str:
        return f"<BodyChange {self.name}: {self.moved} vertices by up to {self.max_displacement:.4g}>"


@dataclass(frozen=True, eq=False)
class Remaining(Record):
    """Pair that still overlaps."""

    a: str
    b: str
    depth: tuple[float, float]
    """Certified bracket on the depth."""
    crossing_faces: int
    at_first: bool
    """True if the pair overlapped at the start."""
    reason: str


@dataclass(frozen=True, eq=False)
class ShortGap(Record):
    """Pair that is not proved to keep the gap."""

    a: str
    b: str
    distance: tuple[float, float]
    """Certified bracket on the distance of the surfaces; 0 where they overlap."""
    reason: str


@dataclass(frozen=True, eq=False)
class BrokenLimit(Record):
    """Body that the best state would have brought beyond its limits."""

    name: str
    volume_change: float
    """Relative change of its volume."""
    max_displacement: float
    """Largest displacement of a vertex."""
    displacement_limit: float
    """Largest displacement that is within limits."""
    strain: float
    """Its largest strain, as that of a :class:`BodyChange`."""
    flipped_faces: int
    flat_corners: int
    """Corners of the elements of a volume mesh that are flat."""
    self_crossings: int
    """Crossing pairs of its own faces, beyond their number at the start."""


@dataclass(frozen=True, eq=False)
class TiedVertices(Record):
    """Vertices of a tie."""

    a: str
    """Body whose vertices are tied."""
    b: str
    """Body that they keep their place to."""
    tied: int
    crossing: int
    """Vertices within the distance that are not held, since they were in the other body or crossed it."""
    loose: int
    """Vertices within the distance that are not held, since faces at them would turn over."""
    distance: float
    """Distance of the tie."""
    max_distance: float
    """Largest distance of a vertex that is held from its place, in the end: more than that of the tie where bodies have moved
    apart since the first state without any push."""


@dataclass(frozen=True, eq=False, repr=False)
class Resolution(Record):
    """Result of overlap removal."""

    resolved: bool
    rounds: int
    final_round: int
    """Round whose state was kept."""
    is_continued: bool
    """True if bodies come from where the last state displaced them to."""
    before: Pairs
    after: Pairs
    bodies: tuple[BodyChange, ...]
    remaining: tuple[Remaining, ...]
    gap: float
    """Distance between surfaces that was asked for; with 0 none is examined."""
    short_gaps: tuple[ShortGap, ...]
    """Pairs that are not proved to keep it, the nearest first."""
    broken_limits: tuple[BrokenLimit, ...]
    """Bodies that the best state brings beyond their limits: the scene then has an earlier one."""
    ties: tuple[TiedVertices, ...]
    """Vertices that ties hold, and those that they do not."""
    self_overlaps: tuple[str, ...]
    """Bodies that were to be uncrossed and still cross themselves."""

    def to_table(self) -> Table:
        """Return columns with one row per body."""
        return table(self.bodies)

    def __repr__(self) -> str:
        before, after = len(self.before.overlapping), len(self.after.overlapping)
        state = "resolved" if self.resolved else "not resolved"
        return f"<Resolution: {state}, {before} overlapping pairs before, {after} after {self.rounds} rounds>"
