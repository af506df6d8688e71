#!/usr/bin/env bash
# Puts libtorch, which training needs, where `.cargo/config.toml` looks for it: third_party/libtorch.
#
# It comes out of the wheels of `libtorch.txt`, of which only what a CPU needs is kept, in a cache folder that all
# checkouts share. Once it is there, this takes milliseconds. Whether it is killed or runs twice at once: under its name
# stands all of libtorch or nothing. If LIBTORCH is set, it does nothing: the build uses what that names.
set -euo pipefail
cd "$(dirname "$0")/.."

version=2.13.0
link=third_party/libtorch
cache=${XDG_CACHE_HOME:-${HOME:?}/.cache}/dragnet
kept=$cache/libtorch-$version
# Only who holds the lock writes here, so that what is there already was left by a run that was killed.
part=$kept.part

fail() {
    echo "train/libtorch.sh: $1" >&2
    echo "A libtorch $version that is there already will do as well: set LIBTORCH to its folder, the one of lib/ and" \
        "include/. What does not train needs none: cargo test --workspace --exclude dragnet-train." >&2
    exit 2
}

is_libtorch() { [[ "$(cat "$1/build-version" 2>/dev/null)" =~ ^"$version"(\+|$) ]]; }

download() {
    [[ "$(uname -sm)" == "Linux x86_64" ]] && getconf GNU_LIBC_VERSION >/dev/null 2>&1 ||
        fail "only x86-64 Linux with glibc is known here, and this is $(uname -sm)"
    rm -rf "$part"
    mkdir -p "$part/libtorch/lib"
    python3 -m venv "$part/venv" ||
        fail "python3 with its venv module is needed (on Debian: apt-get install python3-venv)"
    echo "train/libtorch.sh: downloading libtorch $version, 540 MB, unless pip has it in its cache" >&2
    TMPDIR=$part "$part/venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile --no-deps \
        --require-hashes --requirement train/libtorch.txt ||
        fail "pip could not install train/libtorch.txt, which is for CPython 3.10 to 3.14 and glibc 2.28 or later;
this is $(python3 --version) and $(getconf GNU_LIBC_VERSION)"
    keep_what_a_cpu_needs "$part"/venv/lib/python3*/site-packages
    echo "$version" >"$part/libtorch/build-version"
    rm -rf "$kept"
    mv "$part/libtorch" "$kept"
    rm -rf "$part"
}

keep_what_a_cpu_needs() {
    mv "$1/torch/include" "$part/libtorch/"
    mv "$1"/torch/lib/lib{torch_cpu.so,c10.so,gomp.so.1} "$1"/nvidia/cu13/lib/lib{cupti,cudart}.so.13 \
        "$part/libtorch/lib/"
    # The wheel's own is empty but for its wish for CUDA; this one stands for the CPU's part alone.
    echo 'INPUT(-ltorch_cpu)' >"$part/libtorch/lib/libtorch.so"
}

if [[ -n ${LIBTORCH:-} ]] || is_libtorch "$link"; then
    exit 0
fi
mkdir -p "$cache" "$(dirname "$link")"
exec {lock}>"$kept.lock"
flock "$lock"
is_libtorch "$kept" || download
ln --symbolic --force --no-target-directory "$kept" "$link"
