"""Turns the benches' JSON into the tables of docs/performance.md (between its markers), and prints them.

Usage: write_table.py FOLDER_OF_JSON PERFORMANCE_MD. What was not measured is left out of the tables.
"""
import argparse
import datetime
import json
import math
import pathlib
import platform

BEGIN, END = "<!-- measured: written by scripts/bench.sh -->", "<!-- end of measured -->"
TO_MS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


def load(paths):
    """{(stage, grid): {code: benchmark}} with `ms` of CPU time in each."""
    results = {}
    for path in paths:
        for bench in json.loads(path.read_text())["benchmarks"]:
            stage, grid, code = bench["name"].split("/")[:3]
            bench["ms"] = bench["cpu_time"] * TO_MS[bench["time_unit"]]
            results.setdefault((stage, grid), {})[code] = bench
    return results


def exponent(points):
    """Slope of log(time) over log(voxels); None for fewer than two sizes."""
    if len(points) < 2:
        return None
    xs, ys = [math.log(v) for v, _ in points], [math.log(t) for _, t in points]
    mean_x, mean_y = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / sum((x - mean_x) ** 2 for x in xs)


def number(value, digits=3):
    return "" if value is None else f"{value:.{digits}g}" if value < 100 else f"{value:.0f}"


def ratio(codes, slow, fast):
    return codes[slow]["ms"] / codes[fast]["ms"] if slow in codes and fast in codes else None


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def ms(codes, code):
    return number(codes[code]["ms"]) if code in codes else ""


def evaluation_table(results):
    rows, points = [], []
    for (_, grid), codes in results.items():
        if not {"production", "production_every_voxel"} <= codes.keys():
            continue
        every = codes["production_every_voxel"]
        points.append((every["inside"], every["ms"]))
        rows.append([grid, f"{every['inside']:.0f}", f"{codes['production']['stride']:.0f}", ms(codes, "production"), ms(codes, "production_every_voxel"),
                     ms(codes, "paper"), ms(codes, "paper_shortest_way"), number(ratio(codes, "paper", "production_every_voxel")),
                     number(ratio(codes, "paper_shortest_way", "production_every_voxel"))])
    head = ["grid", "voxels inside", "stride", "production, ms", "every voxel, ms", "paper, ms", "paper, true distances, ms", "ratio to paper", "ratio, same distances"]
    slope = exponent(points)
    return ["### One evaluation of the objective", "", *table(head, rows), "",
            f"Cost of production with every voxel: (voxels)^{slope:.2f}." if slope else ""]


def growth_table(results):
    rows, points, previews = [], [], []
    for (stage, grid), codes in results.items():
        if "production" not in codes:
            continue
        ours = codes["production"]
        if stage == "preview":
            previews.append([grid, f"{ours['inside']:.0f}", ms(codes, "flood"), ms(codes, "production"), number(ours["peak_MB"])])
            continue
        points.append((ours["inside"], ours["ms"]))
        paper_memory = number(codes["paper"]["peak_MB"]) if "paper" in codes else ""
        rows.append([grid, f"{ours['inside']:.0f}", ms(codes, "production"), ms(codes, "paper"), number(ratio(codes, "paper", "production")),
                     number(ours["peak_MB"]), paper_memory])
    head = ["grid", "voxels inside", "production, ms", "paper, ms", "ratio", "peak, MB", "paper's peak, MB"]
    slope = exponent(points)
    lines = ["### Growth of the skins", "", *table(head, rows), "", f"Cost of production: (voxels)^{slope:.2f}." if slope else ""]
    head = ["grid", "voxels inside", "flood alone, ms", "whose each sample is, ms", "peak, MB"]
    return lines + ["", "### The division while the search runs", "", *table(head, previews)]


def folding_table(results):
    rows = []
    for (_, grid), codes in results.items():
        against = ratio(codes, "greedy_letter", "greedy_paper_cost")
        for code, b in codes.items():
            rows.append([grid, code, number(b["ms"]), number(against) if code == "greedy_paper_cost" else "", number(b["overlap_pct"])])
    return ["### Folding", "", *table(["grid", "work", "ms", "times faster than greedy_letter", "overlap left, % of target"], rows)]


def overlap_table(results):
    rows = []
    for (_, grid), codes in results.items():
        each = {code: number(1e3 * b["ms"] / b["evaluations"]) for code, b in codes.items()}
        codes_compared = ("paper", "fcl_boolean", "fcl_contacts")
        rows.append([grid, *(each.get(code, "") for code in ("production", *codes_compared)), *(number(ratio(codes, code, "production")) for code in codes_compared)])
    head = ["grid", "production, us", "paper, us", "FCL, whether they meet, us", "FCL, all contacts, us", "paper, ratio", "FCL, ratio", "FCL's contacts, ratio"]
    lines = ["### One overlap evaluation of a pair of parts", "", *table(head, rows)]
    if not any("fcl_boolean" in codes for codes in results.values()):
        lines += ["", "libfcl-dev was not installed: not compared with FCL."]
    return lines


