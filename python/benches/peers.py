"""Time and answers of this package beside what Python users have, in one process, one thread each.

    pip install trimesh python-fcl libigl manifold3d ipctk rtree scipy
    MUSCULO_DATA=/path/to/folder python python/benches/peers.py

Without MUSCULO_DATA the generated thigh is used. Each row asks all packages the same questions and counts
wrong answers: differences from this package's exact ones.
"""

from __future__ import annotations

import itertools
import os
import time
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from musculo_collide import Mesh, Scene, Surface, read_mesh
from pairs import Fcl, Manifold

REPOSITORY = Path(__file__).resolve().parents[2]
REPEATS = 3


def bodies() -> dict[str, Mesh]:
    """Return the meshes of a thigh by name."""
    data = os.environ.get("MUSCULO_DATA")
    if data:
        folder = Path(data) / "anatomy" / os.environ.get("MUSCULO_SCENE", "vhf_left_thigh_lo")
        return {path.stem: read_mesh(path) for path in sorted(folder.glob("*.ply"))}
    folder = REPOSITORY / "fixtures" / "thigh"
    listed = tomllib.loads((folder / "scene.toml").read_text())["body"]
    return {body["name"]: read_mesh(folder / body["file"]) for body in listed if body["name"] != "fascia_lata"}


def best(function: Callable[[], object]) -> tuple[float, object]:
    """Return the shortest processor time of a few runs in seconds, and the answer."""
    times, answer = [], None
    for _ in range(REPEATS):
        begin = time.process_time()
        answer = function()
        times.append(time.process_time() - begin)
    return min(times), answer


def row(question: str, package: str, seconds: float, reference: float, wrong: str) -> None:
    print(f"| {question} | {package} | {1e3 * seconds:.1f} | {seconds / reference:.2f} | {wrong} |")


def overlapping(meshes: dict[str, Mesh]) -> None:
    """Ask which of all pairs overlap, with the transfer of the meshes."""
    question = f"which of {len(meshes) * (len(meshes) - 1) // 2} pairs overlap"

    def own() -> set[frozenset[str]]:
        scene = Scene()
        for name, mesh in meshes.items():
            scene.add(name, *mesh)
        pairs = scene.check(measures=False, threads=1)
        return {frozenset((pair.a, pair.b)) for pair in pairs.overlapping}

    reference, exact = best(own)
    row(question, "musculo_collide", reference, reference, "0")

    def wrong(found: set[frozenset[str]]) -> str:
        return f"{len(found - exact)} too many, {len(exact - found)} missing"

    import fcl

    def with_fcl() -> set[frozenset[str]]:
        library = Fcl(fcl, np.inf)
        objects = {name: library.body(*mesh) for name, mesh in meshes.items()}
        pairs = itertools.combinations(objects, 2)
        return {frozenset((a, b)) for a, b in pairs if library.overlap(objects[a], objects[b])}

    seconds, found = best(with_fcl)
    row(question, "python-fcl, every pair", seconds, reference, wrong(found))

    import trimesh

    def with_trimesh() -> set[frozenset[str]]:
        manager = trimesh.collision.CollisionManager()
        for name, mesh in meshes.items():
            manager.add_object(name, trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))
        return {frozenset(pair) for pair in manager.in_collision_internal(return_names=True)[1]}

    seconds, found = best(with_trimesh)
    row(question, "trimesh manager", seconds, reference, wrong(found))


def distances(meshes: dict[str, Mesh]) -> None:
    """Ask for the signed distance of 10,000 points around one body."""
    question = "signed distance of 10,000 points"
    mesh = max(meshes.values(), key=lambda mesh: len(mesh.faces))
    lower, upper = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = np.random.default_rng(5).uniform(lower, upper, (10_000, 3))

    reference, exact = best(lambda: Surface(*mesh).signed_distance(points, threads=1))
    row(question, "musculo_collide", reference, reference, "0")
    size = float(np.linalg.norm(upper - lower))

    def wrong(found: np.ndarray) -> str:
        return f"{np.count_nonzero(np.abs(found - exact) > 1e-9 * size)}"

    import igl

    faces = mesh.faces.astype(np.int64)
    seconds, found = best(lambda: igl.signed_distance(points, mesh.vertices, faces)[0])
    row(question, "libigl, pseudonormals", seconds, reference, wrong(found))

    import trimesh

    def with_trimesh() -> np.ndarray:
        surface = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        return -trimesh.proximity.signed_distance(surface, points)

    seconds, found = best(with_trimesh)
    row(question, "trimesh", seconds, reference, wrong(found))


