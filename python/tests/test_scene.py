"""Scenes: what is found, and what is refused."""

import pickle

import numpy as np
import pytest
from conftest import box, sphere

from musculo_collide import ArrayTypeError, InputError, MusculoCollideError, Scene

TETRAHEDRON = ([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def test_two_boxes_share_a_planted_box(two_boxes):
    (pair,) = two_boxes.check()
    total = pair.overlap.total
    assert pair.overlaps and (pair.a, pair.b) == ("a", "b")
    assert pair.volume == pytest.approx(2 * 8 * 10, rel=1e-14)
    assert total.centroid == pytest.approx((9, 5, 5), rel=1e-14)
    assert (total.curve_loops, total.curve_length) == (1, pytest.approx(44)) and len(pair.overlap.regions) == 1
    lower, upper = pair.depth
    assert lower <= 2.0 <= upper and upper - lower <= 0.02 * 1.01

    narrow = two_boxes.check(depth_tolerance=1e-6)[0].depth
    assert narrow[0] <= 2.0 <= narrow[1] and narrow[1] - narrow[0] <= 1e-6


def test_a_pair_is_found_by_both_names(two_boxes):
    pairs = two_boxes.check()
    assert pairs["b", "a"] is pairs[0] is pairs["a", "b"]
    with pytest.raises(KeyError):
        pairs["a", "c"]


def test_near_pairs_have_their_distance(two_boxes):
    two_boxes.move("b", two_boxes.vertices("b") + [2.5, 0, 0])
    assert len(two_boxes.check()) == 0
    (pair,) = two_boxes.check(margin=1.0)
    assert not pair.overlaps and pair.distance == 0.5 and pair.volume is None
    lower, upper = pair.near_area_of_a
    assert 100 <= lower <= upper <= 118
    assert "apart by 0.5" in repr(pair)


def test_vertices_inside_have_exact_gaps(two_boxes):
    ball = sphere((5, 5, 10), 2)
    scene = Scene()
    scene.add("box", *box((0, 0, 0), (10, 10, 10)), rigid=True)
    scene.add("ball", *ball)
    near = scene.check()["box", "ball"].vertices_of_b
    inside = np.flatnonzero(ball.vertices[:, 2] < 10)
    assert near.inside_count == len(inside)
    expected = ball.vertices[near.vertices, 2] - 10
    assert np.abs(near.gaps - expected).max() < 1e-14
    assert np.abs(near.normals - [0.0, 0.0, 1.0]).max() < 1e-12


def test_a_sweep_finds_the_time_of_contact(two_boxes):
    scene = Scene()
    scene.add("a", *box((0, 0, 0), (1, 1, 1)), rigid=True)
    scene.add("b", *box((2, 0.25, 0.25), (3, 0.75, 0.75)))
    end = scene.vertices("b") - [4, 0, 0]
    sweep = scene.sweep({"b": end})
    assert sweep.largest_free_step <= 0.25 <= sweep.largest_free_step + 1e-9
    assert sweep.pairs[0].first_time == sweep.largest_free_step
    assert scene.sweep({"b": scene.vertices("b") + 1}).largest_free_step == 1.0


def test_resolve_pushes_apart():
    scene = Scene()
    scene.add("bone", *sphere((0, 0, 0), 10, 16), rigid=True)
    muscle = sphere((0, 0, 19), 10, 16)
    scene.add("muscle", *muscle)
    resolution = scene.resolve()
    assert resolution.resolved and not resolution.remaining
    assert len(resolution.before.overlapping) == 1 and len(resolution.after.overlapping) == 0
    change = resolution.bodies[1]
    assert np.array_equal(muscle.vertices + change.displacements, scene.vertices("muscle"))
    assert len(scene.check().overlapping) == 0


def test_a_bone_is_posed():
    scene = Scene()
    cube = box((0, 0, 0), (1, 1, 1))
    scene.add("bone", *cube, rigid=True)
    scene.add("muscle", *cube)
    turn = np.array([[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1.0]])
    scene.pose("bone", turn)
    expected = cube.vertices @ turn[:3, :3].T + turn[:3, 3]
    assert np.abs(scene.vertices("bone") - expected).max() < 1e-15 * 16
    for matrix in (np.eye(3), 2 * np.eye(4), np.diag([1, 1, -1, 1])):
        with pytest.raises(InputError, match="bone"):
            scene.pose("bone", matrix)
    with pytest.raises(InputError, match="muscle.*not rigid"):
        scene.pose("muscle", turn)


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "message"),
    [
        ([[0, 0]], [[0, 1, 2]], InputError, r"vertices of 'x' are n × 3 numbers, not .*\(1, 2\)"),
        ([0, 0, 0], [[0, 1, 2]], InputError, r"shape \(3,\)"),
        ([], [[0, 1, 2]], InputError, r"shape \(0,\)"),
        ([["a", "b", "c"]], [[0, 0, 0]], ArrayTypeError, "real numbers"),
        ([[1j, 0, 0]], [[0, 0, 0]], ArrayTypeError, "complex"),
        ([[0, 0, 0], [1]], [[0, 0, 0]], InputError, "no array of numbers"),
        (TETRAHEDRON[0], [[0, 1]], InputError, r"faces of 'x' are m × 3"),
        (TETRAHEDRON[0], [[0.0, 1.0, 2.0]], ArrayTypeError, "whole numbers, not float64"),
        (TETRAHEDRON[0], [[0, 1, -1]], InputError, r'body "x": face 0 has the corner -1'),
        (TETRAHEDRON[0], [[0, 1, 2], [0, 1, 4]], InputError, "face 1 has the corner 4, but there are 4"),
        (TETRAHEDRON[0], np.array([[0, 1, 2**63]], np.uint64), InputError, "9223372036854775808"),
        (TETRAHEDRON[0], np.zeros((0, 3), int), InputError, "no faces"),
        ([[0, 0, 0], [9, 0, 0], [0, np.nan, 0], [0, 0, 9]], TETRAHEDRON[1], InputError, "vertex 2"),
        ([[0, 0, 0], [9, 0, 0], [0, np.inf, 0], [0, 0, 9]], TETRAHEDRON[1], InputError, "vertex 2"),
        ([[0, 0, 0], [9, 0, 0], [0, 1e200, 0], [0, 0, 9]], TETRAHEDRON[1], InputError, "1e200"),
    ],
)
def test_bad_bodies_are_refused_by_name(vertices, faces, error, message):
    scene = Scene()
    with pytest.raises(error, match=message) as refused:
        scene.add("x", vertices, faces)
    assert isinstance(refused.value, MusculoCollideError)
    assert scene.names == []


