"""Fields, medial surfaces, files, and the program's answers."""

import copy
import csv
import json
import pickle
import subprocess
import tomllib
import warnings

import numpy as np
import pytest
from conftest import REPOSITORY, box, sphere

import musculo_collide
from musculo_collide import (
    DistanceField,
    FileError,
    InputError,
    InputTypeError,
    Mesh,
    Scene,
    medial,
    read_mesh,
    write_mesh,
)


def test_a_field_of_a_ball_has_its_distances(tmp_path):
    field = DistanceField.build(*sphere((0, 0, 0), 10, 60), spacing=0.5, padding=2.0)
    rng = np.random.default_rng(7)
    points = rng.normal(size=(2000, 3))
    points *= (rng.uniform(9, 11, 2000) / np.linalg.norm(points, axis=1))[:, None]
    distances, gradients = field.query_with_gradients(points)
    assert np.abs(distances - (np.linalg.norm(points, axis=1) - 10)).max() < 0.05
    assert np.abs(np.linalg.norm(gradients, axis=1) - 1).max() < 0.1
    assert np.array_equal(field.query(points), distances)
    assert np.isinf(field.query([[100.0, 0, 0]]))[0]
    assert field.measured_error.max < 0.05 and field.error_bound is not None and not field.warnings

    for name in ("ball.nrrd", "ball.vti"):
        field.write(tmp_path / name)
        again = DistanceField.read(tmp_path / name)
        assert np.array_equal(again.query(points), distances)
        assert np.array_equal(again.values(), field.values()) and again.measured_error is None
    with pytest.raises(FileError, match=r"expected \.nrrd or \.vti"):
        field.write(tmp_path / "ball.txt")
    with pytest.raises(FileError, match="missing.nrrd"):
        DistanceField.read(tmp_path / "missing.nrrd")


def test_a_field_has_all_distances_unless_it_is_truncated():
    cube, middle = box((0, 0, 0), (50, 50, 50)), [[25.0, 25.0, 25.0]]
    assert DistanceField.build(*cube, spacing=1.0).query(middle) == pytest.approx([-25.0], abs=0.5)
    assert DistanceField.build(*cube, spacing=1.0, truncation=15.0).query(middle) == pytest.approx([-15.0])


def test_warnings_of_a_field_are_sentences():
    cut = box((0, 0, 0), (10, 10, 10))
    field = DistanceField.build(cut.vertices, cut.faces[1:], spacing=4.0)
    assert "the surface is open, with 3 boundary edges" in " ".join(field.warnings)
    assert any("spans 2.50 cells" in warning for warning in field.warnings)
    assert field.error_bound is None


def test_bad_fields_are_refused():
    ball = sphere((0, 0, 0), 10, 8)
    with pytest.raises(InputError, match="spacing"):
        DistanceField.build(*ball, spacing=0.0)
    with pytest.raises(InputError, match="memory|bytes"):
        DistanceField.build(*ball, spacing=1e-4)
    with pytest.raises(InputError, match=r"points are n × 3"):
        DistanceField.build(*ball, spacing=1.0).query([1.0, 2.0, 3.0])
    field = DistanceField.build(*ball, spacing=2.0)
    for bad in (np.nan, np.inf, -np.inf):
        for call in (field.query, field.query_with_gradients):
            with pytest.raises(InputError, match="point 1 is not finite"):
                call([[0, 0, 0], [0, bad, 0]])


def test_a_medial_surface_fills_its_surface():
    found = medial.generate(*sphere((0, 0, 0), 10, 24), balls=4)
    assert found.centers.shape == (4, 3) and found.radii.max() < 10.5
    assert found.rms_deviation <= found.max_deviation
    for sizes in ({}, {"balls": 3, "tolerance": 0.1}, {"balls": 0}, {"tolerance": -1.0}):
        with pytest.raises(InputError):
            medial.generate(*sphere((0, 0, 0), 10, 8), **sizes)
    with pytest.raises(InputError, match="edge"):
        medial.generate([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], balls=3)


@pytest.mark.parametrize("extension", ["ply", "obj", "off", "stl", "vtp"])
def test_meshes_survive_files(tmp_path, extension):
    mesh = box((0, 0, 0), (1, 2, 3))
    path = tmp_path / f"box.{extension}"
    write_mesh(path, *mesh)
    again = read_mesh(path)
    assert np.array_equal(again.vertices[again.faces], mesh.vertices[mesh.faces])


@pytest.mark.parametrize("extension", ["ply", "obj", "off", "stl", "vtp"])
def test_meshes_state_their_space(tmp_path, extension):
    path = tmp_path / f"box.{extension}"
    x, faces = box((0, 0, 0), (1, 2, 3))
    for space in (None, "LPS", "RAS"):
        write_mesh(path, x, faces, space=space)
        mesh = read_mesh(path)
        assert mesh.space == space and Mesh(*mesh).space is None
        for again in (pickle.loads(pickle.dumps(mesh)), copy.copy(mesh)):
            assert again == mesh and again.space == space
        assert len(mesh) == 2 and mesh.to_dict().keys() == {"vertices", "faces"}
    with pytest.raises(InputError, match="space is 'ras'"):
        write_mesh(path, x, faces, space="ras")
    with pytest.raises(InputTypeError, match="space"):
        write_mesh(path, x, faces, space=5)
    assert read_mesh(path).space == "RAS"


