# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad meshes through the headless command: each has to give a sound design, or one clear line, exit code 2 and no file.

    python3 scripts/sweep_dirty.py --shared DIR [--blender BLENDER] [--options "..."] [NAME ...]

DIR holds `data/` (with dirty/, characters/, make_scene.py) and `verify/` (the judge). Names are those of files in data/dirty
without their ending; without names all of them are tried, and the mesh of 1.7 million triangles that make_million.py writes.
Time is counted in seconds of processor, so that it means the same on a busy machine. Exits 1 when one fails. Files stay in
build/dirty/.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import results

CHARACTER = "phantomx"
MILLION = "bunny_1M7"
PROCESSOR_SECONDS = 240      # two cores for 120 s
GIVE_UP_SECONDS = 1200       # of a clock: a hang, however busy the machine is
MESHES = (".ply", ".obj", ".off", ".stl")


def files(shared, names):
    """{name: mesh file} of what was asked for; makes the large one."""
    found = {p.stem: p for p in sorted((shared / "data" / "dirty").iterdir()) if p.suffix in MESHES}
    wanted = names or [*found, MILLION]
    if MILLION in wanted:
        found[MILLION] = made_million(shared)
    unknown = [n for n in wanted if n not in found]
    if unknown:
        sys.exit(f"sweep_dirty: no file is called {', '.join(unknown)}; there are: {', '.join([*found, MILLION])}")
    return {name: found[name] for name in wanted}


def made_million(shared):
    path = results.ROOT / "build" / "dirty" / f"{MILLION}.ply"
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists():
        subprocess.run(["/usr/bin/python3", shared / "data" / "dirty" / "make_million.py", shared / "data" / "targets" / "bunny.ply", path],
                       check=True, stdout=subprocess.DEVNULL)
    return path


def try_mesh(name, mesh, shared, blender, judge, options):
    """One row: what came of a mesh."""
    folder = results.ROOT / "build" / "dirty" / name
    out = folder / "out"
    out.mkdir(parents=True, exist_ok=True)
    for old in [*out.iterdir(), folder / "log.txt"]:
        old.unlink(missing_ok=True)
    log, scene = folder / "log.txt", folder / "scene.blend"
    made = results.run([blender, "-b", "--factory-startup", "--python-exit-code", "1", "--python", shared / "data" / "make_scene.py", "--",
                        "--target", mesh, "--character", results.character_file(shared, CHARACTER), "--output", scene], log)
    if made:
        return {"name": name, "exit": None, "seconds": 0, "faults": ["make_scene.py failed"], "says": ""}
    code, seconds, errors = design(blender, scene, out, options)
    log.open("a").write(errors)
    row = {"name": name, "exit": code, "seconds": seconds, "says": "", "faults": []}
    lines = [line for line in errors.splitlines() if line.startswith("transformables: error:")]
    left = sorted(p.name for p in out.iterdir())
    if seconds > PROCESSOR_SECONDS:
        row["faults"].append(f"over {PROCESSOR_SECONDS} s of processor")
    if "Traceback" in errors:
        row["faults"].append("a traceback")
    if code == 2:
        row["says"] = lines[0].split("error: ", 1)[1] if lines else ""
        row["faults"] += [] if len(lines) == 1 else [f"{len(lines)} lines of error"]
        row["faults"] += [f"left behind: {', '.join(left)}"] if left else []
    elif code in (0, 3):
        row["faults"] += [] if left == ["design.blend", "report.json"] else [f"wrote {left}"]
        if not row["faults"]:
            judged(row, out, folder, shared, blender, judge, log)
    else:
        row["faults"].append("hung" if code is None else f"exit {code}")
    return row


def design(blender, scene, out, options):
    """(exit code or None when it hung, seconds of processor, standard error)."""
    before = os.times()
    command = [blender, "-b", scene, "--python", results.ROOT / "addon" / "transformables" / "cli.py", "--", "design", "--output",
               out / "design.blend", "--report", out / "report.json", *options]
    try:
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, timeout=GIVE_UP_SECONDS)
        code, errors = done.returncode, done.stderr
    except subprocess.TimeoutExpired as late:
        code, errors = None, (late.stderr or b"").decode(errors="replace")
    after = os.times()
    return code, after.children_user - before.children_user, errors


def judged(row, out, folder, shared, blender, judge, log):
    results.run([blender, "-b", out / "design.blend", "--python", shared / "verify" / "export_design.py", "--", folder / "judged",
                 "--samples-per-frame", "1"], log)
    verdict = subprocess.run([judge, folder / "judged"], check=True, capture_output=True, text=True).stdout
    verdict = re.sub(r"-?\bnan\b", "NaN", verdict)  # of a raw mesh with vertices that are no numbers
    kinematics = json.loads((folder / "judged" / "kinematics.json").read_text())
    kinematics["size"] = results.longest_side(folder / "judged" / "target.bin")
    row.update(report=json.loads((out / "report.json").read_text()), judge=json.loads(verdict), kinematics=kinematics)
    against_target = row["judge"]["target_filled_pct"]
    row["says"] = (f"{row['judge']['parts']} parts, filled {row['report']['filled_volume_pct']:.1f} % "
                   f"(of the raw mesh: {against_target if against_target is not None else 'no volume'}), "
                   f"colliding {row['judge']['colliding_samples']} of {row['judge']['motion_samples']}")
    # The judge measures against the mesh as it was; where that is no closed surface its volume lines mean nothing.
    meaningless = {"outside target"} | ({"folded overlap"} if math.isnan(row["judge"]["folded_overlap_pct"]) else set())
    row["faults"] += [f for f in results.faults({**row, "seconds": 0.0}) if f not in meaningless]


def line(row):
    verdict = "; ".join(row["faults"]) or "ok"
    return f"| {row['name']} | {row['exit']} | {row['seconds']:.0f} | {row['says']} | {verdict} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--shared", type=pathlib.Path, required=True)
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--options", default="", help="more options of the headless command, in one string")
    args = parser.parse_args()
    shared = args.shared.resolve()
    blender = shutil.which(args.blender) or sys.exit(f"sweep_dirty: there is no program '{args.blender}'")
    # Debian's Blender takes its Python from the first python3 on PATH; another one (pyenv) has no numpy.
    os.environ["PATH"] = f"/usr/bin:{os.environ['PATH']}"
    judge = results.build_judge(shared)
    began, rows = time.monotonic(), []
    print("| mesh | exit | processor s | what came of it | verdict |\n| --- | --- | --- | --- | --- |", flush=True)
    for name, mesh in files(shared, args.names).items():
        rows.append(try_mesh(name, mesh, shared, blender, judge, args.options.split()))
        print(line(rows[-1]), flush=True)
    failed = [row["name"] for row in rows if row["faults"]]
    print(f"{len(rows) - len(failed)} of {len(rows)} hold, in {time.monotonic() - began:.0f} s" + (f"; failed: {', '.join(failed)}" if failed else ""))
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
