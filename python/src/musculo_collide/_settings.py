"""Settings of native calls, which read them by their names."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ResolveSettings:
    """Settings of :meth:`Scene.resolve`."""

    smoothing: float
    tolerance: float | None
    gap: float
    max_rounds: int
    max_volume_change: float
    max_strain: float
    max_displacement: float
    keep_going: bool


@dataclass(frozen=True)
class ResolveConditions:
    """Conditions of :meth:`Scene.resolve` by the names of bodies."""

    fixed: list[tuple[str, list[int]]]
    """Vertices that stay."""
    ties: list[tuple[str, str, float]]
    """Pairs that are attached, with their distances."""
    stiffnesses: list[tuple[str, float]]
    uncrossed: list[str]
    """Bodies whose parts are taken out of each other."""


@dataclass(frozen=True)
class StepSettings:
    """Settings of :meth:`ContactStep.correct`."""

    h: float
    depth_tolerance: float
    max_rounds: int
    iterations: int
    swept: bool