def test_parts_of_a_model_are_meshes(tmp_path):
    path = tmp_path / "two.feb"
    nodes = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1)]
    lines = [f'<node id="{n}">{x},{y},{z}</node>' for n, (x, y, z) in enumerate(nodes, 1)]
    parts = {"upper": "1,2,3,4", "lower": "1,3,2,5"}
    for name, corners in parts.items():
        lines.append(f'<Elements type="tet4" name="{name}"><elem id="1">{corners}</elem></Elements>')
    text = "<Nodes>" + "".join(lines[:5]) + "</Nodes>" + "".join(lines[5:])
    path.write_text(f'<febio_spec version="4.0"><Mesh>{text}</Mesh></febio_spec>')
    for name, tip in (("upper", 1.0), ("lower", -1.0)):
        mesh = read_mesh(path, parts=[name])
        assert mesh.vertices[-1].tolist() == [0.0, 0.0, tip] and mesh.faces.shape == (4, 3)
    assert read_mesh(path, parts=["upper", "lower"]).faces.shape == (6, 3)
    with pytest.raises(FileError, match="has the parts 'upper', 'lower'"):
        read_mesh(path)
    with pytest.raises(FileError, match="no part 'tibia'"):
        read_mesh(path, parts=["tibia"])
    with pytest.raises(InputTypeError, match="parts"):
        read_mesh(path, parts="upper")

    # A part is rigid by its material.
    rigid = '<Material><material id="1" name="bone" type="rigid body"/></Material>'
    domains = '<MeshDomains><SolidDomain name="lower" mat="bone"/></MeshDomains>'
    path.write_text(f'<febio_spec version="4.0">{rigid}<Mesh>{text}</Mesh>{domains}</febio_spec>')
    assert read_mesh(path, parts=["lower"]).rigid and not read_mesh(path, parts=["upper"]).rigid


def test_instances_of_an_abaqus_model_are_meshes_where_they_are_placed(tmp_path):
    path = tmp_path / "two.inp"
    nodes = "*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"
    part = f"*Part, name=p\n{nodes}*Element, type=C3D4\n1,1,2,3,4\n*End Part\n"
    place = "0, 0, 5\n0, 0, 0, 0, 0, 1, 90\n"
    left, right = ("*Instance, name=" + name + ", part=p\n" for name in ("left", "right"))
    end = "*End Instance\n"
    path.write_text(f"{part}*Assembly\n{left}{end}{right}{place}{end}*End Assembly\n")
    assert read_mesh(path, parts=["left"]).vertices[1].tolist() == [1.0, 0.0, 0.0]
    assert read_mesh(path, parts=["RIGHT"]).vertices[1].tolist() == [0.0, 1.0, 5.0]
    with pytest.raises(FileError, match="has the parts 'left', 'right'"):
        read_mesh(path)


def test_what_a_file_holds_beside_its_mesh_is_a_warning(tmp_path):
    path = tmp_path / "ball.ply"
    write_mesh(path, *sphere((0, 0, 0), 2.0, 12))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        whole = read_mesh(path)

    path.write_bytes(path.read_bytes() + b"more")
    with pytest.warns(UserWarning, match="ball.ply.*4 bytes") as caught:
        again = read_mesh(path)
    assert caught[0].filename == __file__
    assert np.array_equal(again.vertices, whole.vertices)


def test_bad_files_are_refused(tmp_path):
    with pytest.raises(FileError, match="no.ply"):
        read_mesh(tmp_path / "no.ply")
    with pytest.raises(OSError, match=r"expected \.ply"):
        write_mesh(tmp_path / "box.txt", *box((0, 0, 0), (1, 1, 1)))
    (tmp_path / "bad.ply").write_text("ply\nformat ascii 1.0\n")
    with pytest.raises(FileError, match="bad.ply"):
        read_mesh(tmp_path / "bad.ply")


def test_the_program_has_the_same_numbers_to_the_bit(thigh_folder, tmp_path):
    program = REPOSITORY / "target" / "release" / "musculo-collide"
    if not program.exists():
        pytest.skip("the program is not built: cargo build --release")
    out = tmp_path / "check.json"
    arguments = ["check", thigh_folder / "scene.toml", "--json", out, "--table", tmp_path / "check.csv"]
    subprocess.run([program, *arguments], capture_output=True)
    expected = json.loads(out.read_text())["pairs"]

    description = tomllib.loads((thigh_folder / "scene.toml").read_text())
    scene = Scene()
    for body in description["body"]:
        mesh = read_mesh(thigh_folder / body["file"])
        scene.add(body["name"], *mesh, rigid=body["kind"] == "rigid")
    for pair in description["ignore"]:
        scene.ignore(pair["a"], pair["b"])
    pairs = scene.check(description["margin"])

    assert len(pairs) == len(expected) > 0

    # Every number by its name, and the same rows as the table.
    table = pairs.to_long_table("thigh")
    own = list(zip(table["a"], table["b"], table["measure"], table["value"]))
    with (tmp_path / "check.csv").open(newline="") as file:
        rows = [(row["a"], row["b"], row["measure"], float(row["value"])) for row in csv.DictReader(file)]
    assert own == rows and len(rows) > 20 * len(pairs)
    for record in expected:
        for a_or_b, depth in (("a", record["depth_of_a_in_b"]), ("b", record["depth_of_b_in_a"])):
            other = "b" if a_or_b == "a" else "a"
            own_depth = getattr(pairs[record["a"], record["b"]], f"depth_of_{a_or_b}_in_{other}")
            assert (own_depth is None) == (depth is None)
            if depth:
                assert list(own_depth.point) == depth["point"] and list(own_depth.foot) == depth["foot"]
        if record["overlap"]:
            total = pairs[record["a"], record["b"]].overlap.total
            assert list(total.centroid) == record["overlap"]["centroid"]
            assert list(total.normal) == record["overlap"]["normal"]
            assert list(total.inside_vertices) == record["overlap"]["inside_vertices"]


def test_the_version_is_that_of_the_crates():
    manifest = tomllib.loads((REPOSITORY / "Cargo.toml").read_text())
    assert musculo_collide.__version__ == manifest["workspace"]["package"]["version"]
