"""Contact steps over arrays in place."""

import threading

import numpy as np
import pytest
from conftest import box, sphere

from musculo_collide import (
    InputTypeError,
    ContactStep,
    DistanceField,
    InputError,
    Material,
    Scene,
)

H = 0.01


def falling_ball() -> tuple[Scene, np.ndarray, np.ndarray]:
    """Return a soft ball 0.5 deep in a block, which falls at 1."""
    scene = Scene()
    scene.add("block", *box((-20, -20, -10), (20, 20, 0)), rigid=True)
    scene.add("ball", *sphere((0, 0, 4.5), 5, 12))
    x = scene.particle_positions()
    v = np.zeros_like(x)
    v[scene.particles("ball"), 2] = -1.0
    return scene, x, v


def test_states_are_corrected_where_they_are():
    scene, x, v = falling_ball()
    addresses = [array.__array_interface__["data"][0] for array in (x, v)]
    block = x[scene.particles("block")].copy()
    report = ContactStep(scene, margin=0.5).correct(x, v, h=H)
    assert [array.__array_interface__["data"][0] for array in (x, v)] == addresses
    assert report.depth_before == pytest.approx(0.5, rel=1e-12) and report.depth <= 1e-9

    # The scene is where the caller's array is; what rests is as it was.
    ball = scene.particles("ball")
    assert np.array_equal(scene.vertices("ball"), x[ball])
    assert np.array_equal(x[scene.particles("block")], block)
    lowest = x[ball][:, 2] < 0.05
    assert lowest.any() and (v[ball][lowest, 2] >= -1e-9).all() and x[ball][:, 2].min() >= -1e-9
    assert report.impulse[2] > 0 and report.swept_contacts is None


def test_a_moving_bone_gives_its_velocity():
    scene, x, v = falling_ball()
    step = ContactStep(scene, margin=0.5)
    step.move_bone("block", np.eye(4), velocity=(0, 0, 3))
    report = step.correct(x, v, h=H)
    ball = scene.particles("ball")
    assert v[ball][x[ball][:, 2] < 0.01, 2].min() == pytest.approx(3.0) and report.rigid_work > 0
    with pytest.raises(InputError, match="ball.*not rigid"):
        step.move_bone("ball", np.eye(4))


@pytest.mark.parametrize("threads", [None, 1, 2])
def test_steps_have_the_same_bits_for_any_number_of_threads(threads):
    states = []
    for number in (1, threads):
        scene, x, v = falling_ball()
        step = ContactStep(scene, margin=0.5, material=Material(friction=0.4))
        for _ in range(3):
            step.correct(x, v, h=H, threads=number)
            x += H * v
        states.append((x, v))
    assert all(np.array_equal(*pair) for pair in zip(*states))


def test_fields_and_soft_materials_answer_too():
    scene, x, v = falling_ball()
    step = ContactStep(scene, margin=0.5, material=Material(stiffness=1e3, damping=1.0))
    step.set_field("block", DistanceField.build(scene.vertices("block"), scene.faces("block"), spacing=0.5))
    report = step.correct(x, v, h=H)
    assert report.contacts > 0 and report.fallbacks == [] and report.contact_energy > 0


def fall_on(method: str) -> tuple[float, list[tuple[str, str, str]]]:
    """Let a ball fall on another; return its gap to that, and what was detected exactly."""
    scene = Scene()
    scene.add("bone", *sphere((0, 0, -20), 20, 24), rigid=True)
    scene.add("ball", *sphere((0.3, 0.2, 5.2), 5, 24))
    x = scene.particle_positions()
    v = np.zeros_like(x)
    v[scene.particles("ball"), 2] = -20.0
    step = ContactStep(scene, margin=0.5, tolerance=0.3)
    if method == "coarse":
        step.set_coarse("ball")
    elif method == "balls":
        step.set_balls("bone", tolerance=0.5)
        step.set_balls("ball", tolerance=0.5)
    fallbacks = []
    for _ in range(5):
        fallbacks += step.correct(x, v, h=H).fallbacks
        x += H * v
    scene.move("ball", x[scene.particles("ball")])
    return scene.check(margin=1.0)[0].min_gap, fallbacks


