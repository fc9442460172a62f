"""Accessor ``mesh.musculo`` of PyVista surfaces. PyVista imports this module by its entry point.

>>> femur.musculo.check(vastus, margin=1.0)        # doctest: +SKIP
>>> femur.musculo.depth_in(vastus).plot()          # doctest: +SKIP
"""

from __future__ import annotations

import numpy as np
import pyvista as pv

from . import results
from .mesh import Mesh
from .scene import Scene


def mesh_of(surface: pv.PolyData) -> Mesh:
    """Return the vertices and triangles of a PyVista surface."""
    triangles = surface if surface.is_all_triangles else surface.triangulate()
    faces = np.asarray(triangles.faces).reshape(-1, 4)[:, 1:]
    return Mesh(np.asarray(triangles.points, dtype=np.float64), faces.astype(np.uint32))


@pv.register_dataset_accessor("musculo", pv.PolyData)
class Accessor:
    """Questions about one surface and another."""

    def __init__(self, surface: pv.PolyData) -> None:
        self._surface = surface

    def check(self, other: pv.PolyData, margin: float = 0.0) -> results.Pair | None:
        """Return what both surfaces share; ``None`` where they are farther apart than the margin."""
        scene = Scene()
        for name, surface in (("a", self._surface), ("b", other)):
            mesh = mesh_of(surface)
            scene.add(name, mesh.vertices, mesh.faces)
        pairs = scene.check(margin)
        return pairs[0] if len(pairs) else None

    def depth_in(self, other: pv.PolyData, margin: float = 0.0) -> pv.PolyData:
        """Return the surface with the array ``depth``: of each vertex in the other body."""
        colored = self._surface.copy()
        depth = np.zeros(colored.n_points)
        pair = self.check(other, margin)
        if pair is not None:
            depth[pair.vertices_of_a.vertices] = np.maximum(-pair.vertices_of_a.gaps, 0.0)
        colored.point_data["depth"] = depth
        return colored
