#!/usr/bin/env bash
# Trains the network of `gnn-tour` on a machine with a GPU and many cores:
#
#   train/gpu/dagger.sh DIR
#
# leaves gnn-tour.safetensors in DIR. While train.py learns, WORKERS processes record `tour` where the network of that
# moment leads (an eighth of them: where tour leads, with random moves), and what they record is learned from at once.
# So the weights depend on the machine's speed: another run gives others, about as good. The built-in ones are of one
# GPU (H100) and 16 cores, 14 minutes, 67,749 decisions. DRAGNET and GRAPHS name the programs of `cargo build --release`
# and of `cargo build --release -p dragnet-learn --example graphs`; nothing else of this repository is needed there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=${1:?usage: train/gpu/dagger.sh DIR}
workers=${WORKERS:-14}
dragnet=${DRAGNET:-$here/../../target/release/dragnet}
graphs=${GRAPHS:-$here/../../target/release/examples/graphs}
weights=$out/gnn-tour.safetensors
mkdir -p "$out/graphs" "$out/demonstrations"

# worker NUMBER FIRST_SEED END: records until END, seconds of the clock, four searches of the mixture at a time.
worker() {
    local number=$1 seed=$2 end=$3 round=0 folder follow=()
    folder=$out/demonstrations/$number
    while [ "$(date +%s)" -lt "$end" ]; do
        follow=(--explore 0.3)
        if [ -e "$weights" ] && [ $((round % 8)) -ne 7 ]; then
            cp "$weights" "$folder.safetensors"
            follow=(--explore 0.05 --follow "$folder.safetensors")
        fi
        rm -rf "$folder"
        "$dragnet" demonstrate --mixture --expert tour --seeds "$seed..$((seed + 4))" --threads 1 \
            --max-decisions 40 "${follow[@]}" --out "$folder" >/dev/null
        "$graphs" "$folder" "$folder.new"
        mv "$folder.new" "$out/graphs/$seed.safetensors"
        seed=$((seed + 4))
        round=$((round + 1))
    done
}

# stage MINUTES FIRST_SEED [OPTION..]: one fall of the learning rate.
stage() {
    local minutes=$1 seed=$2 end
    shift 2
    end=$(($(date +%s) + minutes * 60 - 25))
    python3 "$here/train.py" --graphs "$out/graphs/*.safetensors" --watch --out "$weights" --minutes "$minutes" "$@" &
    for number in $(seq "$workers"); do
        worker "$number" $((seed + number * 20000)) "$end" &
    done
    wait
}

stage 6 1000000
stage 8 2000000 --start "$weights"
