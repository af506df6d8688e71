#!/usr/bin/env bash
# Runs all tests. Sets up what they need beyond cargo: libtorch, a Python environment with independent readers of
# recordings and maps, Ray, PyTorch Geometric, ultralytics, Gymnasium, PettingZoo and what learns in their environments,
# MkDocs, and a browser for the live page.
set -euo pipefail
cd "$(dirname "$0")"

# An independent ROS 2 client: a program of its own, with dependencies that are no part of the product. It is compiled while
# the network brings what follows.
cargo build --quiet --locked --manifest-path tests/ros_peer/Cargo.toml --target-dir target/ros_peer &
peer=$!
trap 'kill "$peer" 2>/dev/null || true' EXIT

train/libtorch.sh

wanted=$(cat tests/python/{requirements,site,ultralytics,learners}.txt scale/requirements.txt train/libtorch.txt tests/python/without_cuda.py)
if [[ $wanted != "$(cat .venv/installed 2>/dev/null)" ]]; then
    python3 -m venv --clear .venv || {
        echo "test.sh: python3 with its venv module is needed (on Debian: apt-get install python3-venv)" >&2
        exit 2
    }
    # Python compiles what is imported, when it is imported; of all that is installed that is little.
    install() { .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-compile "$@"; }
    install --requirement tests/python/requirements.txt
    # PyTorch is there already, in pip's cache; what it would bring of NVIDIA's is 2 GB that no test calls.
    install --no-deps --requirement train/libtorch.txt
    # By itself: where some have hashes pip asks for those of all.
    install --no-deps --requirement tests/python/ultralytics.txt --requirement tests/python/learners.txt
    .venv/bin/python tests/python/without_cuda.py
    echo "$wanted" > .venv/installed
fi

# Of Debian, where that can be installed, and only what is missing: Debian's npm conflicts with a Node.js from elsewhere.
# Without them tests say what they did not test.
missing=()
[[ -x /usr/bin/chromium ]] || missing+=(chromium)
[[ $(command -v npm) ]] || missing+=(nodejs npm)
[[ $(command -v ip) ]] || missing+=(iproute2)
[[ $(command -v nft) ]] || missing+=(nftables)
if (( ${#missing[@]} )); then
    if [[ $(id -u) == 0 && $(command -v apt-get) ]]; then
        apt-get update --quiet && apt-get install --quiet --yes --no-install-recommends "${missing[@]}"
    else
        echo "test.sh: missing: ${missing[*]}: no test in a browser, or none with hosts of their own" >&2
    fi
fi
if [[ $(command -v npm) && live/page/package-lock.json -nt live/page/node_modules/.package-lock.json ]]; then
    npm ci --silent --prefix live/page
fi

wait "$peer"
trap - EXIT
# The package for Python, and with it all that is tested.
CARGO=tests/python/cargo VIRTUAL_ENV=$PWD/.venv .venv/bin/maturin develop --manifest-path python/Cargo.toml

# Many tests wait for networks, browsers and processes: two for each core keep it busy.
export RUST_TEST_THREADS=${RUST_TEST_THREADS:-$((2 * $(nproc)))}
cargo test --workspace --features train,detector,onnx "$@"
