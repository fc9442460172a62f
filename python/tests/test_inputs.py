"""What is refused, by every public call: with an exception of the package that names it."""

import threading

import numpy as np
import pytest
from conftest import box, sphere

from musculo_collide import (
    Cartilage,
    ContactStep,
    DistanceField,
    InUseError,
    Material,
    MusculoCollideError,
    Plan,
    Scene,
    Surface,
    Turn,
    from_trimesh,
    medial,
    read_mesh,
    to_trimesh,
    write_mesh,
)

CUBE, BALL = box((0, 0, 0), (1, 1, 1)), sphere((0, 0, 0), 5, 8)
HUGE, NAN = 10**400, float("nan")


def scene() -> Scene:
    scene = Scene()
    scene.add("a", *box((0, 0, 0), (10, 10, 10)), rigid=True)
    scene.add("b", *box((8, 1, -1), (20, 9, 11)))
    return scene


def step() -> ContactStep:
    return ContactStep(scene(), margin=0.5)


def correct(**arguments: object) -> object:
    x = scene().particle_positions()
    return step().correct(x, np.zeros_like(x), **{"h": 0.1, **arguments})


def field() -> DistanceField:
    return DistanceField.build(*BALL, spacing=1.0)


def joint(**arguments: object) -> object:
    return scene().joint_contact("a", "b", **{"resolution": 1.0, **arguments})


