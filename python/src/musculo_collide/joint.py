"""Joint contact: area, place, gap and pressure of surfaces in contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _checks
from ._record import Record, Vector


@dataclass(frozen=True)
class Cartilage:
    """Elastic layer that presses back where surfaces overlap (elastic foundation)."""

    youngs_modulus: float
    """Force per area, above 0."""
    poissons_ratio: float
    """Above −1 and below 0.5."""
    thickness: float
    """Thickness of the layer, of both where two are pressed on each other."""
    law: str = "linear"
    """``linear``, or ``logarithmic``: stiffer the more it is compressed."""

    def __post_init__(self) -> None:
        for name in ("youngs_modulus", "poissons_ratio", "thickness"):
            object.__setattr__(self, name, _checks.number(getattr(self, name), name))
        _checks.instance(self.law, str, "law", "a string")


@dataclass(frozen=True, eq=False)
class ContactMeasures(Record):
    """Contact of one surface, or one region of it."""

    area: float
    """Area of the cells whose center is in contact."""
    area_lower: float
    """Area that is certainly in contact."""
    area_upper: float
    """Area that no contact exceeds."""
    center: Vector
    """Center of the area; zero without area."""
    mean_gap: float
    """Mean gap over the area, negative where the surfaces overlap."""
    min_gap: float
    """Smallest gap of a cell center; infinite without area."""
    mean_pressure: float
    max_pressure: float
    force: Vector
    """Sum of pressure over area: the force on this surface."""
    center_of_pressure: Vector
    """Center of the area weighted by pressure; zero without pressure."""


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceContact(Record):
    """Contact of one surface with another."""

    total: ContactMeasures
    regions: tuple[ContactMeasures, ...]
    """The same for each separate region, by falling area."""
    faces: npt.NDArray[np.uint32]
    """Faces in contact, ascending (k)."""
    face_areas: npt.NDArray[np.float64]
    """Their areas in contact (k)."""
    face_gaps: npt.NDArray[np.float64]
    """Mean gaps over these areas (k)."""
    face_pressures: npt.NDArray[np.float64]
    """Mean pressures over these areas (k)."""
    face_regions: npt.NDArray[np.uint32]
    """Their regions (k)."""

    def __repr__(self) -> str:
        return f"<SurfaceContact: area {self.total.area:.4g} in {len(self.regions)} regions>"


@dataclass(frozen=True, eq=False, repr=False)
class JointContact(Record):
    """Contact of two surfaces, each with the other."""

    a: str
    b: str
    of_a: SurfaceContact
    of_b: SurfaceContact

    def __repr__(self) -> str:
        areas = f"area {self.of_a.total.area:.4g} of a, {self.of_b.total.area:.4g} of b"
        return f"<JointContact {self.a} × {self.b}: {areas}>"


def surface_contact_from(record: dict[str, Any]) -> SurfaceContact:
    """Return the contact of a native record."""
    record = dict(record)
    record["total"] = ContactMeasures(**record["total"])
    record["regions"] = tuple(ContactMeasures(**region) for region in record["regions"])
    return SurfaceContact(**record)
