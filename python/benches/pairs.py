"""Answers of packages for Python about pairs of bodies, and their times, in one process.

Reads bodies, pairs and questions as JSON from standard input; prints one line of JSON per package and question.
`cargo xtask chart peers` runs it where there is a Python, compares the answers with exact ones and draws them.

    pip install trimesh python-fcl coal libigl manifold3d rtree scipy
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import sys
import time
from collections.abc import Callable
from typing import Any

try:
    import numpy as np
except ImportError:
    sys.exit("numpy is not installed")

# Rounds over all pairs, of which the quickest counts, and the seconds after which there are no more.
ROUNDS = 3
LONG = 3.0

# Contacts that a package may return for a pair.
CONTACTS = 100_000


class Fcl:
    """python-fcl: trees of oriented boxes and swept spheres. Its depth is the largest of two faces."""

    module = "fcl"
    distribution = "python-fcl"

    def __init__(self, fcl: Any, reach: float) -> None:
        self.fcl = fcl

    def body(self, vertices: np.ndarray, faces: np.ndarray) -> Any:
        model = self.fcl.BVHModel()
        model.beginModel(len(vertices), len(faces))
        model.addSubModel(vertices, faces.astype(np.int32))
        model.endModel()
        return self.fcl.CollisionObject(model)

    def overlap(self, a: Any, b: Any) -> float:
        return float(self.fcl.collide(a, b, self.fcl.CollisionRequest(), self.fcl.CollisionResult()) > 0)

    def gap(self, a: Any, b: Any) -> float:
        return self.fcl.distance(a, b, self.fcl.DistanceRequest(), self.fcl.DistanceResult())

    def depth(self, a: Any, b: Any) -> float:
        result = self.fcl.CollisionResult()
        self.fcl.collide(a, b, self.fcl.CollisionRequest(num_max_contacts=CONTACTS, enable_contact=True), result)
        return max((contact.penetration_depth for contact in result.contacts), default=0.0)


class Coal:
    """coal: trees as python-fcl's. Its depth is the largest of two faces."""

    module = distribution = "coal"

    def __init__(self, coal: Any, reach: float) -> None:
        self.coal, self.at = coal, coal.Transform3s.Identity()

    def body(self, vertices: np.ndarray, faces: np.ndarray) -> Any:
        model = self.coal.BVHModelOBBRSS()
        model.beginModel(len(faces), len(vertices))
        model.addVertices(vertices)
        model.addTriangles(faces)
        model.endModel()
        return model

    def contacts(self, a: Any, b: Any, limit: int) -> Any:
        request, result = self.coal.CollisionRequest(), self.coal.CollisionResult()
        request.num_max_contacts = limit
        self.coal.collide(a, self.at, b, self.at, request, result)
        return result

    def overlap(self, a: Any, b: Any) -> float:
        return float(self.contacts(a, b, 1).isCollision())

    def gap(self, a: Any, b: Any) -> float:
        return self.coal.distance(a, self.at, b, self.at, self.coal.DistanceRequest(), self.coal.DistanceResult())

    def depth(self, a: Any, b: Any) -> float:
        found = self.contacts(a, b, CONTACTS).getContacts()
        return max((-contact.penetration_depth for contact in found), default=0.0)


class Trimesh:
    """trimesh: python-fcl behind a manager, manifold3d for volumes, depths of vertices by its own search."""

    module = distribution = "trimesh"

    def __init__(self, trimesh: Any, reach: float) -> None:
        self.trimesh = trimesh

    def body(self, vertices: np.ndarray, faces: np.ndarray) -> Any:
        mesh = self.trimesh.Trimesh(vertices, faces, process=False)
        manager = self.trimesh.collision.CollisionManager()
        manager.add_object("body", mesh)
        return mesh, manager

    def overlap(self, a: Any, b: Any) -> float:
        return float(a[1].in_collision_other(b[1]))

    def gap(self, a: Any, b: Any) -> float:
        return a[1].min_distance_other(b[1])

    def depth(self, a: Any, b: Any) -> float:
        return deepest_vertex(a[0], b[0], self.trimesh.proximity.signed_distance)

    def volume(self, a: Any, b: Any) -> float:
        return float(self.trimesh.boolean.intersection([a[0], b[0]], engine="manifold").volume)


