#!/usr/bin/env bash
# Installs Debian's packages that are missing, builds the native module and puts it where the add-on finds it.
# Quick when nothing changed. Options are environment variables:
#   TRANSFORMABLES_PRESET  CMake preset (release; CI uses ci: warnings are errors)
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${TRANSFORMABLES_PRESET:-release}

packages=(g++ cmake ninja-build ccache python3 python3-dev python3-numpy python3-pytest pybind11-dev libeigen3-dev libtbb-dev libcgal-dev
          libopenvdb-dev libimath-dev libgtest-dev libgmock-dev blender xvfb)
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
if ((${#missing[@]})); then
  as_root=()
  if [[ $(id -u) != 0 ]]; then as_root=(sudo); fi
  echo "setup: installing ${missing[*]}"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null
fi

# Blender 3.4 of Debian runs the system's Python, whichever python3 comes first on PATH; the module must match it.
cmake --preset "$preset" -DPython3_EXECUTABLE=/usr/bin/python3 > build.log 2>&1 || { cat build.log; exit 1; }
rm -f build.log
cmake --build build --parallel "$(nproc)"
echo "setup: ready; the module is in addon/transformables/native/"
