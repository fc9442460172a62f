"""Meshes of other packages, where these are installed."""

import numpy as np
import pytest
from conftest import box

from musculo_collide import InputError, Scene, from_trimesh, to_trimesh


def test_meshes_go_to_trimesh_and_back():
    pytest.importorskip("trimesh")
    mesh = box((0, 0, 0), (1, 2, 3))
    other = to_trimesh(mesh)
    assert other.is_watertight and other.volume == pytest.approx(6)
    again = from_trimesh(other)
    assert np.array_equal(again.vertices, mesh.vertices) and np.array_equal(again.faces, mesh.faces)
    assert again.vertices.dtype == np.float64 and again.faces.dtype == np.uint32


def test_pyvista_has_the_accessor_and_colors():
    pv = pytest.importorskip("pyvista")
    a, b = (
        pv.PolyData.from_regular_faces(mesh.vertices, mesh.faces.astype(np.int64))
        for mesh in (box((0, 0, 0), (10, 10, 10)), box((8, 1, -1), (20, 9, 11)))
    )
    from musculo_collide import pyvista  # the entry point imports it where PyVista finds it

    assert pyvista.Accessor is not None
    assert a.musculo.check(b).volume == pytest.approx(160)
    assert a.musculo.check(pv.Sphere(center=(100, 0, 0))) is None
    needle = pv.PolyData.from_regular_faces(*map(np.asarray, box((-5, 4, 4), (3, 5, 5))))
    colored = needle.musculo.depth_in(a)
    assert colored is not needle and colored.n_points == needle.n_points
    expected = np.where(needle.points[:, 0] > 0, 3.0, 0.0)
    assert colored.point_data["depth"] == pytest.approx(expected)
    assert "depth" not in needle.point_data
    near = needle.musculo.depth_in(a, margin=6.0)
    assert near.point_data["depth"] == pytest.approx(expected)

    # Polygons are fanned; faces go to a scene as PyVista has them.
    assert pv.Cube().musculo.check(pv.Cube(center=(0.75, 0, 0))).volume == pytest.approx(0.25)
    scene = Scene()
    scene.add("a", a.points, a.faces)
    assert np.array_equal(scene.faces("a"), a.regular_faces)
    with pytest.raises(InputError, match="m × 3"):
        scene.add("quads", pv.Cube().points, pv.Cube().faces)


def test_pandas_takes_tables(two_boxes):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(two_boxes.check().to_long_table("p"))
    assert frame.pivot_table("value", ["a", "b"], "measure").loc[("a", "b"), "overlap.volume"] == pytest.approx(160)


def test_surfaces_of_vtk_go_to_a_scene_as_in_3d_slicer():
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    source = vtk.vtkSphereSource()
    source.Update()
    surface = source.GetOutput()
    scene = Scene()
    vertices = vtk_to_numpy(surface.GetPoints().GetData())
    scene.add("segment", vertices, vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3))
    assert np.array_equal(scene.vertices("segment"), vertices.astype(float))
    assert len(scene.faces("segment")) == surface.GetNumberOfPolys()