class Libigl:
    """libigl: CGAL for crossings and volumes, exactly; depths of vertices by pseudonormals."""

    module, distribution = "igl", "libigl"

    def __init__(self, igl: Any, reach: float) -> None:
        self.igl, self.cgal = igl, importlib.import_module("igl.copyleft.cgal")

    def body(self, vertices: np.ndarray, faces: np.ndarray) -> Any:
        return Triangles(vertices, faces.astype(np.int64))

    def overlap(self, a: Any, b: Any) -> float:
        found = self.cgal.intersect_other(a.vertices, a.faces, b.vertices, b.faces, detect_only=True, first_only=True)
        return float(len(found[0]) > 0)

    def depth(self, a: Any, b: Any) -> float:
        return deepest_vertex(a, b, lambda mesh, points: -self.igl.signed_distance(points, mesh.vertices, mesh.faces)[0])

    def volume(self, a: Any, b: Any) -> float:
        vertices, faces, _ = self.cgal.mesh_boolean(a.vertices, a.faces, b.vertices, b.faces, "intersect")
        corners = vertices[faces]
        return float(np.linalg.det(corners).sum() / 6.0)


class Manifold:
    """manifold3d: a boolean mesh, whose volume is that of the overlap."""

    module = distribution = "manifold3d"

    def __init__(self, manifold3d: Any, reach: float) -> None:
        self.manifold3d, self.reach = manifold3d, reach

    def body(self, vertices: np.ndarray, faces: np.ndarray) -> Any:
        solid = self.manifold3d.Manifold(self.manifold3d.Mesh64(vertices, faces.astype(np.uint64)))
        return None if solid.is_empty() else solid

    def overlap(self, a: Any, b: Any) -> float:
        return float(not (a ^ b).is_empty())

    def gap(self, a: Any, b: Any) -> float:
        return a.min_gap(b, self.reach)

    def volume(self, a: Any, b: Any) -> float:
        return (a ^ b).volume()


LIBRARIES = [Fcl, Coal, Trimesh, Libigl, Manifold]


class Triangles:
    """Arrays of a surface."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices, self.faces = vertices, faces


def deepest_vertex(a: Any, b: Any, depths: Callable[[Any, np.ndarray], np.ndarray]) -> float:
    """Return the greatest depth of a vertex of either mesh in the other, of those in its box."""
    deepest = 0.0
    for mesh, other in ((a, b), (b, a)):
        lower, upper = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        within = ((other.vertices >= lower) & (other.vertices <= upper)).all(axis=1)
        if within.any():
            deepest = max(deepest, float(depths(mesh, np.asarray(other.vertices[within])).max()))
    return deepest


def answer(library: Any, question: str, pairs: list[list[int]], bodies: list[Any]) -> tuple[float, list[float | None]]:
    """Return the least processor time of a few rounds over all pairs, and the answers: None where one is refused."""
    ask, times, answers = getattr(library, question), [], []
    while len(times) < ROUNDS and sum(times) < LONG:
        begin, answers = time.process_time(), []
        for a, b in pairs:
            try:
                value = float(ask(bodies[a], bodies[b]))
                answers.append(value if np.isfinite(value) else None)
            except Exception:  # whatever a package raises is a refusal
                answers.append(None)
        times.append(time.process_time() - begin)
    return min(times), answers


def answer_pairs() -> None:
    """Answer the questions of standard input about its bodies, by every package that is installed."""
    asked = json.load(sys.stdin)
    meshes = [(np.array(mesh["vertices"]), np.array(mesh["faces"])) for mesh in asked["bodies"]]
    missing = []
    for kind in LIBRARIES:
        try:
            library = kind(importlib.import_module(kind.module), asked["reach"])
        except ImportError:
            missing.append(kind.distribution)
            continue
        begin = time.process_time()
        bodies = [library.body(*mesh) for mesh in meshes]
        preparation = time.process_time() - begin

        version = ".".join(importlib.metadata.version(kind.distribution).split(".")[:2])
        for question, pairs in asked["questions"].items():
            if hasattr(library, question):
                seconds, answers = answer(library, question, pairs, bodies)
                line = {
                    "library": f"{kind.distribution} {version}",
                    "question": question,
                    "time": 1e6 * seconds / max(1, len(pairs)),
                    "preparation": 1e6 * preparation / len(meshes),
                    "answers": answers,
                }
                print(json.dumps(line), flush=True)
    if missing:
        print(f"skipped, not installed: {', '.join(missing)}", file=sys.stderr)


if __name__ == "__main__":
    answer_pairs()
