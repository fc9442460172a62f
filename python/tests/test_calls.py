"""Threads, progress, interruption, memory."""

import gc
import os
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import muscle, sphere

from musculo_collide import DistanceField, Scene, medial


def balls(divisions: int) -> Scene:
    scene = Scene()
    scene.add("a", *sphere((0, 0, 0), 10, divisions), rigid=True)
    scene.add("b", *sphere((15, 0, 0), 10, divisions))
    return scene


def test_results_have_the_same_bits_for_any_number_of_threads():
    expected = balls(40).check(margin=1.0)
    for threads in (1, 2, 7):
        scene = balls(40)
        assert scene.check(margin=1.0, threads=threads) == expected
        assert scene.resolve(threads=threads) == balls(40).resolve(threads=1)


def test_progress_rises_and_its_exceptions_end_the_call():
    seen = []
    medial.generate(*muscle(30), balls=12, threads=2, progress=seen.append)
    assert all(0 <= share <= 1 for share in seen)
    assert seen == sorted(seen)

    class Stop(Exception):
        pass

    def stop(share: float) -> None:
        raise Stop(share)

    for threads in (1, 2, None):
        with pytest.raises(Stop):
            medial.generate(*muscle(60), balls=12, threads=threads, progress=stop)


def test_an_interrupted_resolution_leaves_the_scene_as_it_was():
    scene = balls(100)
    before = scene.vertices("b")

    def stop(share: float) -> None:
        raise RuntimeError

    with pytest.raises(RuntimeError):
        scene.resolve(threads=1, progress=stop)
    assert np.array_equal(scene.vertices("b"), before)
    assert len(scene.check()) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals of POSIX")
@pytest.mark.parametrize("threads", ["1", "2", "None"])
def test_ctrl_c_ends_a_long_call(threads):
    script = f"""
import sys, time
sys.path.insert(0, {os.path.dirname(__file__)!r})
from conftest import muscle
from musculo_collide import medial
mesh = muscle(120)
print("begin", flush=True)
try:
    medial.generate(*mesh, balls=12, threads={threads})
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begin\n"
    time.sleep(0.4)
    process.send_signal(signal.SIGINT)
    begin = time.perf_counter()
    out, _ = process.communicate(timeout=60)
    assert out == "interrupted\n"
    assert time.perf_counter() - begin < 10, "of a call that takes far longer"


def test_the_lock_is_released_and_a_second_thread_is_refused():
    scene = balls(100)
    errors, beats = [], []

    def use_too() -> None:
        while not beats:
            time.sleep(0.001)
        try:
            scene.check()
        except RuntimeError as error:
            errors.append(error)

    other = threading.Thread(target=use_too)
    other.start()

    def beat(share: float) -> None:
        beats.append(share)
        other.join(0.05)

    scene.resolve(threads=2, progress=beat)
    other.join()
    assert not beats or errors, "while one thread resolves, the other cannot check"


def test_two_threads_use_one_scene_each():
    expected = balls(30).check()
    results = [None, None]

    def check(number: int) -> None:
        scene = balls(30)
        for _ in range(5):
            results[number] = scene.check(threads=1)

    threads = [threading.Thread(target=check, args=(number,)) for number in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected, expected]


def test_points_of_a_query_are_read_where_they_are():
    field = DistanceField.build(*sphere((0, 0, 0), 10, 20), spacing=1.0)
    points = np.random.default_rng(1).uniform(-8, 8, (1000, 3))
    from musculo_collide import _arrays

    assert np.shares_memory(_arrays.points(points, "points"), points)
    view = points[::2]
    assert not np.shares_memory(_arrays.points(view, "points"), points)
    assert np.array_equal(field.query(points)[::2], field.query(view))
    frozen = points.copy()
    frozen.flags.writeable = False
    assert np.array_equal(field.query(frozen), field.query(points))


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource")
def test_ten_thousand_calls_leak_nothing():
    scene = balls(6)

    def calls(count: int) -> None:
        for _ in range(count):
            scene.check(margin=1.0, threads=1)
            scene.vertices("b")
            with pytest.raises(ValueError):
                scene.vertices("c")

    def peak() -> int:
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    calls(500)
    before = peak()
    calls(10_000)
    assert peak() - before < 4096, "kilobytes"
