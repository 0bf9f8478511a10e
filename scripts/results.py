"""Design real pairs with the headless command, have each judged from outside, and tabulate what the judge saw.

    python3 scripts/results.py --shared DIR [--blender BLENDER] [--write docs/results.md] [--pictures] [TARGET:CHARACTER ...]

DIR holds `data/` (targets, characters, make_scene.py) and `verify/` (the judge). Without pairs, the eight dev pairs. Exits 1 when a
pair misses a line that must hold for every design. Files stay in build/results/.
"""
import argparse
import json
import pathlib
import struct
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAIRS = ["egg:phantomx", "wheel:phantomx", "oval:unitree_a1", "car_beetle:minitaur", "bunny:snake16", "egg:robotis_op3",
         "truck:basic_human", "spot_cow:basic_quadruped"]


def build_judge(shared):
    build = ROOT / "build" / "verify"
    for command in (["cmake", "-S", str(shared / "verify"), "-B", str(build), "-DCMAKE_BUILD_TYPE=Release"],
                    ["cmake", "--build", str(build)]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return build / "verify_design"


def character_file(shared, name):
    robot = shared / "data" / "characters" / f"{name}.joints.json"
    return robot if robot.exists() else shared / "data" / "characters" / f"{name}.json"


def run(command, log, **kwargs):
    with open(log, "a") as out:
        return subprocess.run(command, stdout=out, stderr=subprocess.STDOUT, **kwargs).returncode


def make_scene(pair, shared, blender, scene, log):
    """Writes a .blend with one target and one character."""
    target, character = pair.split(":")
    run([blender, "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(shared / "data" / "make_scene.py"), "--", "--target",
         str(shared / "data" / "targets" / f"{target}.ply"), "--character", str(character_file(shared, character)),
         "--output", str(scene)], log, check=True)


def inside_blender(script, pair, options, *arguments):
    """Has Blender run `script --inside OUT ARGUMENTS` with the pair's scene open, in a folder named after the script, and gives the JSON that it writes to OUT."""
    script = pathlib.Path(script).resolve()
    folder = ROOT / "build" / script.stem / pair.replace(":", "_")
    folder.mkdir(parents=True, exist_ok=True)
    scene, out, log = (folder / name for name in ("scene.blend", "out.json", "log.txt"))
    out.unlink(missing_ok=True)
    make_scene(pair, options.shared, options.blender, scene, log)
    run([options.blender, "-b", str(scene), "--python-exit-code", "1", "--python", str(script), "--", "--inside", str(out), *arguments], log, check=True)
    return json.loads(out.read_text())


def design_pair(pair, shared, blender, judge, options, samples):
    """One row of the table: what the command and the judge said of one pair."""
    target, character = pair.split(":")
    folder = ROOT / "build" / "results" / f"{target}_{character}"
    folder.mkdir(parents=True, exist_ok=True)
    log, scene, blend, report = (folder / n for n in ("log.txt", "scene.blend", "design.blend", "report.json"))
    for old in (log, scene, blend, report):
        old.unlink(missing_ok=True)
    make_scene(pair, shared, blender, scene, log)
    start = time.monotonic()
    code = run([blender, "-b", str(scene), "--python", str(ROOT / "addon" / "transformables" / "cli.py"), "--", "design",
                "--output", str(blend), "--report", str(report), *options], log)
    row = {"pair": pair, "exit": code, "seconds": time.monotonic() - start, "folder": folder}
    if code not in (0, 3):
        return row
    row["report"] = json.loads(report.read_text())
    run([blender, "-b", str(blend), "--python", str(shared / "verify" / "export_design.py"), "--", str(folder / "judged"),
         "--samples-per-frame", str(samples)], log)
    row["judge"] = json.loads(subprocess.run([judge, folder / "judged"], check=True, capture_output=True, text=True).stdout)
    kinematics = json.loads((folder / "judged" / "kinematics.json").read_text())
    kinematics["size"] = longest_side(folder / "judged" / "target.bin")
    row["kinematics"] = kinematics
    return row


def longest_side(path):
    """Longest side of the box around an exported mesh: the scale of a design, in its own units."""
    data = path.read_bytes()
    count = struct.unpack_from("<I", data)[0]
    numbers = struct.unpack_from(f"<{3 * count}d", data, 8)
    return max(max(numbers[k::3]) - min(numbers[k::3]) for k in range(3))


def faults(row):
    """The lines that hold for every design, whatever the pair; returns those that do not."""
    if row["exit"] not in (0, 3):
        return [f"exit {row['exit']}"]
    judge, joints = row["judge"], row["kinematics"]["joints"].values()
    checks = {
        "parts not closed, manifold, simple": judge["parts_not_closed_manifold_simple"] == 0,
        "extra fragments": judge["extra_fragments"] == 0,
        "outside target": judge["outside_target_pct"] < 0.1,
        "folded overlap": judge["folded_overlap_pct"] < 0.05,
        "axis spread": max((j["axis_spread_deg"] for j in joints), default=0) < 0.5,
        "head drift": max((j["head_drift"] for j in joints), default=0) < 1e-4 * row["kinematics"]["size"],
        "120 s": row["seconds"] < 120,
        "2 GB": row["report"]["peak_memory_mb"] < 2000,
        "rigid": judge["rigidity_error"] < 1e-4,
    }
    return [name for name, good in checks.items() if not good]


def good(row):
    """A pair that also folds without a collision and fills its target."""
    return not faults(row) and row["judge"]["colliding_samples"] == 0 and row["judge"]["target_filled_pct"] > 90


COLUMNS = [
    ("pair", lambda r: r["pair"].replace(":", " x ")),
    ("exit", lambda r: str(r["exit"])),
    ("seconds", lambda r: f"{r['seconds']:.0f}"),
    ("MB", lambda r: f"{r['report']['peak_memory_mb']:.0f}"),
    ("parts", lambda r: str(r["judge"]["parts"])),
    ("bad parts", lambda r: str(r["judge"]["parts_not_closed_manifold_simple"])),
    ("fragments", lambda r: str(r["judge"]["extra_fragments"])),
    ("filled %", lambda r: f"{r['judge']['target_filled_pct']:.1f}"),
    ("outside %", lambda r: f"{r['judge']['outside_target_pct']:.3f}"),
    ("surface p95 %", lambda r: f"{r['judge']['surface_deviation_pct_of_diagonal']['p95']:.3f}"),
    ("folded overlap %", lambda r: f"{r['judge']['folded_overlap_pct']:.3f}"),
    ("colliding / samples", lambda r: f"{r['judge']['colliding_samples']} / {r['judge']['motion_samples']}"),
    ("depth %", lambda r: f"{r['judge']['motion_worst_depth_pct_of_diagonal']:.2f}"),
    ("carved %", lambda r: f"{r['report']['carved_volume_pct']:.1f}"),
    ("smallest part %", lambda r: f"{r['judge']['smallest_part_volume_pct']:.2f}"),
    ("axis spread deg", lambda r: f"{max((j['axis_spread_deg'] for j in r['kinematics']['joints'].values()), default=0):.3f}"),
    ("head drift", lambda r: f"{max((j['head_drift'] for j in r['kinematics']['joints'].values()), default=0):.1e}"),
]


def table(rows):
    lines = ["| " + " | ".join(name for name, _ in COLUMNS) + " |", "| " + " | ".join("---" for _ in COLUMNS) + " |"]
    for row in rows:
        if "judge" in row:
            lines.append("| " + " | ".join(cell(row) for _, cell in COLUMNS) + " |")
        else:
            lines.append(f"| {row['pair'].replace(':', ' x ')} | {row['exit']} | {row['seconds']:.0f} |" + " |" * (len(COLUMNS) - 3))
    return "\n".join(lines)


def write_page(path, rows, options):
    text = f"""# Results on real pairs

Written by `python3 scripts/results.py --shared DIR --write {path}` on {time.strftime('%Y-%m-%d')}, two cores, options:
`{' '.join(options) or 'default'}`. Each design was made by the headless command and measured by a judge that shares no code with this
program. Percentages of volume are of the target's volume, lengths of its diagonal. "colliding" counts sampled moments of the fold in
which one part lies deeper than 1/96 of the target's longest side within another.

{table(rows)}

{sum(good(r) for r in rows)} of {len(rows)} pairs fold without a collision and fill more than 90 % of their target;
{sum(not faults(r) for r in rows)} of {len(rows)} hold every line that any design must hold.
"""
    pathlib.Path(path).write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="*", default=None)
    parser.add_argument("--shared", type=pathlib.Path, required=True)
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--options", default="", help="more options of the headless command, in one string")
    parser.add_argument("--samples", type=int, default=2, help="samples a frame for the judge")
    parser.add_argument("--write", help="write the table to this Markdown file")
    parser.add_argument("--pictures", action="store_true", help="render each design to its folder in build/results")
    args = parser.parse_args()
    shared = args.shared.resolve()
    judge = build_judge(shared)
    rows, options = [], args.options.split()
    for pair in args.pairs or PAIRS:
        row = design_pair(pair, shared, args.blender, judge, options, args.samples)
        rows.append(row)
        if args.pictures and "judge" in row:
            run([args.blender, "-b", str(row["folder"] / "design.blend"), "--python", str(ROOT / "scripts" / "render_design.py"), "--",
                 str(row["folder"] / "pictures"), "--frames", "5"], row["folder"] / "log.txt")
        verdict = "good" if good(row) else ("; ".join(faults(row)) or "holds, but collides or fills too little")
        print(table([row]).splitlines()[-1], verdict, flush=True)
    print("\n" + table(rows))
    print(f"{sum(not faults(row) for row in rows)} of {len(rows)} hold every line that must hold")
    if args.write:
        write_page(args.write, rows, options)
    sys.exit(any(faults(row) for row in rows))


if __name__ == "__main__":
    main()
