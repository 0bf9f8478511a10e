"""Evaluations until CMA-ES reaches 1e-8: ours (cma_counts) against pycma's (Debian's python3-cma), same settings, median over seeds.

The tutorial's settings, that is: later versions of pycma damp the step of large populations more and smooth its path less, which is set back here.
A search of many minima that ends in a wrong one counts as not reached: populations are large enough that most end in the right one.

Usage: cma_vs_pycma.py PATH_OF_CMA_COUNTS [--json FILE]. Without pycma only our counts are printed, and that is said.
"""
import argparse
import json
import statistics
import subprocess
import sys

try:
    import cma
except ImportError:
    cma = None
else:
    for name, value in (("_CSA_dampfac_mueff_inner", 1), ("_CSA_cs_max", 1)):
        if hasattr(cma.sigma_adaptation, name):
            setattr(cma.sigma_adaptation, name, value)

TARGET = 1e-8
#        function, dimension, start, sigma, population (0: default), most evaluations, seeds
CASES = [("sphere", 10, 1, 1, 0, 100_000, 15), ("sphere", 40, 1, 1, 0, 100_000, 15),
         ("ellipsoid", 10, 1, 1, 0, 200_000, 15), ("ellipsoid", 40, 1, 1, 0, 400_000, 7),
         ("rosenbrock", 10, 0.1, 0.1, 0, 200_000, 15), ("rosenbrock", 40, 0.1, 0.1, 0, 400_000, 7),
         ("rastrigin", 10, 3, 2, 400, 400_000, 15), ("rastrigin", 40, 3, 2, 1200, 2_000_000, 7)]


def ours(program, case):
    function, dimension, start, sigma, population, most, seeds = case
    words = [program, function, dimension, start, sigma, population, TARGET, most, seeds]
    return json.loads(subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout)


def function_of(name):
    import numpy as np
    if name == "sphere":
        return lambda x: float(np.dot(x, x))
    if name == "ellipsoid":
        return lambda x: float(np.sum(1e6 ** (np.arange(len(x)) / (len(x) - 1)) * np.square(x)))
    if name == "rosenbrock":
        return lambda x: float(np.sum(100 * (x[1:] - x[:-1] ** 2) ** 2 + (1 - x[:-1]) ** 2))
    return lambda x: float(np.sum(10 + np.square(x) - 10 * np.cos(2 * np.pi * np.asarray(x))))


def theirs(case):
    function, dimension, start, sigma, population, most, seeds = case
    value = function_of(function)
    counts = []
    for seed in range(1, seeds + 1):
        options = {"seed": seed, "verbose": -9, "ftarget": TARGET, "maxfevals": most, "tolfun": 1e-11, "tolx": 1e-11}
        if population:
            options["popsize"] = population
        search = cma.CMAEvolutionStrategy(dimension * [start], sigma, options)
        search.optimize(value)
        counts.append([search.result.evaluations, bool(search.result.fbest <= TARGET)])
    return counts


def summary(counts):
    reached = [n for n, done in counts if done]
    return {"median": statistics.median(reached) if reached else None, "reached": len(reached), "of": len(counts)}


def text(s):
    return "-" if s is None or s["median"] is None else f"{s['median']:.0f} ({s['reached']}/{s['of']})"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    if cma is None:
        print(f"*** pycma is not installed for {sys.executable} (Debian: python3-cma): only our own counts are shown ***", file=sys.stderr)
    rows = []
    for case in CASES:
        mine = summary(ours(arguments.program, case))
        other = summary(theirs(case)) if cma else None
        ratio = mine["median"] / other["median"] if other and other["median"] and mine["median"] else None
        rows.append({"function": case[0], "dimension": case[1], "population": case[4], "ours": mine, "pycma": other, "ratio": ratio})
        print(f"{case[0]:<11}{case[1]:>3}  ours {text(mine):<18} pycma {text(other):<18} ratio {f'{ratio:.2f}' if ratio else '-'}", flush=True)
        if arguments.json:  # after each row: a run that is cut short keeps what it has
            with open(arguments.json, "w") as out:
                json.dump({"pycma": getattr(cma, "__version__", None), "rows": rows}, out, indent=1)


if __name__ == "__main__":
    main()
