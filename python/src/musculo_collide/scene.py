"""Scenes of named bodies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _from_native, _native, motion, results
from ._checks import Progress
from ._errors import InputError
from ._settings import ResolveConditions, ResolveSettings
from .joint import Cartilage, JointContact, surface_contact_from
from .motion import Motion, placement
from .sweep import Sweep

SMOOTHING_IN_EDGES = 1.5
"""Smoothing length of overlap removal, in mean edges of the soft bodies, where none is given."""


class Scene(_native.Scene):
    """Bodies that may touch each other, all in one length unit.

    >>> scene = Scene()
    >>> scene.add("bone", [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]],
    ...           [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], rigid=True)
    >>> scene.add("muscle", [[1, 1, 1], [10, 1, 1], [1, 10, 1], [1, 1, 10]],
    ...           [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> scene.check()
    1 of 1 pairs overlap
      bone × muscle: overlap, depth 1.732, volume 36
    """

    def __init__(self) -> None:
        """Begin without bodies."""

    def add(
        self,
        name: str,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        rigid: bool = False,
        open: bool = False,
    ) -> None:
        """Add a body at ``vertices`` (n × 3) with ``faces`` (m × 3, numbers of vertices).

        A rigid body moves as one; nothing is ever inside a body that is declared open.
        """
        _checks.name(name)
        if rigid and open:
            raise InputError(f"body {name!r}: a sheet cannot be rigid")
        x = _arrays.points(vertices, f"vertices of {name!r}")
        corners = _arrays.faces(faces, f"faces of {name!r}")
        self._add(name, "rigid" if rigid else "open" if open else "deformable", x, corners)

    @property
    def names(self) -> list[str]:
        """Names of the bodies, in the order they were added."""
        return self._names()

    def __len__(self) -> int:
        return len(self._names())

    def __contains__(self, name: object) -> bool:
        return name in self._names()

    def is_rigid(self, name: str) -> bool:
        """Return true if a body moves as one."""
        return self._kind(_checks.name(name)) == "rigid"

    def vertices(self, name: str) -> npt.NDArray[np.float64]:
        """Return a copy of a body's present positions (n × 3)."""
        return self._vertices(_checks.name(name))

    def faces(self, name: str) -> npt.NDArray[np.uint32]:
        """Return a copy of a body's faces (m × 3)."""
        return self._faces(_checks.name(name))

    def move(self, name: str, vertices: npt.ArrayLike) -> None:
        """Move a body's vertices to new positions (n × 3)."""
        self._move(_checks.name(name), _arrays.points(vertices, f"vertices of {name!r}"))

    def pose(self, name: str, matrix: npt.ArrayLike) -> None:
        """Place a rigid body by a 4 × 4 matrix, from where it was added to the world."""
        self._pose(_checks.name(name), placement(name, matrix))

    def particles(self, name: str) -> slice:
        """Return the rows of a body in arrays over all vertices of the scene."""
        return slice(*self._particles(_checks.name(name)))

    def particle_positions(self) -> npt.NDArray[np.float64]:
        """Return a copy of the present positions of all bodies, one after the other (n × 3)."""
        return np.vstack([np.empty((0, 3)), *(self._vertices(name) for name in self.names)])

    def ignore(self, a: str, b: str) -> None:
        """Leave a pair out of every result."""
        self._ignore(_checks.name(a), _checks.name(b))

    def check(
        self,
        margin: float = 0.0,
        *,
        measures: bool = True,
        depth_tolerance: float | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> results.Pairs:
        """Find all pairs that overlap or are within ``margin``, exactly.

        ``measures`` adds volume, areas, curve and certified depth; ``depth_tolerance`` is the width
        of the bracket on the depth (1 % of it by default).
        """
        found = self._check(
            _checks.number(margin, "margin"),
            bool(measures),
            _checks.optional_number(depth_tolerance, "depth_tolerance"),
            _checks.threads(threads),
            _checks.progress(progress),
        )
        return _from_native.pairs_from(found)

    def sweep(
        self,
        moves: Mapping[str, Motion],
        *,
        centers: Mapping[str, Sequence[float]] | None = None,
        separation: float = 0.0,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Sweep:
        """Find the first contacts of all vertices, edges and faces while bodies move.

        ``moves`` has the motions by name: positions at the end (n × 3), to which each vertex goes
        on a straight line; for a rigid body a 4 × 4 matrix as of :meth:`pose`, to which it goes on a
        rigid path about its middle, or its point in ``centers``; or a :class:`Turn`. The bodies are
        not moved. No contact is missed, and no time is late.
        """
        return self._swept(moves, False, centers, separation, threads, progress)

    def first_contacts(
        self,
        moves: Mapping[str, Motion],
        *,
        centers: Mapping[str, Sequence[float]] | None = None,
        separation: float = 0.0,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Sweep:
        """Find the first contact of each pair, and nothing after it: how far a joint turns.

        Motions are those of :meth:`sweep`. Pairs that overlap from the start have no first contact:
        theirs is the first of primitives that were apart.
        """
        return self._swept(moves, True, centers, separation, threads, progress)

    def joint_contact(
        self,
        a: str,
        b: str,
        *,
        resolution: float,
        margin: float = 0.0,
        cartilage: Cartilage | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> JointContact:
        """Measure the contact of two surfaces: area, center, gaps, and pressure of cartilage.

        Points with a gap of at most ``margin`` are in contact. Faces are split into cells no larger
        than ``resolution``.
        """
        found = self._joint_contacts(
            [(_checks.name(a), _checks.name(b))],
            _checks.number(margin, "margin"),
            _checks.number(resolution, "resolution"),
            None if cartilage is None else _checks.instance(cartilage, Cartilage, "cartilage"),
            _checks.threads(threads),
            _checks.progress(progress),
        )
        of_a, of_b = (surface_contact_from(side) for side in found[0])
        return JointContact(a, b, of_a, of_b)

    def resolve(
        self,
        *,
        smoothing: float | None = None,
        tolerance: float | None = None,
        gap: float = 0.0,
        fixed: Mapping[str, npt.ArrayLike] | None = None,
        ties: Mapping[tuple[str, str], float] | None = None,
        stiffnesses: Mapping[str, float] | None = None,
        uncross: Iterable[str] = (),
        max_rounds: int = 60,
        max_volume_change: float = 0.01,
        max_strain: float = 3.0,
        max_displacement: float = 3.0,
        keep_going: bool = False,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> results.Resolution:
        """Push bodies apart that overlap: rigid ones stay, soft ones yield.

        Surfaces keep the distance ``gap``, faces and edges included, or the result is not resolved.
        Vertices of ``fixed`` (numbers by body) stay where they are. Bodies of ``ties`` (a distance by
        pair) are attached: parts of their surfaces within the distance of each other keep their place,
        and their pair needs no gap. Bodies share an overlap in inverse proportion to their
        ``stiffnesses``, from 1e-9 to 1e9, 1 for those not named. Parts of the bodies of ``uncross`` are taken out of each
        other. What :meth:`ignore` names is not pushed apart.

        Pushes fade over the length ``smoothing`` along a surface. A state that changes the volume of a
        soft body by more than ``max_volume_change`` (relative), an edge by more than ``max_strain``
        (relative to its length, or to the mean edge where that is longer), moves a vertex by more than
        ``max_displacement`` (in depths of the deepest overlap, the smoothing length at least), turns a face over
        or makes a body cross itself anew is not taken, unless ``keep_going``. The scene then has the new positions; after an
        exception it has the old ones.
        """
        held = []
        for name, given in _checks.mapping(fixed or {}, "fixed").items():
            held.append((_checks.name(name), _arrays.indices(given, f"fixed vertices of {name!r}")))
        tied = []
        for pair, distance in _checks.mapping(ties or {}, "ties").items():
            tied.append((*_two_names(pair), _checks.number(distance, f"distance of the tie {pair!r}")))
        factors = []
        for name, factor in _checks.mapping(stiffnesses or {}, "stiffnesses").items():
            factors.append((_checks.name(name), _checks.number(factor, f"stiffness of {name!r}")))
        number, observer = _checks.threads(threads), _checks.progress(progress)
        settings = ResolveSettings(
            smoothing=self._smoothing(number) if smoothing is None else _checks.number(smoothing, "smoothing"),
            tolerance=_checks.optional_number(tolerance, "tolerance"),
            gap=_checks.number(gap, "gap"),
            max_rounds=_checks.count(max_rounds, "max_rounds"),
            max_volume_change=_checks.number(max_volume_change, "max_volume_change"),
            max_strain=_checks.number(max_strain, "max_strain"),
            max_displacement=_checks.number(max_displacement, "max_displacement"),
            keep_going=bool(keep_going),
        )
        uncrossed = _checks.names(uncross, "uncross")
        conditions = ResolveConditions(fixed=held, ties=tied, stiffnesses=factors, uncrossed=uncrossed)
        found = self._resolve(settings, conditions, number, observer)
        return _from_native.resolution_from(found)

    def _swept(
        self,
        moves: Mapping[str, Motion],
        first_of_pairs: bool,
        centers: Mapping[str, Sequence[float]] | None,
        separation: float,
        threads: int | None,
        progress: Progress | None,
    ) -> Sweep:
        ways = motion.native(_checks.mapping(moves, "moves"), _checks.mapping(centers or {}, "centers"))
        gap = _checks.number(separation, "separation")
        found = self._sweep(ways, first_of_pairs, gap, _checks.threads(threads), _checks.progress(progress))
        return _from_native.sweep_from(found)

    def _smoothing(self, threads: int | None) -> float:
        """Return the default smoothing length: the depth of the deepest vertex, and some edges."""
        names = [name for name in self.names if not self.is_rigid(name)] or self.names
        total, count = 0.0, 0
        for name in names:
            x, corners = self.vertices(name), self.faces(name)
            for i in range(3):
                edges = x[corners[:, i]] - x[corners[:, i - 1]]
                total += float(np.linalg.norm(edges, axis=1).sum())
                count += len(edges)
        if count == 0:
            raise InputError("the scene has no bodies")
        pairs = self.check(measures=False, threads=threads)
        deepest = max((pair.max_vertex_depth for pair in pairs), default=0.0)
        return max(deepest, SMOOTHING_IN_EDGES * total / count)

    def __repr__(self) -> str:
        return f"<Scene of {len(self)} bodies: {', '.join(self.names)}>"


def _two_names(pair: object) -> tuple[str, str]:
    """Return the names of a pair."""
    if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(name, str) for name in pair)):
        raise InputError(f"a tie is between two names, not {pair!r}")
    return pair