def carving_table(results):
    rows = [[grid, f"{c['production']['samples']:.0f}", ms(c, "production"), ms(c, "paper"), number(ratio(c, "paper", "production")), number(c["production"]["carved_pct"]),
             number(c["paper"]["carved_pct"]) if "paper" in c else ""] for (_, grid), c in results.items() if "production" in c]
    head = ["grid", "samples", "production, ms", "paper, ms", "ratio", "carved, %", "paper carves, %"]
    return ["### Carving along the greedy path", "", *table(head, rows)]


def cma_table(path):
    data = json.loads(path.read_text())
    show = lambda s: "" if not s or s["median"] is None else f"{s['median']:.0f} ({s['reached']} of {s['of']})"
    rows = [[r["function"], str(r["dimension"]), str(r["population"] or "default"), show(r["ours"]), show(r["pycma"]), number(r["ratio"])] for r in data["rows"]]
    source = f"pycma {data['pycma']}" if data["pycma"] else "pycma was not installed: not compared"
    return ["### Evaluations until CMA-ES reaches 1e-8", "", f"Median over the seeds that reached it (how many did); {source}.", "",
            *table(["function", "dimension", "population", "ours", "pycma", "ratio"], rows)]


def live_table(path):
    rows = [[r["search"], number(r["poses_a_second"]), number(r["longest_pause_ms"]), ", ".join(number(a) for a in r["answers_ms"]),
             ", ".join(str(s) for s in r["stopped_after"]), f"{r['load']:.1f}"] for r in json.loads(path.read_text())]
    head = ["search", "poses a second", "longest pause, ms", "from the request to end to the answer, ms", "asked after, s", "load average"]
    return ["### A search that is watched", "", *table(head, rows)]


def explore_table(path):
    r = json.loads(path.read_text())
    row = [r["pair"], str(r["wanted"]), f"{r['found']} ({r['sound']} sound)", number(r["least_difference_pct"]), number(r["best"]), number(r["last"]), number(r["seconds"]),
           number(r["cpu_seconds"]), f"{r['load']:.1f} on {r['cores']} cores"]
    head = ["pair", "wanted", "found", "least difference of any two, % of voxels", "best objective", "last", "wall time, s", "processor time, s", "load average"]
    return ["### Explore", "", *table(head, [row])]


def embed_table(path):
    r = json.loads(path.read_text())
    load = f"{r['load']:.1f} on {r['cores']} cores"
    rows = [[r["pair"], str(r["resolution"]), str(run["seed"]), str(run["evaluations"]), number(run["seconds"]), number(run["cpu_seconds"]), number(run["value"]),
             "yes" if run["sound"] else "no", number(run["value_of_more"]), load] for run in r["runs"]]
    head = ["pair", "voxels along the longest side", "seed", "evaluations", "wall time, s", "processor time, s", "objective", "sound", "objective after ten times the evaluations", "load average"]
    return ["### One search", "", *table(head, rows)]


def cpu_name():
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def measured(folder):
    some = next((json.loads(p.read_text())["context"] for p in sorted(folder.glob("bench_*.json"))), {})
    load_average = ", ".join(f"{x:.1f}" for x in some.get("load_avg", []))
    lines = [f"Measured on {datetime.date.today().isoformat()}: {cpu_name()}, {some.get('num_cpus', '?')} cores, load average {load_average or 'unknown'}.", ""]
    tables = {"bench_embedding": evaluation_table, "bench_segmentation": growth_table, "bench_folding": folding_table, "bench_overlap": overlap_table,
              "bench_finishing": carving_table}
    for name, write in tables.items():
        results = load(sorted(folder.glob(f"{name}*.json")))  # of part runs (--benchmark_filter) too
        lines += [*(write(results) if results else [f"### {name}", "", "Not measured."]), ""]
    for name, title, write in (("cma", "CMA-ES", cma_table), ("live", "A search that is watched", live_table), ("explore", "Explore", explore_table),
                               ("embed", "One search", embed_table)):
        path = folder / f"{name}.json"
        lines += [*(write(path) if path.exists() else [f"### {title}", "", "Not measured."]), ""]
    return lines[:-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("page", type=pathlib.Path)
    arguments = parser.parse_args()
    text = "\n".join(measured(arguments.folder))
    print(text)
    page = arguments.page.read_text()
    before, rest = page.split(BEGIN)
    arguments.page.write_text(before + BEGIN + "\n" + text + "\n" + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
