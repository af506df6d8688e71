#!/usr/bin/env bash
# Runs all tests. Sets up what they need beyond cargo: libtorch, and a Python environment with independent readers of
# recordings, Ray and PyTorch Geometric.
set -euo pipefail
cd "$(dirname "$0")"

train/libtorch.sh

wanted=$(cat tests/python/requirements.txt scale/requirements.txt train/libtorch.txt tests/python/without_cuda.py)
if [[ $wanted != "$(cat .venv/installed 2>/dev/null)" ]]; then
    python3 -m venv --clear .venv || {
        echo "test.sh: python3 with its venv module is needed (on Debian: apt-get install python3-venv)" >&2
        exit 2
    }
    install() { .venv/bin/python -m pip install --quiet --disable-pip-version-check "$@"; }
    install --requirement tests/python/requirements.txt
    # PyTorch is there already, in pip's cache; what it would bring of NVIDIA's is 2 GB that no test calls.
    install --no-deps --requirement train/libtorch.txt
    .venv/bin/python tests/python/without_cuda.py
    echo "$wanted" > .venv/installed
fi

cargo test --workspace --features train "$@"
