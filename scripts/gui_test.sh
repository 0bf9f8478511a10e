#!/usr/bin/env bash
# Opens Blender in a window of its own (Xvfb, no screen needed) and plays the scenarios of tests/gui in it.
#   bash scripts/gui_test.sh [scenario ...]
# TRANSFORMABLES_SCREENSHOTS=FOLDER keeps pictures of the panel. Exit code 0: all passed.
set -euo pipefail
cd "$(dirname "$0")/.."

pipe=$(mktemp -u)
mkfifo "$pipe"
# -displayfd: Xvfb takes a free display by itself and tells which.
Xvfb -displayfd 3 -screen 0 1000x760x24 -nolisten tcp 3>"$pipe" 2>/dev/null &
xvfb=$!
trap 'kill "$xvfb" 2>/dev/null || true; rm -f "$pipe"' EXIT
read -r -t 20 number <"$pipe" || { echo "gui_test: Xvfb did not start (is the package xvfb installed?)" >&2; exit 1; }

if [ -n "${TRANSFORMABLES_SCREENSHOTS:-}" ]; then
  mkdir -p "$TRANSFORMABLES_SCREENSHOTS"
  export TRANSFORMABLES_SCREENSHOTS="$(cd "$TRANSFORMABLES_SCREENSHOTS" && pwd)"
fi
DISPLAY=":$number" LIBGL_ALWAYS_SOFTWARE=1 PYTHONDONTWRITEBYTECODE=1 timeout 1500 \
  blender --factory-startup --window-geometry 0 0 1000 760 --no-window-focus --enable-event-simulate \
  --python tests/gui/run.py -- "$@"
