"""Contact table of the generated thigh, a motion, and its overlaps removed."""

from pathlib import Path

from musculo_collide import DistanceField, Scene, read_mesh

FOLDER = Path(__file__).resolve().parents[2] / "fixtures" / "thigh"
RIGID = {"femur"}


def main() -> None:
    scene = Scene()
    for path in sorted(FOLDER.glob("*.ply")):
        mesh = read_mesh(path)
        scene.add(path.stem, mesh.vertices, mesh.faces, rigid=path.stem in RIGID)

    # Where they touch, how deep, and how much they share.
    pairs = scene.check(margin=1.0)
    print(pairs)

    # When a muscle meets something on a way of 4 mm.
    forward = scene.vertices("biceps_femoris") + [0.0, 4.0, 0.0]
    print(scene.sweep({"biceps_femoris": forward}))

    # Overlaps removed.
    print(scene.resolve())

    # Distances to the bone.
    femur = DistanceField.build(scene.vertices("femur"), scene.faces("femur"), spacing=2.0)
    print(femur, femur.query(scene.vertices("biceps_femoris")).min().round(3))


if __name__ == "__main__":
    main()