def test_calls_on_unknown_bodies_are_refused(two_boxes):
    for call in (
        lambda: two_boxes.vertices("c"),
        lambda: two_boxes.faces("c"),
        lambda: two_boxes.is_rigid("c"),
        lambda: two_boxes.move("c", [[0, 0, 0]]),
        lambda: two_boxes.pose("c", np.eye(4)),
        lambda: two_boxes.ignore("a", "c"),
        lambda: two_boxes.sweep({"c": [[0, 0, 0]]}),
    ):
        with pytest.raises(InputError, match=r'no body is named "c"; there are \["a", "b"\]'):
            call()
    with pytest.raises(InputError, match="two bodies are named"):
        two_boxes.add("a", *box((0, 0, 0), (1, 1, 1)))


def test_bad_parameters_are_refused(two_boxes):
    for call in (
        lambda: two_boxes.check(margin=-1),
        lambda: two_boxes.check(margin=float("nan")),
        lambda: two_boxes.check(depth_tolerance=0.0),
        lambda: two_boxes.check(threads=0),
        lambda: two_boxes.check(threads=100_000),
        lambda: two_boxes.move("b", [[0, 0, 0]]),
        lambda: two_boxes.sweep({"b": two_boxes.vertices("b")[:5]}),
        lambda: two_boxes.resolve(smoothing=0.0),
        lambda: Scene().resolve(),
        lambda: Scene().add("s", *TETRAHEDRON, rigid=True, open=True),
    ):
        with pytest.raises(InputError):
            call()
    assert len(two_boxes.check()) == 1, "the scene is as it was"


def test_arrays_of_other_kinds_are_converted():
    vertices, faces = TETRAHEDRON
    expected = Scene()
    expected.add("x", vertices, faces)
    for x in (
        np.array(vertices, np.float32),
        np.array(vertices, np.int16),
        np.asfortranarray(vertices, float),
        np.repeat(np.array(vertices, float), 2, axis=0)[::2],
        np.array(vertices, ">f8"),
    ):
        for corners in (
            np.array(faces, np.uint8),
            np.array(faces, np.uint64),
            np.asfortranarray(faces),
            np.hstack([np.full((4, 1), 3), faces]).ravel(),
        ):
            scene = Scene()
            scene.add("x", x, corners)
            assert np.array_equal(scene.vertices("x"), expected.vertices("x"))
            assert np.array_equal(scene.faces("x"), expected.faces("x"))


def test_read_only_arrays_are_read_and_a_scene_keeps_its_own():
    vertices, faces = np.array(TETRAHEDRON[0], float), np.array(TETRAHEDRON[1])
    vertices.flags.writeable = faces.flags.writeable = False
    scene = Scene()
    scene.add("x", vertices, faces)
    copy = scene.vertices("x")
    copy[:] = 7
    assert np.array_equal(scene.vertices("x"), vertices)


def test_results_are_values(two_boxes):
    pairs = two_boxes.check()
    again = pickle.loads(pickle.dumps(pairs))
    assert again == pairs and again[0] == pairs[0]
    two_boxes.move("b", two_boxes.vertices("b") + [0.5, 0, 0])
    assert two_boxes.check() != pairs
    sweep = two_boxes.sweep({"b": two_boxes.vertices("b") + 1})
    assert pickle.loads(pickle.dumps(sweep)) == sweep


def test_tables_and_html(two_boxes):
    pairs = two_boxes.check()
    table = pairs.to_table()
    assert {len(column) for column in table.values()} == {1}
    assert table["volume"].dtype == float and table["a"][0] == "a"
    assert {name: column.dtype for name, column in Scene().check().to_table().items()}.keys() == table.keys()
    assert "<td>160</td>" in pairs._repr_html_()
    assert pairs.to_dict()[0]["overlap"]["total"]["volume"] == pairs[0].volume


def test_sheets_and_coincident_bodies():
    scene = Scene()
    cube = box((0, 0, 0), (1, 1, 1))
    scene.add("a", *cube)
    scene.add("b", *cube)
    scene.add("sheet", [[-1, -1, 0.5], [2, -1, 0.5], [2, 2, 0.5]], [[0, 1, 2]], open=True)
    pairs = scene.check()
    assert pairs["a", "b"].coincidence == "same_mesh" and pairs["a", "b"].volume == pytest.approx(1)
    sheet = pairs["a", "sheet"]
    assert sheet.volume is None and "open" in sheet.overlap.no_inside[1]
    assert sheet.vertices_of_a.no_inside
