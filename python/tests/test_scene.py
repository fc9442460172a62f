"""Scenes: what is found, and what is refused."""

import pickle

import numpy as np
import pytest
from conftest import box, sphere

from musculo_collide import (
    InputTypeError,
    Cartilage,
    InputError,
    MusculoCollideError,
    Scene,
    Turn,
)

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


def test_resolve_opens_a_gap():
    scene = Scene()
    scene.add("bone", *sphere((0, 0, 0), 10, 16), rigid=True)
    scene.add("muscle", *sphere((0, 0, 19), 10, 16))
    resolution = scene.resolve(gap=0.5)
    assert resolution.resolved and resolution.gap == 0.5 and resolution.short_gaps == ()
    (pair,) = scene.check(margin=2.0)
    assert pair.distance >= 0.5

    # Two bones stay where they are, and are named.
    scene.add("other", *box((0, -2, 10.2), (4, 2, 12)), rigid=True)
    scene.ignore("muscle", "other")
    stuck = scene.resolve(gap=0.5)
    (short,) = stuck.short_gaps
    lower, upper = short.distance
    exact = scene.check(margin=2.0)["bone", "other"].distance
    assert not stuck.resolved and (short.a, short.b) == ("bone", "other") and "rigid" in short.reason
    assert lower <= exact <= upper
    with pytest.raises(InputError, match="gap"):
        scene.resolve(gap=-1.0)


def pressed_muscle() -> Scene:
    """Return a muscle that a bone presses from below, and a tendon that ends 0.1 above the muscle."""
    scene = Scene()
    scene.add("bone", *sphere((0, 0, 0), 10, 16), rigid=True)
    scene.add("muscle", *sphere((0, 0, 19), 10, 16))
    scene.add("tendon", *box((-1, -1, 29.1), (1, 1, 35)))
    return scene


def test_fixed_vertices_stay_where_they_are():
    # Of those that move where nothing is fixed, the half that moves the least.
    free = pressed_muscle()
    before = free.vertices("muscle")
    (change,) = (body for body in free.resolve().bodies if body.name == "muscle")
    ways = np.linalg.norm(change.displacements, axis=1)
    moved = np.flatnonzero((ways > 0) & (ways <= np.median(ways[ways > 0])))
    assert len(moved) > 4
    for numbers in (moved, list(moved), moved.astype(np.uint16)):
        scene = pressed_muscle()
        scene.resolve(fixed={"muscle": numbers})
        after = scene.vertices("muscle")
        assert np.array_equal(after[moved], before[moved])
        assert not np.array_equal(after, before)
    for fixed, error, message in (
        ({"muscle": [len(before)]}, InputError, f'"muscle" has no vertex {len(before)}, but {len(before)}'),
        ({"muscle": [-1]}, InputError, "number -1"),
        ({"muscle": [2**40]}, InputError, "no vertex has"),
        ({"muscle": [[0]]}, InputError, "list of numbers"),
        ({"muscle": [0.5]}, InputTypeError, "whole numbers"),
        ({"heart": [0]}, InputError, "no body"),
    ):
        with pytest.raises(error, match=message):
            scene.resolve(fixed=fixed)


def test_stiff_bodies_yield_less():
    def displacements(stiffness: float) -> list[float]:
        scene = Scene()
        scene.add("soft", *sphere((0, 0, 0), 10, 16))
        scene.add("stiff", *sphere((0, 0, 18.5), 10, 16))
        return [body.max_displacement for body in scene.resolve(stiffnesses={"stiff": stiffness}).bodies]

    (soft, other), (softer, stiff) = displacements(1.0), displacements(4.0)
    assert softer > soft and stiff < 0.7 * other


def test_tied_bodies_move_together():
    apart, tied = pressed_muscle(), pressed_muscle()
    assert apart.resolve(smoothing=40.0, gap=0.5).resolved
    assert apart.check(margin=2.0)["tendon", "muscle"].distance >= 0.5

    # Tied bodies need no gap, and keep the one that they have.
    resolution = tied.resolve(smoothing=40.0, gap=0.5, ties={("tendon", "muscle"): 1.0})
    assert resolution.resolved and not resolution.is_continued
    (tie,) = resolution.ties
    assert (tie.a, tie.b, tie.crossing) == ("tendon", "muscle", 0) and tie.tied > 0
    assert tied.check(margin=2.0)["tendon", "muscle"].distance == pytest.approx(0.1, abs=0.01)
    assert not np.array_equal(tied.vertices("tendon"), pressed_muscle().vertices("tendon"))
    for ties, message in (
        ({("tendon", "bone"): 1.0}, "'tendon' is not tied to 'bone'"),
        ({("tendon", "heart"): 1.0}, "no body"),
        ({("tendon", "tendon"): 1.0}, "both bodies"),
        ({"tendon": 1.0}, "between two names"),
        ({("tendon", "muscle"): -1.0}, "not tied"),
        ({("tendon", "muscle"): float("nan")}, "not tied"),
    ):
        with pytest.raises(InputError, match=message):
            tied.resolve(ties=ties)