@pytest.mark.parametrize("method", ["exact", "coarse", "balls"])
def test_a_ball_stops_whatever_detects_it(method):
    gap, fallbacks = fall_on(method)
    assert fallbacks == [] and -0.31 < gap < 0.2, (gap, fallbacks)


def test_structures_that_do_not_serve_are_named():
    scene, x, v = falling_ball()
    step = ContactStep(scene, margin=0.5, tolerance=0.01)
    step.set_coarse("ball", deviation=0.5)
    assert step.correct(x, v, h=H).fallbacks == [("block", "ball", "coarse surface deviates")]
    for call, message in (
        (lambda: ContactStep(scene, margin=0.5).set_coarse("ball"), '"ball": deviation is 0.*tolerance'),
        (lambda: step.set_coarse("ball", deviation=-1.0), '"ball": deviation is -1'),
        (lambda: step.set_balls("ball", tolerance=0.0), '"ball".*tolerance'),
        (lambda: step.set_balls("heart", tolerance=1.0), "no body"),
        (lambda: step.set_coarse("heart", deviation=1.0), "no body"),
    ):
        with pytest.raises(InputError, match=message):
            call()
    scene.add("sheet", [[0, 0, 9], [1, 0, 9], [0, 1, 9]], [[0, 1, 2]], open=True)
    for call in (lambda: step.set_coarse("sheet", deviation=1.0), lambda: step.set_balls("sheet", tolerance=1.0)):
        with pytest.raises(InputError, match='"sheet".*(open|edge|closed)'):
            call()


def test_accelerations_and_forces_are_corrected():
    for name in ("accelerations", "forces"):
        scene, x, v = falling_ball()
        v[:] = 0.0
        loads = np.zeros_like(x)
        loads[scene.particles("ball"), 2] = -9.81
        report = ContactStep(scene, margin=0.5).correct(x, v, h=H, **{name: loads})
        ball = scene.particles("ball")
        held = x[ball][:, 2] < 1e-6
        assert loads[ball][held, 2].min() >= -1e-6 and report.force[2] > 0
    with pytest.raises(InputError, match="either accelerations or forces"):
        ContactStep(scene, margin=0.5).correct(x, v, h=H, accelerations=loads, forces=loads.copy())


def test_a_swept_step_stops_what_would_pass_through():
    scene = Scene()
    scene.add("plate", *box((-20, -20, -0.1), (20, 20, 0)), rigid=True)
    scene.add("ball", *sphere((0, 0, 8), 2, 8))
    x = scene.particle_positions()
    v = np.zeros_like(x)
    v[scene.particles("ball"), 2] = -2000.0
    report = ContactStep(scene, margin=0.5).correct(x, v, h=H, swept=True)
    assert report.swept_contacts > 0 and report.free_share == pytest.approx(1.0, abs=1e-9)
    assert (x + H * v)[scene.particles("ball"), 2].min() >= -1e-6


def test_a_sticking_pair_pulls():
    scene, x, v = falling_ball()
    v[scene.particles("ball"), 2] = 1.0
    step = ContactStep(scene, margin=0.5)
    step.set_material("block", "ball", Material(permanent="sticking", attach_within=0.1))
    step.correct(x, v, h=H)
    ball = scene.particles("ball")
    attached = x[ball][:, 2] < 0.01
    assert attached.any() and np.abs(v[ball][attached]).max() < 0.1
    with pytest.raises(InputError, match="set_material"):
        ContactStep(scene, margin=0.5, material=Material(permanent="sliding"))


