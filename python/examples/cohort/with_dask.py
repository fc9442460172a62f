"""Check a cohort over Dask: one scene per process, one process per core.

    pip install dask
    python subjects.py && python with_dask.py [SUBJECTS] [OUT]

A subject whose table is there is not computed again, unless one of its files has another content. One
that cannot be read is named and skipped.
"""

import resource
import sys
import tomllib
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import dask
import tables

from musculo_collide import MusculoCollideError, Scene, read_mesh


def load(subject: Path) -> tuple[Scene, float]:
    """Return the scene of a subject, and its margin."""
    description = tomllib.loads((subject / "scene.toml").read_text())
    scene = Scene()
    for body in description["body"]:
        mesh = read_mesh(subject / body["file"])
        kind = body["kind"]
        scene.add(body["name"], mesh.vertices, mesh.faces, rigid=kind == "rigid", open=kind == "open")
    for pair in description.get("ignore", []):
        scene.ignore(pair["a"], pair["b"])
    return scene, description["margin"]


def check(subject: Path, out: Path) -> tuple[str, str | None, float]:
    """Write the table of a subject; return its name, the reason against it, and the peak in MB."""
    try:
        scene, margin = load(subject)
        found = scene.check(margin, threads=1).to_long_table(subject.name)
        found["time"] = [""] * len(found["value"])
        tables.write(out / tables.table_name(subject), [list(row) for row in zip(*found.values())])
        reason = None
    except MusculoCollideError as error:
        reason = str(error)
    return subject.name, reason, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main(folder: Path, out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    subjects = sorted(path for path in folder.iterdir() if path.is_dir())
    missing = [subject for subject in subjects if not (out / tables.table_name(subject)).exists()]

    # A fresh process for each scene: its peak is the scene's, with that of Python itself.
    pool = ProcessPoolExecutor(mp_context=get_context("spawn"), max_tasks_per_child=1)
    with pool, dask.config.set(scheduler="processes", pool=pool, chunksize=1):
        done = dask.compute(*(dask.delayed(check)(subject, out) for subject in missing))

    for name, reason, _ in done:
        if reason:
            print(f"{name} is skipped: {reason}")
    whole = [out / tables.table_name(subject) for subject in subjects]
    rows = tables.join([path for path in whole if path.exists()], out / "cohort.csv")
    peak = max((peak for *_, peak in done), default=0.0)
    print(
        f"{len(subjects)} subjects, {len(done)} computed, {sum(not path.exists() for path in whole)} skipped, "
        f"{rows} rows in {out / 'cohort.csv'}; peak memory of a scene {peak:.0f} MB"
    )


if __name__ == "__main__":
    arguments = [Path(argument) for argument in sys.argv[1:]]
    main(*(arguments + [Path("subjects"), Path("out")][len(arguments):]))