def test_ignored_pairs_are_not_pushed_apart():
    scene = pressed_muscle()
    scene.ignore("muscle", "bone")
    before = scene.vertices("muscle")
    resolution = scene.resolve()
    assert resolution.resolved and len(resolution.before.overlapping) == 0
    assert np.array_equal(scene.vertices("muscle"), before)


def test_limits_of_a_resolution_are_kept_unless_they_are_waived():
    def squeezed() -> Scene:
        scene = Scene()
        scene.add("floor", *box((-20, -20, -5), (20, 20, 0)), rigid=True)
        scene.add("press", *box((-20, -20, 12), (20, 20, 20)), rigid=True)
        scene.add("muscle", *sphere((0, 0, 6), 10, 12))
        return scene

    kept = squeezed().resolve(max_volume_change=1e-9)
    assert kept.resolved and kept.bodies[2].volume_ratio == pytest.approx(1, abs=1e-9)
    refused = squeezed().resolve(max_strain=0.1)
    assert not refused.resolved and refused.bodies[2].strain <= 0.1
    waived = squeezed().resolve(max_strain=0.1, keep_going=True)
    assert waived.bodies[2].strain > 0.1
    assert [broken.name for broken in waived.broken_limits] == ["muscle"]
    near = squeezed().resolve(max_displacement=0.5, smoothing=1.0)
    assert not near.resolved and near.bodies[2].max_displacement <= near.broken_limits[0].displacement_limit
    assert near.broken_limits[0].max_displacement > near.broken_limits[0].displacement_limit
    with pytest.raises(InputError, match="max_volume_change"):
        squeezed().resolve(max_volume_change=0.0)


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
        ([["a", "b", "c"]], [[0, 0, 0]], InputTypeError, "real numbers"),
        ([[1j, 0, 0]], [[0, 0, 0]], InputTypeError, "complex"),
        ([[0, 0, 0], [1]], [[0, 0, 0]], InputError, "no array of numbers"),
        (TETRAHEDRON[0], [[0, 1]], InputError, r"faces of 'x' are m × 3"),
        (TETRAHEDRON[0], [[0.0, 1.0, 2.0]], InputTypeError, "whole numbers, not float64"),
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


def test_arrays_that_are_not_aligned_are_taken():
    vertices, faces = (np.asarray(array) for array in TETRAHEDRON)
    buffer = b"." + vertices.astype(np.float64).tobytes()
    unaligned = np.frombuffer(buffer, np.float64, offset=1).reshape(-1, 3)
    corners = np.frombuffer(b"." + faces.astype(np.int64).tobytes(), np.int64, offset=1).reshape(-1, 3)
    assert not unaligned.flags.aligned
    scene = Scene()
    scene.add("a", unaligned, corners)
    assert np.array_equal(scene.vertices("a"), vertices)


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


def test_bones_are_swept_on_rigid_ways():
    scene = Scene()
    scene.add("leg", *box((0, -1, -1), (10, 1, 1)), rigid=True)
    scene.add("wall", *box((-1, 5, -1), (20, 6, 1)))

    # The end of the leg is at a height of 10 sin(angle) + cos(angle).
    exact = np.degrees(2 * np.arctan((10 - np.sqrt(10**2 + 1 - 5**2)) / (5 + 1)))
    turn = Turn(axis=(0, 0, 2), center=(0, 0, 0), degrees=60)
    for sweep in (scene.sweep({"leg": turn}), scene.first_contacts({"leg": turn})):
        angle = 60 * sweep.largest_free_step
        assert angle <= exact <= angle + 1e-6
    assert len(scene.first_contacts({"leg": turn}).pairs[0].contacts.times) == 1

    # The same by its matrix, about the same center; and no chord is taken for the arc.
    c, s = np.cos(np.pi / 3), np.sin(np.pi / 3)
    matrix = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    posed = scene.sweep({"leg": matrix}, centers={"leg": (0, 0, 0)})
    assert posed.largest_free_step == pytest.approx(sweep.largest_free_step, abs=1e-9)
    scene.pose("leg", matrix)
    chord = scene.vertices("leg")
    scene.pose("leg", np.eye(4))
    assert scene.sweep({"leg": chord}).largest_free_step != pytest.approx(sweep.largest_free_step, abs=1e-3)
    assert scene.sweep({"leg": np.eye(4)}).largest_free_step == 1.0


