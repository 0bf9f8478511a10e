"""Are a finished design's parts fit to be printed? Asks two programs of others: admesh, and PrusaSlicer, which also slices them.

    python3 scripts/print_check.py DESIGN.blend|FOLDER [--no-slicing] [--blender BLENDER]

Takes the parts of a .blend (with the add-on's own export), or the STL files of a folder, as `design --parts FOLDER` writes them. A part holds when admesh
finds one piece and nothing to repair, PrusaSlicer says `manifold = yes` and repairs nothing, and it gives G-code, with supports and a raft.
Needs the packages admesh and prusa-slicer. Exits 1 when a part doesn't hold.
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# What admesh counts as done to a mesh; all but these lines of its summary tell sizes.
REPAIRS = ("Degenerate facets", "Edges fixed", "Facets removed", "Facets added", "Facets reversed", "Backwards edges")


def said(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, errors="replace")   # admesh shows bytes of its own memory after a name
    return done.returncode, done.stdout + done.stderr


def admesh(path):
    """What admesh finds wrong with a mesh, in its words."""
    code, text = said(["admesh", path])
    wrong = [f"admesh: exit code {code}"] if code else []
    for what in REPAIRS:
        found = re.search(rf"{what}\s*:\s*(\d+)", text)
        if not found or int(found[1]):
            wrong.append(f"admesh: {found[0] if found else f'nothing said of {what!r}'}")
    pieces = re.search(r"Number of parts\s*:\s*(\d+)", text)
    if not pieces or int(pieces[1]) != 1:
        wrong.append(f"admesh: {pieces[0] if pieces else 'no number of parts'}")
    for line in re.findall(r"Total disconnected facets\s*:\s*\d+\s+\d+", text):
        if not re.search(r":\s*0\s+0$", line):
            wrong.append(f"admesh: {line}")
    return wrong


def slicer_info(path):
    """What PrusaSlicer says of a mesh, as {word: value}."""
    return dict(re.findall(r"^(\w+) = *(.*?) *$", said(["prusa-slicer", "--info", path])[1], re.M))


def slicer(path):
    """What PrusaSlicer finds wrong with a mesh."""
    info = slicer_info(path)
    wrong = [] if info.get("manifold") == "yes" else [f"prusa-slicer: manifold = {info.get('manifold', 'not said')}"]
    if info.get("number_of_parts") != "1":
        wrong.append(f"prusa-slicer: number_of_parts = {info.get('number_of_parts', 'not said')}")
    # It tells what it repaired, and only when it did.
    wrong += [f"prusa-slicer: {key} = {info[key]}" for key in ("open_edges", "backwards_edges", "degenerate_facets", "edges_fixed", "facets_removed",
                                                               "facets_reversed") if info.get(key, "0") != "0"]
    return wrong


def sliced(path, folder):
    """What goes wrong when PrusaSlicer makes G-code of a mesh, by its own default printer."""
    gcode = folder / "part.gcode"
    gcode.unlink(missing_ok=True)
    # Parts stand as their bones point, some on a tip: on a raft, as one would print them.
    code, text = said(["prusa-slicer", "--export-gcode", "--support-material", "--raft-layers", "2", "--center", "100,100", "--output", gcode, path])
    if code or not gcode.exists():
        return [f"prusa-slicer: no G-code: {' '.join(text.split())[-200:]}"]
    used = re.search(r"filament used \[mm\] = ([0-9.]+)", gcode.read_text())
    return [] if used and float(used[1]) > 0 else ["prusa-slicer: G-code that prints nothing"]


def exported(blend, folder, blender):
    code, text = said([blender, "-b", blend, "--python-exit-code", "1", "--python", __file__, "--", "--export-to", folder])
    if code:
        sys.exit(f"print_check: {blend} could not be exported:\n{text[-2000:]}")


def export_here(folder):
    """Inside Blender: writes the open file's parts."""
    import bpy
    sys.path.insert(0, str(ROOT / "addon"))
    from transformables.bridge import printing
    rig = next(o for o in bpy.data.objects if o.get("transformable_role") == "rig")
    print("\n".join(printing.export(rig, folder)))


def check(folder, slicing):
    """Gives how many parts hold, and how many there are."""
    files = sorted(folder.glob("*.stl"))
    held = 0
    with tempfile.TemporaryDirectory() as aside:
        for path in files:
            wrong = admesh(path) + slicer(path)
            if slicing and not wrong:
                wrong = sliced(path, pathlib.Path(aside))
            held += not wrong
            print(f"{path.name}: {'; '.join(wrong) or 'holds'}", flush=True)
    return held, len(files)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", type=pathlib.Path)
    parser.add_argument("--no-slicing", action="store_true", help="leave out the G-code, which takes longest")
    parser.add_argument("--blender", default="blender")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as aside:
        folder = options.design
        if options.design.suffix == ".blend":
            folder = pathlib.Path(aside)
            exported(options.design, folder, options.blender)
        held, count = check(folder, not options.no_slicing)
    print(f"{held} of {count} hold")
    return 0 if count and held == count else 1


if __name__ == "__main__":
    if "--export-to" in sys.argv:
        export_here(sys.argv[sys.argv.index("--export-to") + 1])
    else:
        sys.exit(main())
