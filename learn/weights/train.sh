#!/usr/bin/env bash
# Trains the networks that are part of the program, but gnn-tour (train/gpu/dagger.sh), from demonstrations to weights:
# about half an hour on two cores.
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

# A network whose ways may be longer than those of the map that it learns on also learns on a larger one: two rows.
#
# name           expert  epochs  seeds           what is searched
recipes="
gnn              path    12      0..1500         --mixture --most-decisions 20
gnn-path         path    10      100000..101000  $maps/ice_cream_cone.toml
gnn-path         path    10      100000..100100  $maps/ice_cream_cone_60.toml
gnn-greedy       greedy  5       100000..101600  $maps/ice_cream_cone.toml
gnn-greedy-at    greedy  5       100000..100850  $maps/all_traversable.toml
gnn-path-at      path    10      100000..100700  $maps/all_traversable.toml
gnn-greedy-four  greedy  5       100000..101000  $maps/figure_four.toml
gnn-greedy-oa    greedy  5       100000..101000  $maps/open_asterisk.toml
"

one() {
    local out=$1 name=$2 row expert epochs seeds searched
    local demonstrations=$out/demonstrations/$name
    if [ -e "$out/$name.safetensors" ]; then return; fi
    while read -r row expert epochs seeds searched; do
        if [ "$row" != "$name" ]; then continue; fi
        # shellcheck disable=SC2086 # several words
        "$dragnet" demonstrate $searched --expert "$expert" --seeds "$seeds" --threads 1 --out "$demonstrations"
        local passes=$epochs
    done <<<"$recipes"
    "$dragnet" train --demonstrations "$demonstrations" --epochs "$passes" --out "$out/$name.safetensors" \
        | sed "s/^/$name: /"
}

out=${1:?usage: learn/weights/train.sh DIR [NAME..]}
shift
mkdir -p "$out"
running=0
for name in $(awk 'NF && !seen[$1]++ { print $1 }' <<<"$recipes"); do
    if [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; then continue; fi
    # Two at a time, each on one thread.
    if [ "$running" -ge 2 ]; then
        wait -n
        running=$((running - 1))
    fi
    one "$out" "$name" &
    running=$((running + 1))
done
while [ "$running" -gt 0 ]; do
    wait -n
    running=$((running - 1))
done
