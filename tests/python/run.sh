#!/bin/sh
# Compares the readers and writers of asperity with those of other programs on PyPI. Not part of `cargo test`.
#
#     cargo build --release && tests/python/run.sh
#
# Installs what it needs into target/venv-readers. ASPERITY names another binary, ASPERITY_SHARED another collection of
# real files.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
venv="$root/target/venv-readers"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
fi
: "${ASPERITY:=$root/target/release/asperity}" "${ASPERITY_SHARED:=$root/../shared}"
export ASPERITY ASPERITY_SHARED
exec "$venv/bin/python" "$here/readers_agree.py"
