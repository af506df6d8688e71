#!/usr/bin/env bash
# Builds `dragnet` for robots: one file that needs nothing of the machine that it runs on, and so without libtorch. A detector
# reads ONNX files.
#
#   deploy/build.sh [x86_64|aarch64 ...]     # both, if none is named
set -euo pipefail
cd "$(dirname "$0")/.."

(($#)) || set -- x86_64 aarch64
for machine in "$@"; do
    [[ $machine == x86_64 || $machine == aarch64 ]] || {
        echo "deploy/build.sh: \"$machine\" is not known here; allowed are x86_64 and aarch64" >&2
        exit 2
    }
done

deploy/toolchain.sh
triples=("${@/%/-unknown-linux-musl}")
# In one go: while one program is linked, the other is still compiled.
PATH=$PWD/target/zig/bin:$PATH cargo zigbuild --locked --profile deploy --features onnx --target-dir target \
    "${triples[@]/#/--target=}"
for machine in "$@"; do
    program=target/$machine-unknown-linux-musl/deploy/dragnet
    echo "$program: $(stat --format %s "$program") bytes"
done