def test_a_pair_that_stuck_is_let_go_by_another_material():
    scene = Scene()
    scene.add("bone", *sphere((0, 0, -10), 10, 24), rigid=True)
    scene.add("ball", *sphere((0, 0, 4.9), 5, 12))
    x, ball = scene.particle_positions(), scene.particles("ball")
    v = np.zeros_like(x)
    stuck, plain = (ContactStep(scene, margin=0.5, tolerance=0.3) for _ in range(2))
    stuck.set_material("bone", "ball", Material(permanent="sticking", attach_within=0.1))
    stuck.correct(x, v, h=H)
    stuck.set_material("bone", "ball", Material())

    # As one that never stuck: contacts are detected anew where the ball slides around the bone.
    ends = []
    for step in (stuck, plain):
        at, speed = x.copy(), v.copy()
        for _ in range(3):
            speed[ball] = (5.0, 0.0, -1.0)
            assert step.correct(at, speed, h=H).contacts > 0
            at[ball] += H * speed[ball]
        ends.append((at, speed))
    assert np.array_equal(*(at for at, _ in ends)) and np.array_equal(*(speed for _, speed in ends))


def test_arrays_that_cannot_be_changed_in_place_are_refused():
    scene, x, v = falling_ball()
    step = ContactStep(scene, margin=0.5)
    frozen = v.copy()
    frozen.flags.writeable = False
    nan = v.copy()
    nan[30, 1] = np.nan
    for bad, error, message in (
        (v.astype(np.float32), InputTypeError, "float64, not float32"),
        (v.astype(">f8"), InputTypeError, "float64"),
        (v.tolist(), InputTypeError, "numpy array, not list"),
        (np.asfortranarray(v), InputError, "rows follow each other"),
        (np.repeat(v, 2, axis=0)[::2], InputError, "rows follow each other"),
        (v[:, :2], InputError, "n × 3"),
        (v.ravel(), InputError, "n × 3"),
        (v[:-1], InputError, r"velocity|particle|rows"),
        (np.zeros((0, 3)), InputError, r"velocity|particle|rows"),
        (frozen, InputError, "v is read-only"),
        (x, InputError, "v is in use"),
        (nan, InputError, "velocity of particle 30 is NaN"),
    ):
        with pytest.raises(error, match=message):
            step.correct(x, bad, h=H)
    for call in (
        lambda: step.correct(x[:-1], v[:-1], h=H),
        lambda: step.correct(x, v, h=0.0),
        lambda: step.correct(x, v, h=H, inverse_mass=np.ones(3)),
        lambda: step.correct(x, v, h=H, inverse_mass=-np.ones(len(x))),
        lambda: step.correct(x, v, h=H, depth_tolerance=-1.0),
        lambda: ContactStep(scene, margin=0.0),
        lambda: ContactStep(scene, margin=0.5, material=Material(friction=-1.0)),
        lambda: ContactStep(scene, margin=0.5, material=Material(permanent="glued")),
        lambda: step.set_material("block", "block", Material()),
        lambda: step.set_material("block", "bone", Material()),
    ):
        with pytest.raises(InputError):
            call()


def test_overlapping_views_are_refused():
    scene, x, v = falling_ball()
    both = np.zeros((len(x) + 1, 3))
    with pytest.raises(InputError, match="v is in use"):
        ContactStep(scene, margin=0.5).correct(both[:-1], both[1:], h=H)


def test_an_array_in_use_is_refused_by_another_thread():
    scene, x, v = falling_ball()
    other, _, _ = falling_ball()
    steps = [ContactStep(scene, margin=0.5), ContactStep(other, margin=0.5)]
    refusals, done = [], []

    def correct(step: ContactStep, velocities: np.ndarray) -> None:
        for _ in range(200):
            try:
                step.correct(x, velocities, h=H, threads=1)
                done.append(1)
            except InputError as error:
                refusals.append(str(error))

    threads = [threading.Thread(target=correct, args=pair) for pair in zip(steps, (v, v.copy()))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(done) + len(refusals) == 400 and np.isfinite(x).all()
    assert all("x is in use" in refusal for refusal in refusals)