BAD_CALLS = {
    "add: name": lambda: Scene().add(5, *CUBE),
    "add: vertices": lambda: Scene().add("q", None, CUBE.faces),
    "add: faces": lambda: Scene().add("q", CUBE.vertices, None),
    "add: masks": lambda: Scene().add("q", CUBE.vertices, np.zeros((2, 3), bool)),
    "add: objects": lambda: Scene().add("q", np.array([[object()] * 3]), CUBE.faces),
    "add: name that is no text": lambda: Scene().add("\ud800", *CUBE),
    "add: name with NUL": lambda: Scene().add("a\0", *CUBE),
    "add: name of two lines": lambda: Scene().add("a\nb", *CUBE),
    "add: masked": lambda: Scene().add("q", np.ma.masked_array(CUBE.vertices, CUBE.vertices > 0), CUBE.faces),
    "vertices: name that is no text": lambda: scene().vertices("\ud800"),
    "names": lambda: [call(5) for call in (scene().vertices,)],
    "faces": lambda: scene().faces(None),
    "is_rigid": lambda: scene().is_rigid(5),
    "particles": lambda: scene().particles(5),
    "move": lambda: scene().move(5, CUBE.vertices),
    "pose": lambda: scene().pose(5, np.eye(4)),
    "pose: words": lambda: scene().pose("a", "matrix"),
    "pose: digits": lambda: scene().pose("a", np.eye(4).astype(str)),
    "pose: complex": lambda: scene().pose("a", np.eye(4) + 0j),
    "ignore": lambda: scene().ignore("a", 5),
    **{
        f"check: {name} {value!r:.9}": lambda name=name, value=value: scene().check(**{name: value})
        for name, values in {
            "margin": ("1", None, np.zeros(2), NAN, HUGE, -1),
            "depth_tolerance": ("1", NAN, 0),
            "threads": ("2", 1.5, 0, -1, 1000, HUGE),
            "progress": (5, "bar"),
        }.items()
        for value in values
    },
    **{
        f"resolve: {name} {value!r:.9}": lambda name=name, value=value: scene().resolve(**{name: value})
        for name, values in {
            "smoothing": ("1", NAN, 0),
            "tolerance": ("1", NAN, -1),
            "gap": ("1", None, NAN, -1),
            "max_rounds": ("3", 1.5, -1, 2**40, HUGE),
            "max_volume_change": ("1", None, NAN, 0),
            "max_strain": ("1", None, NAN, 0),
            "max_displacement": ("1", None, NAN, 0),
            "stiffnesses": ([1], {5: 1.0}, {"b": "2"}, {"b": 0.0}, {"b": -1.0}, {"b": NAN}, {"b": 1e140}, {"heart": 1.0}),
            "fixed": ([1], {5: [0]}, {"b": "all"}, {"b": None}),
            "uncross": (5, [5], "b", "heart", ["heart"]),
            "ties": ([1], {("a",): 1.0}, {("a", "b"): "1"}, {("a", 5): 1.0}),
            "threads": (-1,),
            "progress": (5,),
        }.items()
        for value in values
    },
    "sweep: list": lambda: scene().sweep([1]),
    "sweep: rows of several lengths": lambda: scene().sweep({"b": [[1, 2], [3]]}),
    "sweep: nothing": lambda: scene().sweep({"b": None}),
    "sweep: name": lambda: scene().sweep({5: CUBE.vertices}),
    "sweep: center of a mistyped name": lambda: scene().sweep({"a": np.eye(4)}, centers={"A": (0, 0, 0)}),
    "sweep: center of vertices": lambda: scene().sweep({"b": CUBE.vertices}, centers={"b": (0, 0, 0)}),
    "sweep: centers": lambda: scene().sweep({"a": np.eye(4)}, centers=5),
    "sweep: separation": lambda: scene().sweep({}, separation="1"),
    "sweep: negative": lambda: scene().sweep({"a": np.eye(4)}, separation=-1),
    "first_contacts": lambda: scene().first_contacts({}, threads=-1),
    "joint: resolution": lambda: joint(resolution="1"),
    "joint: margin": lambda: joint(margin=None),
    "joint: cartilage": lambda: joint(cartilage=5),
    "joint: modulus": lambda: Cartilage("5", 0.3, 1.0),
    "joint: law": lambda: Cartilage(5.0, 0.3, 1.0, 5),
    "turn: axis": lambda: Turn("x", (0, 0, 0), 5),
    "turn: axis of digits": lambda: Turn("001", (0, 0, 0), 5),
    "turn: center of digits": lambda: Turn((0, 0, 1), ("0", "0", "0"), 5),
    "turn: degrees": lambda: Turn((1, 0, 0), (0, 0, 0), "5"),
    "plan: scene": lambda: Plan("scene", tolerance=0.1),
    "plan: tolerance": lambda: Plan(scene(), tolerance="1"),
    "plan: frames": lambda: Plan(scene(), tolerance=0.1, frames=-1),
    "plan: many frames": lambda: Plan(scene(), tolerance=0.1, frames=2**40),
    "plan: part of a frame": lambda: Plan(scene(), tolerance=0.1, frames=1.5),
    "plan: margin": lambda: Plan(scene(), tolerance=0.1, margin=NAN),
    "plan: max_displacement": lambda: Plan(scene(), tolerance=0.1, max_displacement=-1),
    "plan: threads": lambda: Plan(scene(), tolerance=0.1).detect(threads=0),
    "plan: clearance": lambda: Plan(scene(), tolerance=0.1).respond(clearance="1"),
    "step: scene": lambda: ContactStep(5, margin=0.5),
    "step: margin": lambda: ContactStep(scene(), margin="1"),
    "step: material": lambda: ContactStep(scene(), margin=0.5, material=5),
    "step: friction": lambda: ContactStep(scene(), margin=0.5, material=Material(friction="1")),
    "step: permanent": lambda: step().set_material("a", "b", Material(permanent=5)),
    "step: material of a pair": lambda: step().set_material("a", "b", 5),
    "step: name": lambda: step().set_material("a", 5, Material()),
    "step: field": lambda: step().set_field("a", 5),
    "step: deviation": lambda: step().set_coarse("b", deviation="1"),
    "step: balls": lambda: step().set_balls("b", tolerance=None),
    "step: bone": lambda: step().move_bone("a", np.eye(3)),
    "step: velocity": lambda: step().move_bone("a", np.eye(4), velocity=(1, 2)),
    **{
        f"correct: {name} {value!r:.9}": lambda name=name, value=value: correct(**{name: value})
        for name, values in {
            "h": ("1", None, NAN, 0, -1),
            "inverse_mass": ("1", [[1.0]], [1.0], [NAN] * 16),
            "depth_tolerance": ("1", NAN, -1),
            "max_rounds": ("1", -1),
            "iterations": (1.5, -1),
            "threads": (0, "1"),
            "forces": ("1", [[0.0] * 3]),
        }.items()
        for value in values
    },
    "surface: empty": lambda: Surface(np.zeros((0, 3)), np.zeros((0, 3), int)),
    "surface: other": lambda: Surface(*CUBE).overlap(5),
    "surface: points": lambda: Surface(*CUBE).contains([[1, 2]]),
    "surface: threads": lambda: Surface(*CUBE).signed_distance([[1, 2, 3]], threads=-1),
    "surface: far": lambda: Surface(*CUBE).closest_points([[1e155, 0, 0]]),
    "surface: NaN": lambda: Surface(*CUBE).closest_points([[NAN] * 3]),
    "field: spacing": lambda: DistanceField.build(*BALL, spacing="1"),
    "field: negative spacing": lambda: DistanceField.build(*BALL, spacing=-1),
    "field: padding": lambda: DistanceField.build(*BALL, spacing=1.0, padding=-1),
    "field: truncation": lambda: DistanceField.build(*BALL, spacing=1.0, truncation=0),
    "field: nothing": lambda: DistanceField.build(np.zeros((0, 3)), np.zeros((0, 3), int), spacing=1.0),
    "field: NaN": lambda: field().query([[NAN] * 3]),
    "field: points": lambda: field().query("points"),
    "field: file": lambda: DistanceField.read(5),
    "field: folder": lambda: field().write("/nonexistent/field.nrrd"),
    "medial: balls": lambda: medial.generate(*BALL, balls="4"),
    "medial: part of a ball": lambda: medial.generate(*BALL, balls=2.5),
    "medial: negative": lambda: medial.generate(*BALL, balls=-4),
    "medial: tolerance": lambda: medial.generate(*BALL, tolerance="1"),
    "read_mesh": lambda: read_mesh(5),
    "read_mesh: path that is no text": lambda: read_mesh("\ud800.ply"),
    "read_mesh: folder": lambda: read_mesh("/"),
    "write_mesh": lambda: write_mesh("/nonexistent/cube.ply", *CUBE),
    "write_mesh: path": lambda: write_mesh(5, *CUBE),
    **{
        f"write_mesh: {extension} of {name}": lambda mesh=mesh, extension=extension: write_mesh(f"q.{extension}", *mesh)
        for name, mesh in {
            "NaN": (CUBE.vertices * NAN, CUBE.faces),
            "large numbers": (CUBE.vertices * 1e300, CUBE.faces),
            "no faces": (CUBE.vertices, []),
        }.items()
        for extension in ("ply", "obj", "off", "stl", "vtp")
    },
    "write_mesh: corner": lambda: write_mesh("cube.ply", CUBE.vertices, [[0, 1, 99]]),
    "from_trimesh": lambda: from_trimesh(5),
}


