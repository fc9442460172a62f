"""Shapes that the tests share."""

import signal
from pathlib import Path

import numpy as np
import pytest

from musculo_collide import Mesh, Scene

# Jobs in the background of a script inherit an interruption that is ignored; tests send one.
signal.signal(signal.SIGINT, signal.default_int_handler)

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture
def thigh_folder() -> Path:
    return REPOSITORY / "fixtures" / "thigh"


def box(lower, upper) -> Mesh:
    """Return an axis-parallel box of 12 faces."""
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    corners = [[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    return Mesh(lower + np.array(corners) * (upper - lower), np.array(faces, np.uint32))


def sphere(center, radius, divisions=40) -> Mesh:
    """Return a ball whose faces are finer than most."""
    turns, rings = 2 * divisions, divisions
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.linspace(0, 2 * np.pi, turns, endpoint=False)
    around = np.stack(
        [np.outer(np.sin(theta), np.cos(phi)), np.outer(np.sin(theta), np.sin(phi)),
         np.outer(np.cos(theta), np.ones(turns))], axis=-1,
    ).reshape(-1, 3)  # fmt: skip
    vertices = np.vstack([around, [[0, 0, 1], [0, 0, -1]]]) * radius + np.asarray(center, float)
    top, bottom = len(around), len(around) + 1
    faces = []
    for j in range(turns):
        k = (j + 1) % turns
        faces += [(top, j, k), (bottom, (rings - 2) * turns + k, (rings - 2) * turns + j)]
        for i in range(rings - 2):
            a, b, c, d = i * turns + j, i * turns + k, (i + 1) * turns + j, (i + 1) * turns + k
            faces += [(a, c, d), (a, d, b)]
    return Mesh(vertices, np.array(faces, np.uint32))


def muscle(divisions: int) -> Mesh:
    """Return a long, flat ellipsoid."""
    ball = sphere((0, 0, 0), 10, divisions)
    return ball._replace(vertices=ball.vertices * [3, 1, 0.5])


@pytest.fixture
def two_boxes() -> Scene:
    """Two boxes that share a box of 2 × 8 × 10, one within the other's side."""
    scene = Scene()
    a, b = box((0, 0, 0), (10, 10, 10)), box((8, 1, -1), (20, 9, 11))
    scene.add("a", a.vertices, a.faces, rigid=True)
    scene.add("b", b.vertices, b.faces)
    return scene
