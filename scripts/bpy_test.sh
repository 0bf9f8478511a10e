#!/usr/bin/env bash
# Runs tests/blender in a current Blender: the bpy package of PyPI, in a virtual environment under build/.
#   TRANSFORMABLES_BPY_VERSION  which one (4.5.3, the newest for Debian 12's Python 3.11)
set -euo pipefail
cd "$(dirname "$0")/.."
version=${TRANSFORMABLES_BPY_VERSION:-4.5.3}
venv=build/bpy-$version
# pip needs a virtual environment and certificates; bpy brings all but these libraries.
bash scripts/packages.sh python3-venv ca-certificates libgl1 libice6 libsm6 libx11-6 libxext6 libxfixes3 libxi6 libxkbcommon0 libxrender1 libxxf86vm1
if [[ ! -e $venv/ready ]]; then
  rm -rf "$venv"  # of an installation that was interrupted
  /usr/bin/python3 -m venv "$venv"
  "$venv/bin/python" -m pip install -q "bpy==$version" pytest
  touch "$venv/ready"
fi
"$venv/bin/python" tests/blender/run.py "$@"
