#!/usr/bin/env bash
# Runs all tests. Sets up what they need beyond cargo: a Python environment with independent readers of recordings.
set -euo pipefail
cd "$(dirname "$0")"

readers=tests/python/requirements.txt
if ! cmp -s "$readers" .venv/installed; then
    python3 -m venv .venv || {
        echo "test.sh: python3 with its venv module is needed (on Debian: apt-get install python3-venv)" >&2
        exit 2
    }
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --requirement "$readers"
    cp "$readers" .venv/installed
fi

cargo test --workspace "$@"
