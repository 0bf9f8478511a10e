"""Writes the bones of real characters, as the add-on hands them to the native module, for native tests on real pairs.

    python3 tests/native/write_characters.py --shared DIR [--blender BLENDER] OUT.txt

DIR holds `data/`. A line a character (`character NAME COUNT`), then a line a bone: name, parent, head, tail, X axis, Y axis, number of hinges, and for each
its axis and its range in radians. Inside Blender this file is called by itself (`--inside NAME OUT.txt`).
"""
import argparse
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))


def append_inside(name, out):
    """In Blender: appends the scene's character."""
    import bpy
    sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "addon" / "transformables" / "native")]
    from transformables.bridge import design
    from transformables.core.options import DesignOptions
    found = [next(o for o in bpy.data.objects if o.type == kind) for kind in ("ARMATURE", "MESH")]
    job, arrays = design.gather(*found, DesignOptions())
    heads, tails, axes = (memoryview(arrays[key][1]).cast("B").cast("d") for key in ("heads", "tails", "axes"))
    bones = job["character"]
    lines = [f"character {name} {len(bones['names'])}"]
    for n, (bone, parent, hinges) in enumerate(zip(bones["names"], bones["parents"], bones["hinges"])):
        numbers = [*heads[3 * n:3 * n + 3], *tails[3 * n:3 * n + 3], *(axes[9 * n + 3 * row + column] for column in (0, 1) for row in range(3))]
        lines.append(" ".join([bone.replace(" ", "_"), str(parent), *(repr(x) for x in numbers), str(len(hinges)),
                               *(repr(x) for hinge in hinges for x in hinge)]))
    with open(out, "a", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def main():
    import results
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=pathlib.Path, required=True)
    parser.add_argument("--blender", default="blender")
    parser.add_argument("out", type=pathlib.Path)
    options = parser.parse_args()
    folder = options.out.parent
    written, scene, log = options.out.with_suffix(".part"), folder / "character.blend", folder / "characters.log"
    written.write_text("")
    for name in sorted({pair.split(":")[1] for pair in results.PAIRS}):
        results.make_scene(f"egg:{name}", options.shared, options.blender, scene, log)
        results.run([options.blender, "-b", str(scene), "--python-exit-code", "1", "--python", __file__, "--", "--inside", name, str(written)], log, check=True)
    written.replace(options.out)


if __name__ == "__main__":
    if "--inside" in sys.argv:
        append_inside(*sys.argv[-2:])
    else:
        main()
