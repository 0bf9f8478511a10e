#!/usr/bin/env bash
# Designs a bundled example, a spider that folds into a car, and renders it.
# Another example: bash scripts/demo.sh egg_human   (names: blend_examples/*.blend)
set -euo pipefail
cd "$(dirname "$0")/.."
example=${1:-car_spider_1}
[[ -f blend_examples/$example.blend ]] || { echo "demo: no example is called '$example'; there are: $(basename -s .blend blend_examples/*.blend | tr '\n' ' ')" >&2; exit 2; }
bash scripts/setup.sh
out=build/demo
mkdir -p "$out"
code=0
blender -b "blend_examples/$example.blend" --python addon/transformables/cli.py -- design --output "$out/$example.blend" --report "$out/$example.json" || code=$?
if [[ $code != 0 && $code != 3 ]]; then exit "$code"; fi
blender -b "$out/$example.blend" --python-exit-code 1 --python scripts/render_design.py -- "$out/pictures" > "$out/render.log" 2>&1 || { cat "$out/render.log"; exit 1; }
mv "$out/pictures/00.png" "$out/1_character_mode.png"
mv "$out/pictures/01.png" "$out/2_half_folded.png"
mv "$out/pictures/02.png" "$out/3_object_mode.png"
rmdir "$out/pictures"
echo
echo "The design:  $out/$example.blend (play the timeline in Blender)"
echo "Its report:  $out/$example.json"
echo "Pictures:    $out/1_character_mode.png, $out/2_half_folded.png, $out/3_object_mode.png"
if [[ $code == 3 ]]; then echo "Some collisions are left; the report lists them."; fi