def volumes(meshes: dict[str, Mesh]) -> None:
    """Ask for the volume that each overlapping pair shares."""
    scene = Scene()
    for name, mesh in meshes.items():
        scene.add(name, *mesh)
    pairs = [(pair.a, pair.b) for pair in scene.check(measures=False).overlapping]
    question = f"volume of {len(pairs)} overlaps"

    def own() -> list[float | None]:
        found = []
        for a, b in pairs:
            overlap = Surface(*meshes[a]).overlap(Surface(*meshes[b]))
            found.append(overlap.total.volume if overlap else 0.0)
        return found

    reference, exact = best(own)
    row(question, "musculo_collide, with areas and curve", reference, reference, "0")

    def with_depths() -> list[float | None]:
        found = []
        for a, b in pairs:
            two = Surface(*meshes[a]), Surface(*meshes[b])
            overlap, _ = two[0].overlap(two[1]), two[0].depths(two[1])
            found.append(overlap.total.volume if overlap else 0.0)
        return found

    seconds, found = best(with_depths)
    row(question, "musculo_collide, with certified depths, which no other has", seconds, reference, str(sum(map(float.__ne__, found, exact))))

    import manifold3d

    def with_manifold() -> list[float]:
        library = Manifold(manifold3d, np.inf)
        return [library.volume(*(library.body(*meshes[name]) for name in pair)) for pair in pairs]

    seconds, found = best(with_manifold)
    bad = sum(abs(a - b) > 1e-6 * abs(b) + 1e-9 for a, b in zip(found, exact))
    row(question, "manifold3d", seconds, reference, str(bad))


def contacts_in_motion(meshes: dict[str, Mesh]) -> None:
    """Ask for the free share of a step of two bodies, of which one moves."""
    question = "free share of a step of two bodies"
    names = sorted(meshes, key=lambda name: len(meshes[name].faces))[-2:]
    a, b = (meshes[name] for name in names)
    apart = b.vertices + (a.vertices.mean(axis=0) - b.vertices.mean(axis=0))
    apart[:, 0] += a.vertices[:, 0].max() - apart[:, 0].min() + 1.0
    end = apart - [a.vertices[:, 0].max() - a.vertices[:, 0].min(), 0, 0]

    def own() -> float:
        scene = Scene()
        scene.add("a", *a, rigid=True)
        scene.add("b", apart, b.faces)
        return scene.sweep({"b": end}, threads=1).largest_free_step

    reference, exact = best(own)
    row(question, "musculo_collide", reference, reference, "0")

    import ipctk

    faces = np.vstack([a.faces, b.faces + len(a.vertices)]).astype(np.int32)
    start = np.vstack([a.vertices, apart])
    stop = np.vstack([a.vertices, end])

    def with_ipctk() -> float:
        mesh = ipctk.CollisionMesh(start, ipctk.edges(faces), faces)
        return ipctk.compute_collision_free_stepsize(mesh, start, stop)

    seconds, found = best(with_ipctk)
    row(question, "ipctk", seconds, reference, f"{found:.6f} of {exact:.6f}")


def main() -> None:
    meshes = bodies()
    print(f"{len(meshes)} bodies, {sum(len(mesh.faces) for mesh in meshes.values())} faces\n")
    print("| question | package | time [ms] | beside this package | wrong answers |")
    print("|---|---|---|---|---|")
    for ask in (overlapping, distances, volumes, contacts_in_motion):
        try:
            ask(meshes)
        except Exception as error:  # a peer that is missing or refuses is a row of its own
            print(f"| {ask.__name__} | refused | | | {type(error).__name__}: {str(error)[:80]} |")


if __name__ == "__main__":
    main()
