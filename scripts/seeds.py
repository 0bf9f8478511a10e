"""Search for the folded pose with many seeds on real pairs, and tabulate how often it ends well, and how far the seeds are apart.

    python3 scripts/seeds.py --shared DIR [--blender BLENDER] [--seeds N] [--write docs/seeds.md] [TARGET:CHARACTER ...]

DIR holds `data/`. Without pairs, the eight dev pairs. One search a seed, without the rehearsals by which a design chooses between several
poses. Files stay in build/seeds/. Inside Blender this file is called by itself (`--inside OUT.json N`).
"""
import argparse
import json
import pathlib
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOUCHING = 1e-4   # target units: less deep, two capsules do not collide (core/pipeline.py)


class Silent:
    """What a job tells while it runs."""

    def progress(self, *_):
        return True

    def pose(self, _):
        return None

    def warning(self, _):
        return None


def search_inside(out, seeds):
    """In Blender: searches the scene's pair once a seed, and writes what came of it."""
    import bpy
    sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "addon" / "transformables" / "native")]
    from transformables.bridge import design
    from transformables.core import pipeline
    from transformables.core.options import LONGEST_SIDE, DesignOptions
    found = [next(o for o in bpy.data.objects if o.type == kind) for kind in ("ARMATURE", "MESH")]
    rows = []
    for seed in range(seeds):
        options = DesignOptions(seed=seed)
        job, arrays = design.gather(*found, options)
        job.update(until="embedding", explore={"count": 1, "least_difference": pipeline.DIFFERENT})
        began = time.process_time()
        embedding = pipeline.run(job, arrays, Silent())[0]["embedding"]
        voxel = LONGEST_SIDE / options.resolution
        rows.append({"seconds": time.process_time() - began, "value": embedding["terms"]["total"],
                     "sound": embedding["deepest_protrusion"] < voxel and embedding["deepest_collision"] <= TOUCHING})
    pathlib.Path(out).write_text(json.dumps(rows))


def row_of(pair, rows):
    values = sorted(row["value"] for row in rows)
    return (f"| {pair.replace(':', ' x ')} | {len(rows)} | {100 * statistics.mean(row['sound'] for row in rows):.0f} | {values[0]:.1f} | "
            f"{statistics.median(values):.1f} | {values[-1]:.1f} | {100 * (statistics.median(values) / values[0] - 1):.0f} | "
            f"{statistics.median(row['seconds'] for row in rows):.1f} |")


def main():
    sys.path.insert(0, str(ROOT / "scripts"))
    import results
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=pathlib.Path, required=True)
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--write", type=pathlib.Path)
    parser.add_argument("pairs", nargs="*", default=results.PAIRS)
    options = parser.parse_args()
    lines = [f"# Poses by seed\n\nWritten by `python3 scripts/seeds.py --shared DIR --write {options.write or 'FILE'}` on {time.strftime('%Y-%m-%d')}: one search a seed at "
             "default options, without rehearsals. *Sound*: the skeleton sticks out by less than a voxel, and no two capsules collide. Seconds are of processor time, all cores together.\n",
             "| pair | seeds | sound % | best objective | median | worst | median over best % | seconds, median |", "| --- " * 8 + "|"]
    for pair in options.pairs:
        lines.append(row_of(pair, results.inside_blender(__file__, pair, options, str(options.seeds))))
        print(lines[-1], flush=True)
    if options.write:
        options.write.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if "--inside" in sys.argv:
        search_inside(sys.argv[-2], int(sys.argv[-1]))
    else:
        main()
