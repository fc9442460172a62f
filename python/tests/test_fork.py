"""Calls in the child of a fork, which has none of its parent's threads."""

import os

import pytest
from test_calls import run_script

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")

PREPARE = """
import multiprocessing, os, signal, warnings
import numpy as np
from conftest import sphere
from musculo_collide import ContactStep, DistanceField, Plan, Scene, Surface, medial

# Python warns of every fork beside threads.
warnings.simplefilter("ignore", DeprecationWarning)
ball = sphere((0, 0, 0), 10, 24)
scene = Scene()
scene.add("a", *ball, rigid=True)
scene.add("b", *sphere((15, 0, 0), 10, 24))
surface, field = Surface(*ball), DistanceField.build(*ball, spacing=0.5)
points = np.random.default_rng(1).uniform(-9, 9, (100_000, 3))
plan, step = Plan(scene, tolerance=0.1, frames=1000), ContactStep(scene, margin=0.5, tolerance=1.0)
x = scene.particle_positions()

# The parent has used its threads.
scene.check(threads=2), scene.check(), field.query(points), plan.detect()


def in_a_child(compute, name=""):
    child = os.fork()
    if child == 0:
        # What hangs is ended by the alarm.
        signal.alarm(40)
        try:
            os._exit(0 if compute() else 1)
        finally:
            os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0, name
"""

CALLS = {
    "add": "Scene().add('c', *ball)",
    "move": "scene.move('b', scene.vertices('b') + 0.1)",
    "pose": "scene.pose('a', np.eye(4))",
    "check": "scene.check(margin=1.0)",
    "check on two threads": "scene.check(margin=1.0, threads=2)",
    "check on one thread": "scene.check(margin=1.0, threads=1)",
    "sweep": "scene.sweep({'b': scene.vertices('b') - [9, 0, 0]})",
    "joint": "scene.joint_contact('a', 'b', resolution=0.5)",
    "resolve": "scene.resolve()",
    "plan": "Plan(scene, tolerance=0.1, frames=1000)",
    "detect": "plan.detect()",
    "respond": "plan.respond()",
    "coarse": "step.set_coarse('b')",
    "field of a step": "step.set_field('a', field)",
    "balls": "step.set_balls('b', tolerance=1.0)",
    "bone": "step.move_bone('a', np.eye(4))",
    "correct": "step.correct(x, np.zeros_like(x), h=0.01)",
    "surface": "Surface(*ball)",
    "distances": "surface.signed_distance(points)",
    "overlap": "surface.overlap(surface)",
    "depths": "surface.depths(surface)",
    "field": "DistanceField.build(*ball, spacing=0.5)",
    "query": "field.query(points)",
    "medial": "medial.generate(*ball, balls=4)",
}


def test_each_call_in_a_child_ends():
    # One child per call, which all have the same parent.
    children = (f"in_a_child(lambda: ({call}, True)[1], {name!r})" for name, call in CALLS.items())
    run_script(PREPARE + "\n".join(children))


def test_results_in_a_child_have_the_same_bits():
    run_script(PREPARE + """
expected, distances = scene.check(margin=1.0), field.query(points)
for threads in (None, 1, 2):
    in_a_child(lambda: scene.check(margin=1.0, threads=threads) == expected)
in_a_child(lambda: np.array_equal(field.query(points), distances))
""")


def test_a_child_of_a_child_and_processes_of_multiprocessing_compute():
    run_script(PREPARE + """
def checked(number):
    return len(scene.check(margin=1.0)) + len(scene.check(margin=1.0, threads=2))

# A child that has computed has threads, too.
in_a_child(lambda: (checked(0), in_a_child(lambda: checked(0) == 2)) and checked(0) == 2)
signal.alarm(60)
with multiprocessing.get_context("fork").Pool(2) as processes:
    assert processes.map(checked, range(4)) == [2] * 4
""")
