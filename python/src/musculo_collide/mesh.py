"""Mesh files, and meshes of other packages."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _arrays, _checks, _native
from ._errors import InputTypeError
from ._record import ArrayTuple, Table

if TYPE_CHECKING:
    import trimesh


class _Mesh(NamedTuple):
    vertices: npt.NDArray[np.float64]
    """Positions (n × 3)."""
    faces: npt.NDArray[np.uint32]
    """Numbers of the corners (m × 3)."""


class Mesh(ArrayTuple, _Mesh):
    """Triangle mesh."""

    __slots__ = ()

    def to_table(self) -> Table:
        """Return columns with one row per vertex."""
        x, y, z = self.vertices.T
        return {"x": x, "y": y, "z": z}


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a mesh file, with a warning where it holds more than a mesh.

    Formats are PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH and INP; of volume meshes, the surface is read.
    """
    return Mesh(*_native.read_mesh(_checks.path(path)))


def write_mesh(
    path: str | os.PathLike[str], vertices: npt.ArrayLike, faces: npt.ArrayLike
) -> None:
    """Write a mesh as PLY, OBJ, OFF, STL or VTP, by the path's extension."""
    x = _arrays.points(vertices, "vertices")
    _native.write_mesh(_checks.path(path), x, _arrays.faces(faces, "faces"))


def from_trimesh(mesh: trimesh.Trimesh) -> Mesh:
    """Return the vertices and faces of a trimesh mesh."""
    if not (hasattr(mesh, "vertices") and hasattr(mesh, "faces")):
        raise InputTypeError(f"a trimesh mesh has vertices and faces, {type(mesh).__name__} has not")
    corners = _arrays.faces(np.asarray(mesh.faces), "faces")
    return Mesh(_arrays.points(np.asarray(mesh.vertices), "vertices"), corners.astype(np.uint32))


def to_trimesh(mesh: Mesh | tuple[npt.ArrayLike, npt.ArrayLike]) -> trimesh.Trimesh:
    """Return a trimesh mesh of the same vertices and faces, in the same order."""
    import trimesh

    vertices, faces = _checks.instance(mesh, tuple, "a mesh", "vertices and faces")
    return trimesh.Trimesh(vertices, faces, process=False)
