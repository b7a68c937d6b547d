#!/usr/bin/env bash
# Makes every map of this folder again, byte for byte. Usage: heightmaps/make.sh [FOLDER]
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
folder="${1:-$here}"
cd "$here/.."
cargo build --release --quiet
mkdir -p "$folder"
seed=1
for sq in 003 050 100 150 201 402 805; do
    target/release/asperity synth --sq "$((10#$sq))nm" --acl 20um --size 1024 --pitch 0.6um --exact --seed "$seed" \
        --samples int16 -o "$folder/epoxy-${sq}nm.x3p"
    seed=$((seed + 1))
done
