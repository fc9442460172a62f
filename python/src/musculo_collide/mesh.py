"""Mesh files, and meshes of other packages."""

from __future__ import annotations

import os
from collections.abc import Iterable
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
    """Triangle mesh: vertices and faces, and what the file that it was read from says of them."""

    space: str | None = None
    """Directions of the axes, ``"LPS"`` or ``"RAS"``, where a file states them as 3D Slicer does.

    Meshes in different spaces do not belong into one scene: x and y have the other sign.
    """
    rigid: bool = False
    """True where a model of FEBio or Abaqus has it rigid: by its materials, or by the types of its elements."""

    def to_table(self) -> Table:
        """Return columns with one row per vertex."""
        x, y, z = self.vertices.T
        return {"x": x, "y": y, "z": z}


def read_mesh(path: str | os.PathLike[str], *, parts: Iterable[str] = ()) -> Mesh:
    """Read a mesh file, with a warning where it holds more than a mesh.

    ``space`` of the mesh is what the file states, ``None`` where it states nothing; vertices are as the
    file has them. Formats are PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH, INP and FEB; of volume meshes, the surface is
    read. Of a model of FEBio or Abaqus, ``parts`` are the names of those that are the mesh; without names it is its only
    one.
    """
    read = _native.read_mesh(_checks.path(path), _checks.names(parts, "parts"))
    vertices, faces, space, rigid = read
    mesh = Mesh(vertices, faces)
    mesh.space, mesh.rigid = space, rigid
    return mesh


def write_mesh(
    path: str | os.PathLike[str],
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    *,
    space: str | None = None,
) -> None:
    """Write a mesh as PLY, OBJ, OFF, STL or VTP, by the path's extension.

    ``space`` is ``"LPS"`` or ``"RAS"`` where the file is to state it. 3D Slicer takes files that state none
    for LPS.
    """
    x = _arrays.points(vertices, "vertices")
    if space is not None:
        space = _checks.instance(space, str, "space", "'LPS' or 'RAS'")
    _native.write_mesh(_checks.path(path), x, _arrays.faces(faces, "faces"), space)


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
