#!/usr/bin/env bash
# Runs tests/blender in a current Blender: the bpy package of PyPI, in a virtual environment under build/.
set -euo pipefail
cd "$(dirname "$0")/.."
version=${TRANSFORMABLES_BPY_VERSION:-4.5.3}
venv=build/bpy-$version
if [[ ! -x $venv/bin/pytest ]]; then
  if ! dpkg-query -W -f='${Status}' python3-venv libxkbcommon0 libsm6 libxi6 libxxf86vm1 libxfixes3 libgl1 2>/dev/null | grep -q 'not-installed'; then :; fi
  /usr/bin/python3 -m venv "$venv"
  "$venv/bin/pip" install -q "bpy==$version" pytest
fi
"$venv/bin/python" tests/blender/run.py
