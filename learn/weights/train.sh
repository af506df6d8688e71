#!/usr/bin/env bash
# Trains the networks that are part of the program, from demonstrations to weights: about half an hour on two cores.
#
#   learn/weights/train.sh DIR [NAME..]
#
# leaves NAME.safetensors and how its training went in DIR, and demonstrations in DIR/demonstrations; without names, all
# networks. What is there already is kept, so a run that was stopped goes on. DRAGNET names the program, by default that
# of `cargo build --release --features train`. Nothing here is chosen by chance: the same commit gives the same weights.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
dragnet=${DRAGNET:-$root/target/release/dragnet}
maps=$root/scenarios/paper

# name           expert  epochs  seeds           what is searched
recipes="
gnn              path    12      0..1500         --mixture --most-decisions 20
gnn-path         path    12      100000..101600  $maps/ice_cream_cone.toml
gnn-greedy       greedy  5       100000..101600  $maps/ice_cream_cone.toml
gnn-greedy-at    greedy  5       100000..100850  $maps/all_traversable.toml
gnn-path-at      path    10      100000..100700  $maps/all_traversable.toml
gnn-greedy-four  greedy  5       100000..101000  $maps/figure_four.toml
gnn-greedy-oa    greedy  5       100000..101000  $maps/open_asterisk.toml
"

one() {
    local out=$1 name=$2 expert=$3 epochs=$4 seeds=$5
    shift 5
    local demonstrations=$out/demonstrations/$name
    if [ -e "$out/$name.safetensors" ]; then return; fi
    "$dragnet" demonstrate "$@" --expert "$expert" --seeds "$seeds" --threads 1 --out "$demonstrations"
    "$dragnet" train --demonstrations "$demonstrations" --epochs "$epochs" --out "$out/$name.safetensors" \
        | sed "s/^/$name: /"
}

out=${1:?usage: learn/weights/train.sh DIR [NAME..]}
shift
mkdir -p "$out"
running=0
while read -r name rest; do
    if [ -z "$name" ] || { [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; }; then continue; fi
    # Two at a time, each on one thread.
    if [ "$running" -ge 2 ]; then
        wait -n
        running=$((running - 1))
    fi
    # shellcheck disable=SC2086 # several words
    one "$out" "$name" $rest &
    running=$((running + 1))
done <<<"$recipes"
while [ "$running" -gt 0 ]; do
    wait -n
    running=$((running - 1))
done
