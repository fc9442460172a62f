"""Plans: what they detect beside the exact answer."""

import re

import numpy as np
import pytest
from conftest import box, muscle, sphere

from musculo_collide import InputError, Plan, Scene


@pytest.mark.parametrize("frames", [1, 10_000])
def test_a_plan_is_within_its_bound_of_the_exact_depth(frames):
    scene = Scene()
    scene.add("bone", *sphere((0, 0, 8), 5, 24), rigid=True)
    scene.add("muscle", *muscle(24))
    plan = Plan(scene, tolerance=0.5, frames=frames)
    (planned,) = plan.pairs
    assert planned.bound <= 0.5 and planned.method in ("exact", "coarse", "field")
    assert "bone" in str(plan)
    for up in (0.0, 0.5, 3.0):
        scene.pose("bone", [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, up], [0, 0, 0, 1]])
        found = {(pair.a, pair.b): pair for pair in plan.detect()}
        exact = scene.check(depth_tolerance=1e-6).overlapping
        if exact:
            lower, upper = found["bone", "muscle"].depth
            assert lower - 1e-6 <= exact[0].depth[1] and exact[0].depth[0] <= upper + 1e-6
            assert upper - lower <= 2 * 0.5


def test_a_bone_wholly_inside_is_seen():
    scene = Scene()
    scene.add("bone", *box((4, 4, 4), (6, 6, 6)), rigid=True)
    scene.add("muscle", *box((0, 0, 0), (10, 10, 10)))
    (found,) = Plan(scene, tolerance=0.2, frames=1000).detect()
    assert found.state == "overlapping" and found.depth[0] <= 4.0 <= found.depth[1]


def predicted(plan: Plan) -> tuple[float, list[float]]:
    """Return the predicted times that a plan prints: of a frame, and of its pairs."""
    text = str(plan)
    frame = float(re.search(r", ([0-9.]+) ms each by operation counts", text)[1]) / 1e3
    pairs = [float(line.split()[-1]) / 1e6 for line in text.splitlines() if line.startswith("ball")]
    return frame, pairs


def test_predicted_times_are_those_that_the_plan_prints():
    scene = Scene()
    for number in range(4):
        scene.add(f"ball {number}", *sphere((9 * number, 0, 0), 8, 60))
    shares = []
    for threads in (1, 2):
        plan = Plan(scene, tolerance=0.01, margin=1.0, frames=1000, threads=threads)
        frame, pairs = predicted(plan)
        assert [pair.predicted_seconds for pair in plan.pairs] == pytest.approx(pairs[-len(plan.pairs) :], abs=1e-7)
        shares.append(frame / sum(pair.predicted_seconds for pair in plan.pairs))
    # Pairs are by one thread, and a frame by all of them.
    assert shares[1] == pytest.approx(shares[0] / 2, rel=0.1)


def test_respond_moves_soft_bodies():
    scene = Scene()
    scene.add("bone", *sphere((0, 0, 8), 5, 24), rigid=True)
    scene.add("muscle", *muscle(24))
    before = scene.vertices("muscle")
    plan = Plan(scene, tolerance=0.1)
    deep = plan.detect()[0].depth[0]
    plan.respond()
    assert not np.array_equal(scene.vertices("muscle"), before)
    assert plan.detect()[0].depth[0] < deep


def test_bad_plans_are_refused():
    scene = Scene()
    scene.add("a", *box((0, 0, 0), (1, 1, 1)))
    for params in ({"tolerance": 0.0}, {"tolerance": 1.0, "margin": -1.0}, {"tolerance": 1.0, "frames": 0}):
        with pytest.raises(InputError):
            Plan(scene, **params)
    plan = Plan(scene, tolerance=1.0)
    scene.add("b", *box((0, 0, 0), (1, 1, 1)))
    with pytest.raises(InputError, match="other bodies"):
        plan.detect()
