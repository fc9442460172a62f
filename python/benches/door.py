"""Cost of the way through Python: of a check beside the library's own time, and of a second thread.

    python python/benches/door.py

Runs take turns, and the best of each counts: on an idle machine, since the last figure needs two processors.
With MUSCULO_DATA the thigh is that of the data folder. Ends with status 1 where a figure falls short.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable

from peers import bodies

from musculo_collide import Mesh, Scene, _native

TURNS = 40
MARGIN = 1.0


def thigh(meshes: dict[str, Mesh]) -> Scene:
    """Return a scene of some meshes."""
    scene = Scene()
    for name, mesh in meshes.items():
        scene.add(name, *mesh)
    return scene


def seconds(call: Callable[[], object]) -> float:
    """Return the time of a call."""
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def overhead(scene: Scene, threads: int | None) -> float:
    """Return what a check takes beyond the library's own time, relative to that.

    The way there is short, so that some run of it is not interrupted; of the check the processor's time counts.
    """
    ways, checks = [], []
    for _ in range(TURNS):
        before, begin = _native.computed_seconds(), time.process_time()
        whole = seconds(lambda: scene.check(MARGIN, threads=threads))
        checks.append(time.process_time() - begin)
        ways.append(whole - (_native.computed_seconds() - before))
    return min(ways) / (min(checks) - min(ways))


def gain(scenes: list[Scene]) -> float:
    """Return how much faster two Python threads check one scene each than one thread both."""

    def in_one_thread() -> None:
        for scene in scenes:
            scene.check(MARGIN, threads=1)

    def in_two_threads() -> None:
        threads = [threading.Thread(target=scene.check, args=(MARGIN,), kwargs={"threads": 1}) for scene in scenes]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    one, two = [], []
    for _ in range(TURNS):
        one.append(seconds(in_one_thread))
        two.append(seconds(in_two_threads))
    return min(one) / min(two)


def main() -> int:
    meshes = bodies()
    scene, other = thigh(meshes), thigh(meshes)
    faces = sum(len(mesh.faces) for mesh in meshes.values())
    print(f"check of {len(meshes)} bodies, {faces} faces")

    is_short = False
    for name, figure, limit, is_met in (
        ("overhead, one thread", found := overhead(scene, 1), "at most 0.05", found <= 0.05),
        ("overhead, all threads", found := overhead(scene, None), "at most 0.05", found <= 0.05),
        ("two Python threads / one", found := gain([scene, other]), "at least 1.8", found >= 1.8),
    ):
        is_short |= not is_met
        print(f"{name:26} {figure:7.3f}  {limit}  {'ok' if is_met else 'SHORT'}")
    return int(is_short)


if __name__ == "__main__":
    sys.exit(main())
