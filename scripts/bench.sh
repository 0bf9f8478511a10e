#!/usr/bin/env bash
# Builds and runs the benches (production against the paper to the letter) and writes their tables into docs/performance.md.
# Takes a quarter of an hour. Needs libbenchmark-dev; libfcl-dev and pycma (pip's `cma`) are optional, their absence is said.
#
#   BENCH_LARGE=1            also growth at 256 voxels
#   TRANSFORMABLES_PYTHON    a Python that has pycma (default /usr/bin/python3)
#   TRANSFORMABLES_SHARED    folder with the real characters and targets: searches on two pairs, else not measured (and that is said)
#   BENCH_BUILD              build folder (default build-bench)
set -euo pipefail
cd "$(dirname "$0")/.."
build=${BENCH_BUILD:-build-bench}
python=${TRANSFORMABLES_PYTHON:-/usr/bin/python3}
benches=(bench_embedding bench_segmentation bench_folding bench_overlap bench_finishing)

if ! dpkg-query -W -f='${Status}' libbenchmark-dev 2>/dev/null | grep -q 'install ok installed'; then
  echo "bench: libbenchmark-dev is missing: apt-get install libbenchmark-dev" >&2
  exit 1
fi
cmake --preset release -B "$build" -DTRANSFORMABLES_BENCH=ON -DPython3_EXECUTABLE=/usr/bin/python3 > /dev/null
cmake --build "$build" --target "${benches[@]}" cma_counts search_pair --parallel "$(nproc)"

results=$build/bench-results
mkdir -p "$results"
for bench in "${benches[@]}"; do
  "$build/tests/bench/$bench" --benchmark_out="$results/$bench.json" --benchmark_out_format=json
done
"$python" tests/bench/cma_vs_pycma.py "$build/tests/bench/cma_counts" --json "$results/cma.json"
if [ -n "${TRANSFORMABLES_SHARED:-}" ]; then
  /usr/bin/python3 tests/native/write_characters.py --shared "$TRANSFORMABLES_SHARED" "$build/characters.txt"
  "$build/tests/bench/search_pair" explore egg phantomx 64 5 | tee "$results/explore.json"
  "$build/tests/bench/search_pair" embed egg robotis_op3 54 3 | tee "$results/embed.json"   # the paper's grid for an egg: 44x54x44
else
  echo "bench: TRANSFORMABLES_SHARED is not set, so searches on real pairs are NOT measured" >&2
fi
if command -v blender > /dev/null; then  # with the module that scripts/setup.sh built
  blender -b blend_examples/egg_human.blend --factory-startup --python-exit-code 1 --python tests/bench/live_search.py -- --json "$results/live.json"
else
  echo "bench: there is no blender on PATH, so the search that is watched is NOT measured" >&2
fi
"$python" tests/bench/write_table.py "$results" docs/performance.md
