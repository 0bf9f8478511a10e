"""Carve real designs along the paper's greedy order, too, and tabulate how much more that costs.

    python3 scripts/greedy.py --shared DIR [--blender BLENDER] [--write docs/greedy.md] [TARGET:CHARACTER ...]

DIR holds `data/`. Without pairs, the eight dev pairs. Both columns start from the same folded pose, are carved and filled in by the same code, and are
proved; the greedy one has the paper's order (the joint next that collides least, Eq. 11) and the paper's transfer at joints, nothing more. Files stay in
build/greedy/. Inside Blender this file is called by itself (`--inside OUT.json`).
"""
import argparse
import json
import pathlib
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


def compare_inside(out):
    """In Blender: designs the scene's pair, and finishes it again along the greedy order."""
    import bpy
    sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "addon" / "transformables" / "native"), str(ROOT / "scripts")]
    import transformables_native
    from seeds import Silent
    from transformables.bridge import design
    from transformables.core import pipeline
    from transformables.core.options import DesignOptions

    class Greedy(pipeline.Run):
        def _folding(self):
            self.path = self.tn.plan_greedy(self.segmentation, self.character, self.target, self.embedding, threads=self.options.threads)

    found = [next(o for o in bpy.data.objects if o.type == kind) for kind in ("ARMATURE", "MESH")]
    job, arrays = design.gather(*found, DesignOptions())
    ours = pipeline.run(job, arrays, Silent())[0]
    theirs = Greedy(transformables_native, {**job, "stored": {"embedding": ours["embedding"]}}, arrays, Silent()).run()[0]
    pathlib.Path(out).write_text(json.dumps([{"carved": r["finishing"]["carved_volume_pct"], "certified": r["finishing"]["certificate"]["holds"]}
                                             for r in (ours, theirs)]))


def main():
    sys.path.insert(0, str(ROOT / "scripts"))
    import results
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=pathlib.Path, required=True)
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--write", type=pathlib.Path)
    parser.add_argument("pairs", nargs="*", default=results.PAIRS)
    options = parser.parse_args()
    lines = [f"# What the order is worth\n\nWritten by `python3 scripts/greedy.py --shared DIR --write {options.write or 'FILE'}` on {time.strftime('%Y-%m-%d')}, "
             "default options: volume that carving takes, % of the target's, from the same folded pose. *Greedy* is the paper's order with the paper's transfer at "
             "joints; carving, filling in and proof are ours in both.\n",
             "| pair | this program | greedy | both proved |", "| --- | --- | --- | --- |"]
    sums = [0.0, 0.0]
    for pair in options.pairs:
        rows = results.inside_blender(__file__, pair, options)
        sums = [total + row["carved"] for total, row in zip(sums, rows)]
        lines.append(f"| {pair.replace(':', ' x ')} | {rows[0]['carved']:.2f} | {rows[1]['carved']:.2f} | {'yes' if all(row['certified'] for row in rows) else 'no'} |")
        print(lines[-1], flush=True)
    lines.append(f"| sum | {sums[0]:.2f} | {sums[1]:.2f} | |")
    print(lines[-1])
    if options.write:
        options.write.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if "--inside" in sys.argv:
        compare_inside(sys.argv[-1])
    else:
        main()
