#!/bin/sh
# A picture to judge by eye: facets and their normals, naive rays, where the light goes, and the lobe of the table.
#
#     cargo build --release && tests/visual/run.sh [PICTURE.png]
#
# Installs what it needs into target/venv-visual; draws off-screen, without a display. ASPERITY names another binary.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
venv="$root/target/venv-visual"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
fi
asperity=${ASPERITY:-$root/target/release/asperity}
picture=${1:-$root/target/visual_check.png}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Rougher across (y) than along (x), so that a turned or mirrored lobe shows.
"$asperity" synth -o "$work/map.npy" --size 384x320 --pitch 0.5um,0.6um --sq 0.7um --acl 9um,4.5um --seed 7 --samples f64 --exact
"$asperity" brdf "$work/map.npy" -o "$work/table.npz" --unit m --pitch 0.5um,0.6um --material mirror \
    --theta-i 0,15,30,45,60 --symmetry anisotropic --method facets
"$venv/bin/python" "$here/visual_check.py" "$work/map.npy" "$work/table.npz" "$picture"
