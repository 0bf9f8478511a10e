#!/usr/bin/env bash
# Installs Debian's packages that are missing, builds the native module and puts it where the add-on finds it.
# Quick when nothing changed. Options are environment variables:
#   TRANSFORMABLES_PRESET  CMake preset (release; CI uses ci: warnings are errors)
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${TRANSFORMABLES_PRESET:-release}

# The window test draws in software: libgl1-mesa-dri. Pictures are rendered without a window: libegl1. Fonts and the rest come with blender and xvfb.
bash scripts/packages.sh g++ cmake ninja-build ccache python3 python3-dev python3-numpy python3-pytest pybind11-dev libeigen3-dev libtbb-dev \
  libcgal-dev libgtest-dev libgmock-dev blender xvfb libgl1-mesa-dri libegl1

# Blender 3.4 of Debian runs the system's Python, whichever python3 comes first on PATH; the module must match it.
mkdir -p build
cmake --preset "$preset" -DPython3_EXECUTABLE=/usr/bin/python3 > build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }

# A compiler of this code takes up to 1 GB: as many at once as there are processors, and memory for.
jobs=$(nproc)
memory_gb=$(awk '/^MemAvailable/ { print int($2 / 1048576) }' /proc/meminfo)
if ((memory_gb < jobs)); then jobs=$((memory_gb > 1 ? memory_gb : 1)); fi
cmake --build build --parallel "$jobs"
echo "setup: ready; the module is in addon/transformables/native/"
