"""The example of a cohort, over Dask and in one process."""

import csv
import subprocess
import sys

import pytest
from conftest import REPOSITORY

COHORT = REPOSITORY / "python" / "examples" / "cohort"


@pytest.fixture
def cohort(monkeypatch):
    monkeypatch.syspath_prepend(str(COHORT))
    import subjects

    return subjects


def test_a_bad_subject_is_named_and_what_is_known_is_not_computed_again(cohort, monkeypatch, tmp_path):
    pytest.importorskip("dask")
    monkeypatch.setattr(cohort, "BAD", 1)
    cohort.make(tmp_path / "subjects", 3)

    def run() -> str:
        command = [sys.executable, "with_dask.py", tmp_path / "subjects", tmp_path / "out"]
        done = subprocess.run(command, cwd=COHORT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    first = run()
    assert "p01 is skipped" in first and "sartorius.ply" in first
    assert "3 subjects, 3 computed, 1 skipped" in first
    with (tmp_path / "out" / "cohort.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["subject"] for row in rows} == {"p00", "p02"}

    # Only what has no table is computed: the bad one, and one whose files have another content.
    assert "3 subjects, 1 computed, 1 skipped" in run()
    scene = tmp_path / "subjects" / "p00" / "scene.toml"
    scene.write_text(scene.read_text().replace("margin = 1.0", "margin = 1.5"))
    (tmp_path / "subjects" / "p02" / "scene.toml").touch()
    assert "3 subjects, 2 computed, 1 skipped" in run()
