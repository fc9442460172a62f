"""Make a cohort: subjects whose muscles are those of the generated thigh, swollen and moved a little.

    python subjects.py [FOLDER] [COUNT]

One subject has a mesh that ends too early, as files do that were not copied to their end.
"""

import shutil
import sys
from pathlib import Path

import numpy as np

from musculo_collide import read_mesh, write_mesh

THIGH = Path(__file__).resolve().parents[3] / "fixtures" / "thigh"
BAD = 13
RIGID = {"femur"}


def make(folder: Path, count: int) -> None:
    """Write the scenes of all subjects; those of one number are the same every time."""
    for number in range(count):
        subject = folder / f"p{number:02}"
        subject.mkdir(parents=True, exist_ok=True)
        shutil.copy(THIGH / "scene.toml", subject)
        shutil.copy(THIGH / "motion.json", subject)
        rng = np.random.default_rng(number)
        for path in sorted(THIGH.glob("*.ply")):
            mesh = read_mesh(path)
            vertices = mesh.vertices
            if path.stem not in RIGID:
                middle = vertices.mean(axis=0)
                vertices = middle + rng.normal(1.0, 0.02) * (vertices - middle) + rng.normal(0.0, 0.5, 3)
            write_mesh(subject / path.name, vertices, mesh.faces)

    if count > BAD:
        cut = folder / f"p{BAD:02}" / "sartorius.ply"
        cut.write_bytes(cut.read_bytes()[:20_000])


if __name__ == "__main__":
    arguments = sys.argv[1:]
    make(Path(arguments[0] if arguments else "subjects"), int(arguments[1]) if len(arguments) > 1 else 40)
