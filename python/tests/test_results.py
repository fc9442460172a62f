"""Results as values: equal, pickled, as dictionaries, tables and HTML."""

import copy
import pickle

import numpy as np
import pytest
from conftest import box, sphere

from musculo_collide import Cartilage, ContactStep, DistanceField, Plan, Scene, Surface, from_trimesh, medial
from musculo_collide.results import Pairs, Record


@pytest.fixture
def results(two_boxes):
    layer = Cartilage(youngs_modulus=5.0, poissons_ratio=0.3, thickness=2.0)
    pairs = two_boxes.check(margin=1.0)
    sweep = two_boxes.sweep({"b": two_boxes.vertices("b") - [1.0, 0, 0]})
    joint = two_boxes.joint_contact("a", "b", resolution=1.0, cartilage=layer)
    (detected,) = Plan(two_boxes, tolerance=0.1).detect()
    planned = Plan(two_boxes, tolerance=0.1).pairs[0]
    ball = sphere((0, 0, 0), 10, 24)
    x = two_boxes.particle_positions()
    step = ContactStep(two_boxes, margin=0.5).correct(x, np.zeros_like(x), h=0.01)
    resolution = two_boxes.resolve()
    return [
        pairs,
        pairs[0],
        pairs[0].overlap,
        pairs[0].overlap.total,
        pairs[0].depth_of_a_in_b,
        pairs[0].vertices_of_a,
        sweep,
        sweep.pairs[0].contacts,
        joint,
        joint.of_a,
        joint.of_a.total,
        detected,
        planned,
        resolution,
        resolution.bodies[1],
        medial.generate(*ball, balls=4),
        DistanceField.build(*ball, spacing=1.0).measured_error,
        Surface(*ball).closest_points(ball.vertices + 0.1),
        Surface(*ball).depths(Surface(*box((-1, -1, 5), (1, 1, 8))))[1],
        from_trimesh(ball),
        step,
    ]


def plain(value):
    """Yield all that a nested dictionary holds."""
    nested = value.values() if isinstance(value, dict) else value if isinstance(value, (list, tuple)) else []
    for inner in nested:
        yield inner
        yield from plain(inner)


def test_results_are_values_and_have_a_table_and_html(results):
    for result in results:
        kind = type(result).__name__
        for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
            assert type(again) is type(result) and again == result and not again != result, kind
        assert len(repr(result)) > 10 and result._repr_html_().startswith("<table>"), kind
        if isinstance(result, Record):
            assert set(result.to_dict()) == set(vars(result)), kind
            assert not any(isinstance(value, (Record, Pairs)) for value in plain(result.to_dict())), kind
        table = result.to_table()
        assert table and {column.ndim for column in table.values()} == {1}, kind
        assert len({len(column) for column in table.values()}) == 1, kind


def test_tables_name_both_of_two_values(two_boxes):
    overlap = two_boxes.check()[0].overlap
    total = overlap.total
    assert [total.to_table()[f"inside_vertices.{side}"][0] for side in "ab"] == list(total.inside_vertices)
    assert [overlap.to_table()[f"covers_twice.{side}"][0] for side in "ab"] == list(overlap.covers_twice)
    resolution = two_boxes.resolve()
    columns = resolution.to_table()
    for i, when in enumerate(("before", "after")):
        assert list(columns[f"self_crossings.{when}"]) == [body.self_crossings[i] for body in resolution.bodies]


def test_pairs_are_found_by_number_and_by_both_names(two_boxes):
    pairs = two_boxes.check()
    for key in (0, -1, np.int64(0), ("a", "b"), ("b", "a")):
        assert pairs[key] is pairs._pairs[0]
    assert pairs[:1] == pairs and pairs[1:] == Pairs([])
    for key in (("a", "a"), ("a", "b", "a"), ("a",), ("a", "c")):
        with pytest.raises(KeyError):
            pairs[key]
    for key in ("ab", 1.0, None):
        with pytest.raises(TypeError):
            pairs[key]


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_frames_take_tables_as_they_are(results, package):
    module = pytest.importorskip(package)
    for result in results:
        table = result.to_table()
        frame = module.DataFrame(table)
        assert frame.shape == (len(next(iter(table.values()))), len(table))


def test_tuples_of_arrays_are_values_and_unpacked():
    mesh = box((0, 0, 0), (1, 2, 3))
    vertices, faces = mesh
    assert mesh == box((0, 0, 0), (1, 2, 3)) and mesh != box((0, 0, 0), (1, 2, 4)) and mesh != (vertices, faces)
    assert list(mesh.to_dict()) == ["vertices", "faces"] and mesh.to_dict()["faces"] is faces
    assert list(mesh.to_table()["z"]) == list(vertices[:, 2])
    found = Surface(*mesh).closest_points([[0.5, 0.5, 4.0], [3.0, 1.0, 1.0]])
    assert list(found.to_table()) == ["points.x", "points.y", "points.z", "faces", "distances"]
    assert list(found.to_table()["distances"]) == [1.0, 2.0]
    assert repr(mesh).startswith("Mesh(vertices=array(") and "8 × 3" in mesh._repr_html_()
    with pytest.raises(TypeError, match="unhashable"):
        hash(mesh)


def test_tables_have_a_row_per_thing(results):
    rows = {type(result).__name__: result.to_table() for result in results}
    assert list(rows["NearVertices"]) == [
        "vertices", "gaps", "feet.x", "feet.y", "feet.z", "faces", "normals.x", "normals.y", "normals.z",
    ]  # fmt: skip
    assert rows["Measures"]["volume"] == pytest.approx([160]) and rows["Measures"]["centroid.x"] == pytest.approx([9])
    assert list(rows["Resolution"]["name"]) == ["a", "b"] and rows["Resolution"]["moved"][0] == 0
    assert set(rows["Sweep"]["a"]) == {"a"} and len(rows["Sweep"]["times"]) == len(rows["SweptContacts"]["times"])
    assert len(rows["MedialSurface"]["radius"]) == 4
    assert rows["SurfaceContact"]["face_areas"].sum() == pytest.approx(rows["JointContact"]["of_a.total.area"][0])
    empty = Scene().sweep({}).to_table()
    assert all(len(column) == 0 for column in empty.values())
    kinds = {name: column.dtype.kind for name, column in empty.items()}
    assert kinds == {name: column.dtype.kind for name, column in rows["Sweep"].items()}


def test_names_in_html_are_escaped():
    scene = Scene()
    scene.add("<script>", *box((0, 0, 0), (1, 1, 1)))
    scene.add("b", *box((0.5, 0, 0), (2, 1, 1)))
    pairs = scene.check()
    for shown in (pairs._repr_html_(), pairs[0]._repr_html_(), scene.resolve().bodies[0]._repr_html_()):
        assert "<script>" not in shown and "&lt;script&gt;" in shown


def test_a_surface_is_a_value():
    surface = Surface(*box((0, 0, 0), (1, 2, 3)))
    again = pickle.loads(pickle.dumps(surface))
    assert repr(again) == "<Surface of 8 vertices, 12 faces>"
    points = np.random.default_rng(2).uniform(-1, 4, (50, 3))
    assert np.array_equal(again.signed_distance(points), surface.signed_distance(points))
    assert np.array_equal(surface.vertices, box((0, 0, 0), (1, 2, 3)).vertices)
