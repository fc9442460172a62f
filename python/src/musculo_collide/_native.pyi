from collections.abc import Callable
from typing import Any, final

import numpy as np
import numpy.typing as npt
from typing_extensions import disjoint_base

from ._settings import ResolveConditions, ResolveSettings, StepSettings
from .joint import Cartilage
from .motion import Placement, Posed, Turn
from .step import Material

__all__ = [
    "Field",
    "Plan",
    "Scene",
    "Step",
    "Surface",
    "__version__",
    "computed_seconds",
    "generate_medial",
    "read_mesh",
    "write_mesh",
]

__version__: str

_Progress = Callable[[float], object] | None

@disjoint_base
class Scene:
    def __new__(cls, *_arguments: Any, **_named: Any) -> Scene: ...
    def _add(
        self, name: str, kind: str, vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]
    ) -> None: ...
    def _names(self) -> list[str]: ...
    def _kind(self, name: str) -> str: ...
    def _vertices(self, name: str) -> npt.NDArray[np.float64]: ...
    def _faces(self, name: str) -> npt.NDArray[np.uint32]: ...
    def _move(self, name: str, vertices: npt.NDArray[np.float64]) -> None: ...
    def _pose(self, name: str, placement: Placement) -> None: ...
    def _particles(self, name: str) -> tuple[int, int]: ...
    def _ignore(self, a: str, b: str) -> None: ...
    def _check(
        self,
        margin: float,
        measures: bool,
        depth_tolerance: float | None,
        threads: int | None,
        progress: _Progress,
    ) -> list[dict[str, Any]]: ...
    def _sweep(
        self,
        moves: list[tuple[str, npt.NDArray[np.float64] | Turn | Posed]],
        first_of_pairs: bool,
        separation: float,
        threads: int | None,
        progress: _Progress,
    ) -> dict[str, Any]: ...
    def _joint_contacts(
        self,
        pairs: list[tuple[str, str]],
        margin: float,
        resolution: float,
        cartilage: Cartilage | None,
        threads: int | None,
        progress: _Progress,
    ) -> list[tuple[dict[str, Any], dict[str, Any]]]: ...
    def _resolve(
        self,
        settings: ResolveSettings,
        conditions: ResolveConditions,
        threads: int | None,
        progress: _Progress,
    ) -> dict[str, Any]: ...

@final
class Plan:
    def __new__(
        cls,
        scene: Scene,
        tolerance: float,
        margin: float,
        max_displacement: float,
        frames: int,
        threads: int | None,
        progress: _Progress,
    ) -> Plan: ...
    def pairs(self) -> list[dict[str, Any]]: ...
    def text(self) -> str: ...
    def detect(self, threads: int | None) -> list[dict[str, Any]]: ...
    def respond(self, clearance: float) -> None: ...

@final
class Step:
    def __new__(cls, scene: Scene, margin: float, tolerance: float, material: Material) -> Step: ...
    def set_material(self, a: str, b: str, material: Material) -> None: ...
    def set_field(self, name: str, field: Field) -> None: ...
    def set_coarse(
        self, name: str, deviation: float | None, threads: int | None, progress: _Progress
    ) -> None: ...
    def set_balls(self, name: str, tolerance: float, threads: int | None, progress: _Progress) -> None: ...
    def move_bone(
        self,
        name: str,
        placement: Placement,
        velocity: tuple[float, float, float],
        spin: tuple[float, float, float],
        about: tuple[float, float, float],
    ) -> None: ...
    def correct(
        self,
        x: npt.NDArray[np.float64],
        v: npt.NDArray[np.float64],
        inverse_mass: npt.NDArray[np.float64],
        accelerations: npt.NDArray[np.float64] | None,
        forces: npt.NDArray[np.float64] | None,
        settings: StepSettings,
        threads: int | None,
    ) -> dict[str, Any]: ...

@final
class Surface:
    def __new__(cls, vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> Surface: ...
    def vertices(self) -> npt.NDArray[np.float64]: ...
    def faces(self) -> npt.NDArray[np.uint32]: ...
    def no_inside(self) -> str | None: ...
    def contains(self, at: npt.NDArray[np.float64], threads: int | None) -> npt.NDArray[np.bool_]: ...
    def signed_distance(
        self, at: npt.NDArray[np.float64], threads: int | None
    ) -> npt.NDArray[np.float64]: ...
    def overlap(self, other: Surface) -> dict[str, Any]: ...
    def depths(self, other: Surface, width: float | None) -> list[dict[str, Any] | None]: ...
    def closest_points(
        self, at: npt.NDArray[np.float64], threads: int | None
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32], npt.NDArray[np.float64]]: ...

@final
class Field:
    @staticmethod
    def build(
        vertices: npt.NDArray[np.float64],
        faces: npt.NDArray[np.int64],
        spacing: float,
        padding: float | None,
        truncation: float | None,
        threads: int | None,
        progress: _Progress,
    ) -> Field: ...
    @staticmethod
    def read(path: str) -> Field: ...
    def write(self, path: str) -> None: ...
    def query(
        self, at: npt.NDArray[np.float64], cubic: bool, gradients: bool, threads: int | None
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None]: ...
    def values(self) -> npt.NDArray[np.float32]: ...
    def grid(self) -> dict[str, Any]: ...
    def report(self) -> dict[str, Any]: ...

def computed_seconds() -> float: ...
def read_mesh(
    path: str, parts: list[str]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32], str | None, bool]: ...
def write_mesh(
    path: str, vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64], space: str | None
) -> None: ...
def generate_medial(
    vertices: npt.NDArray[np.float64],
    faces: npt.NDArray[np.int64],
    balls: int | None,
    tolerance: float | None,
    threads: int | None,
    progress: _Progress,
) -> dict[str, Any]: ...
