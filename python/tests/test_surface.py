"""Exact questions of points to one surface."""

import threading

import numpy as np
import pytest
from conftest import box, sphere

from musculo_collide import InputError, MusculoCollideError, Surface


def test_distances_to_a_box_are_those_of_the_closed_form():
    points = np.random.default_rng(3).uniform(-2, 4, (5000, 3))
    surface = Surface(*box((0, 0, 0), (1, 2, 3)))
    center, half = np.array([0.5, 1, 1.5]), np.array([0.5, 1, 1.5])
    q = np.abs(points - center) - half
    expected = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)

    for threads in (None, 1, 2):
        distances = surface.signed_distance(points, threads=threads)
        assert np.abs(distances - expected).max() < 1e-14
        assert np.array_equal(surface.contains(points, threads=threads), expected < 0)
    closest = surface.closest_points(points)
    assert np.array_equal(closest.distances, np.abs(distances))
    assert np.abs(np.linalg.norm(closest.points - points, axis=1) - closest.distances).max() < 1e-15
    assert closest.faces.max() < 12


def test_points_on_the_surface_are_not_inside():
    surface = Surface(*box((0, 0, 0), (1, 1, 1)))
    on = [[0, 0, 0], [0.5, 0.5, 0], [1, 0.25, 0.75]]
    assert not surface.contains(on).any()
    assert np.array_equal(surface.signed_distance(on), [0, 0, 0])
    assert len(surface.signed_distance(np.zeros((0, 3)))) == 0


def test_open_surfaces_have_closest_points_and_no_inside():
    sheet = Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert "odd number of faces" in sheet.no_inside
    assert np.array_equal(sheet.closest_points([[0.25, 0.25, 2]]).distances, [2])
    for call in (sheet.contains, sheet.signed_distance):
        with pytest.raises(InputError, match="no inside"):
            call([[0, 0, 0]])
    assert Surface(*sphere((0, 0, 0), 1, 6)).no_inside is None


def test_bad_points_are_refused():
    surface = Surface(*box((0, 0, 0), (1, 1, 1)))
    with pytest.raises(InputError, match="point 1 is not finite"):
        surface.contains([[0, 0, 0], [np.nan, 0, 0]])
    for call in (surface.contains, surface.signed_distance, surface.closest_points):
        with pytest.raises(InputError, match=r"point 2 has the coordinate 1e155, but magnitudes end at 1e30"):
            call([[0, 0, 0], [0, 1e30, 0], [0, 0, -1e155]])
    assert surface.signed_distance([[1e30, 0, 0]]) == pytest.approx(1e30)
    with pytest.raises(InputError, match="no faces"):
        Surface([[0, 0, 0]], np.zeros((0, 3), int))


def test_two_surfaces_share_a_planted_box():
    a, b = Surface(*box((0, 0, 0), (10, 10, 10))), Surface(*box((8, 1, -1), (20, 9, 11)))
    overlap = a.overlap(b)
    assert overlap.total.volume == pytest.approx(160, rel=1e-14) and len(overlap.regions) == 1
    assert overlap.total.curve_length == pytest.approx(44)
    assert a.overlap(Surface(*box((11, 0, 0), (12, 1, 1)))) is None
    of_a, of_b = a.depths(b)
    assert of_a.lower <= 2 <= of_a.upper <= 2.02 and of_b.lower <= 2 <= of_b.upper <= 2.02
    narrow, _ = a.depths(b, width=1e-7)
    assert narrow.lower <= 2 <= narrow.upper <= narrow.lower + 1e-7 and narrow.is_narrow
    assert a.depths(Surface(*box((11, 0, 0), (12, 1, 1)))) == (None, None)
    for width in (0.0, -1.0, float("nan"), "1"):
        with pytest.raises(MusculoCollideError, match="width"):
            a.depths(b, width=width)
    within = a.overlap(Surface(*box((4, 4, 4), (5, 5, 5))))
    assert within.total.volume == pytest.approx(1)


def test_points_that_another_thread_spoils_are_refused_and_none_left_out():
    surface, points = Surface(*sphere((0, 0, 0), 1, 60)), np.full((400_000, 3), 0.5)
    spoil = threading.Timer(0.02, points.fill, [np.nan])
    spoil.start()
    with pytest.raises(InputError, match="finite"):
        surface.closest_points(points, threads=1)
    spoil.join()