@pytest.mark.parametrize("call", BAD_CALLS)
def test_bad_input_has_an_exception_of_the_package(call, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MusculoCollideError) as refused:
        BAD_CALLS[call]()
    assert len(str(refused.value)) > 8 and "extract" not in str(refused.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("value", [-1.0, 0.0, NAN])
def test_a_tolerance_of_balls_is_refused_by_its_name(value):
    with pytest.raises(MusculoCollideError, match='body "b": tolerance is (-1|0|NaN), but'):
        step().set_balls("b", tolerance=value)


def test_meshes_of_no_kind_are_refused_by_trimesh_too():
    pytest.importorskip("trimesh")
    with pytest.raises(MusculoCollideError):
        to_trimesh(5)


def test_what_a_call_uses_is_refused_to_others():
    used = scene()
    plan, contact_step = Plan(used, tolerance=0.1), ContactStep(used, margin=0.5)
    x = used.particle_positions()
    refusals = []

    def use(share: float) -> None:
        for call in (
            used.check,
            lambda: used.names,
            lambda: used.vertices("a"),
            lambda: used.move("b", CUBE.vertices),
            lambda: repr(used),
            plan.detect,
            plan.respond,
            lambda: contact_step.correct(x, np.zeros_like(x), h=0.1),
        ):
            with pytest.raises(InUseError, match="the scene is in use by another call"):
                call()
            refusals.append(call)
        raise StopIteration

    # Within the call, from its own thread and from another one.
    ball = sphere((5, 5, 12), 8, 100)
    used.add("ball", *ball)
    with pytest.raises(StopIteration):
        used.resolve(threads=1, progress=use)
    elsewhere = []

    def use_elsewhere() -> None:
        with pytest.raises(InUseError):
            used.check()
        elsewhere.append("refused")

    other = threading.Thread(target=use_elsewhere)

    def wait(share: float) -> None:
        other.start()
        other.join()
        raise StopIteration

    with pytest.raises(StopIteration):
        used.resolve(threads=2, progress=wait)
    assert len(refusals) == 8 and elsewhere == ["refused"] and len(used.check()) > 0


def test_a_plan_and_a_step_are_shared_by_no_two_calls():
    plan = Plan(scene(), tolerance=0.1)
    done, refusals = [], []

    def detect() -> None:
        for _ in range(300):
            try:
                done.append(len(plan.detect(threads=1)))
            except InUseError as error:
                refusals.append(str(error))

    threads = [threading.Thread(target=detect) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(done) == {1} and len(done) + len(refusals) == 900
    assert all("in use" in refusal for refusal in refusals)