def test_bad_motions_are_refused(two_boxes):
    nan = np.eye(4)
    nan[0, 3] = np.nan
    for moves, message in (
        ({"a": 2 * np.eye(4)}, "not a rotation"),
        ({"a": nan}, "not a rotation"),
        ({"b": np.eye(4)}, '"b" has no pose'),
        ({"b": np.zeros((5, 3))}, "8"),
        ({"b": np.full((8, 3), np.inf)}, "vertex 0"),
        ({"b": np.zeros((8, 2))}, "n × 3"),
        ({"c": Turn(axis=(1, 0, 0), center=(0, 0, 0), degrees=1)}, "no body"),
    ):
        for call in (two_boxes.sweep, two_boxes.first_contacts):
            with pytest.raises(InputError, match=message):
                call(moves)
    with pytest.raises(InputError, match="center of 'a'"):
        two_boxes.sweep({"a": np.eye(4)}, centers={"a": (1, 2)})
    for bad in ({"axis": (0, 0, 0)}, {"axis": (1, 0)}, {"center": (0, 0, np.nan)}, {"degrees": np.inf}):
        with pytest.raises(InputError):
            Turn(**{"axis": (1, 0, 0), "center": (0, 0, 0), "degrees": 1.0, **bad})


def test_joint_contact_is_that_of_the_closed_form(two_boxes):
    layer = Cartilage(youngs_modulus=5.0, poissons_ratio=0.46, thickness=5.0)
    scene = Scene()
    scene.add("femur", *sphere((0, 0, 19.5), 20, 120), rigid=True)
    scene.add("tibia", *box((-30, -30, -60), (30, 30, 0)), rigid=True)
    contact = scene.joint_contact("femur", "tibia", resolution=0.2, cartilage=layer)
    total = contact.of_a.total
    assert total.area_lower <= total.area <= total.area_upper
    assert total.area == pytest.approx(2 * np.pi * 20 * 0.5, rel=0.05)
    modulus = (1 - 0.46) * 5.0 / ((1 + 0.46) * (1 - 2 * 0.46))
    assert total.force[2] == pytest.approx(modulus / 5.0 * np.pi * 20 * 0.5**2, rel=0.02)
    assert contact.of_a.face_areas.sum() == pytest.approx(total.area)
    assert len(contact.of_a.faces) == len(contact.of_a.face_regions) and len(contact.of_a.regions) == 1

    # Named in the other order, the surfaces change places.
    turned = scene.joint_contact("tibia", "femur", resolution=0.2, cartilage=layer)
    assert (turned.of_b, turned.of_a) == (contact.of_a, contact.of_b)
    assert pickle.loads(pickle.dumps(contact)) == contact and "area" in repr(contact)
    for call in (
        lambda: two_boxes.joint_contact("a", "a", resolution=1.0),
        lambda: two_boxes.joint_contact("a", "b", resolution=0.0),
        lambda: two_boxes.joint_contact("a", "b", resolution=1e-9),
        lambda: two_boxes.joint_contact("a", "b", resolution=1.0, margin=-1.0),
        lambda: two_boxes.joint_contact("a", "b", resolution=1.0, cartilage=Cartilage(5.0, 0.5, 5.0)),
        lambda: two_boxes.joint_contact("a", "b", resolution=1.0, cartilage=Cartilage(5.0, 0.4, 5.0, "cubic")),
    ):
        with pytest.raises(InputError):
            call()


def test_long_tables_have_a_row_per_number(two_boxes):
    table = two_boxes.check().to_long_table("p03", frame=2, time=0.5)
    assert list(table) == ["subject", "frame", "time", "a", "b", "measure", "value"]
    assert len({len(column) for column in table.values()}) == 1
    values = dict(zip(table["measure"], table["value"]))
    assert values["overlap.volume"] == pytest.approx(160) and values["overlaps"] == 1
    assert set(table["subject"]) == {"p03"} and set(table["frame"]) == {2} and set(table["time"]) == {0.5}
    assert {len(column) for column in Scene().check().to_long_table().values()} == {0}


def test_particles_are_numbered_body_after_body(two_boxes):
    assert (two_boxes.particles("a"), two_boxes.particles("b")) == (slice(0, 8), slice(8, 16))
    x = two_boxes.particle_positions()
    assert np.array_equal(x[two_boxes.particles("b")], two_boxes.vertices("b"))
    assert Scene().particle_positions().shape == (0, 3)
    with pytest.raises(InputError, match="no body"):
        two_boxes.particles("c")


def test_the_axis_of_a_turn_has_any_length():
    found = []
    for length in (1e-320, 1e-200, 1.0, 1e200):
        scene = Scene()
        scene.add("lever", *box((0, 0, 0), (10, 1, 1)), rigid=True)
        scene.add("stop", *box((0, 5, 0), (1, 6, 1)))
        turn = Turn(axis=(0, 0, length), center=(0, 0, 0), degrees=90)
        found.append(scene.sweep({"lever": turn}).largest_free_step)
    assert 0.7 < found[0] < 0.8 and found == [found[0]] * 4


def test_a_subclass_of_a_scene_has_arguments_of_its_own():
    class Thigh(Scene):
        def __init__(self, side: str, *, unit: str) -> None:
            super().__init__()
            self.side, self.unit = side, unit

    thigh = Thigh("left", unit="mm")
    thigh.add("bone", *TETRAHEDRON)
    assert (thigh.side, thigh.unit, thigh.names) == ("left", "mm", ["bone"])
    with pytest.raises(TypeError):
        Scene("left")
