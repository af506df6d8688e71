#!/usr/bin/env bash
# Puts what `deploy/build.sh` needs beyond cargo where it looks for it: Rust's own library for musl, and zig, which is its
# C compiler and linker, in target/zig. Once they are there, this takes a second.
set -euo pipefail
cd "$(dirname "$0")/.."

zig=target/zig

fail() {
    echo "deploy/toolchain.sh: $1" >&2
    exit 2
}

command -v rustup >/dev/null || fail "rustup is needed, for Rust's library for other machines (https://rustup.rs)"
rustup --quiet target add {x86_64,aarch64}-unknown-linux-musl || fail "rustup could not add Rust's library for musl"

wanted=$(cat deploy/zig.txt)
if [[ $wanted != "$(cat "$zig/installed" 2>/dev/null)" ]]; then
    python3 -m venv --clear "$zig" ||
        fail "python3 with its venv module is needed (on Debian: apt-get install python3-venv)"
    "$zig/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes --requirement deploy/zig.txt ||
        fail "pip could not install deploy/zig.txt, which is for x86-64 and aarch64 Linux; this is $(uname -sm)"
    echo "$wanted" >"$zig/installed"
fi
