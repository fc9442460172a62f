"""What both cohorts share: names of tables by the content of scenes, and the joined table."""

import csv
import hashlib
from pathlib import Path

COLUMNS = ["subject", "frame", "time", "a", "b", "measure", "value"]


def content_hash(subject: Path) -> str:
    """Return a hash of all files of a scene: what has not changed is not computed again."""
    digest = hashlib.sha256()
    for path in sorted(subject.iterdir()):
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


def table_name(subject: Path) -> str:
    """Return the name of a subject's table."""
    return f"{subject.name}-{content_hash(subject)}.csv"


def write(path: Path, rows: list[list[object]]) -> None:
    """Write a table; it is there as a whole or not at all."""
    unfinished = path.with_suffix(".part")
    with unfinished.open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    unfinished.replace(path)


def join(tables: list[Path], out: Path) -> int:
    """Join tables to one; return the number of rows."""
    rows: list[list[object]] = []
    for path in tables:
        with path.open(newline="") as file:
            rows += list(csv.reader(file))[1:]
    write(out, rows)
    return len(rows)
