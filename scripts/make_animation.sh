#!/bin/sh
# Makes docs/images/drive.webp, the animated picture of the README: a simulated town, then a KITTI drive, in the page
# of `mapless view`. Needs build/mapless, npm ci in viewer/, Chromium, and Pillow from PyPI.
# usage: scripts/make_animation.sh KITTI_DRIVE [FOLDER]   FOLDER: for what lies between, default build/animation
set -eu
cd "$(dirname "$0")/.."
drive=$1
folder=${2:-build/animation}
mapless=${MAPLESS:-build/mapless}
rm -rf "$folder"
mkdir -p "$folder"
"$mapless" simulate town2 --duration-s 8 --seed 5 --world level -o "$folder/town"
"$mapless" detect "$folder/town" -o "$folder/town_result"
"$mapless" view "$folder/town" "$folder/town_result" -o "$folder/town.html"
"$mapless" detect "$drive" -o "$folder/kitti_result"
"$mapless" view "$drive" "$folder/kitti_result" -o "$folder/kitti.html"
node viewer/animate.mjs "$folder/frames" "$folder/town.html#colour=object&camera=turn:44:79" "$folder/kitti.html#colour=object&camera=turn:5:40"
python3 -m venv "$folder/python"
"$folder/python/bin/pip" install --quiet pillow
"$folder/python/bin/python" - "$folder/frames" docs/images/drive.webp <<'PYTHON'
import pathlib
import sys

from PIL import Image

frames = [Image.open(f).convert("RGB").resize((720, 405), Image.Resampling.LANCZOS) for f in sorted(pathlib.Path(sys.argv[1]).glob("*.png"))[::2]]
frames[0].save(sys.argv[2], save_all=True, append_images=frames[1:], duration=220, loop=0, quality=34, method=6)
PYTHON
ls -l docs/images/drive.webp
