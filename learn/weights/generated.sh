#!/usr/bin/env bash
# Writes 100 scenarios on generated maps that no network was trained on, to compare policies on:
#
#   learn/weights/generated.sh DIR
set -euo pipefail
out=${1:?usage: learn/weights/generated.sh DIR}
mkdir -p "$out"
shapes=(caves blocks rooms)
densities=(0.01 0.2)
for number in $(seq 0 99); do
    cat >"$out/generated_$number.toml" <<TOML
name = 'generated_$number'
map = { shape = '${shapes[number % 3]}', rows = 30, columns = 30, cell_meters = 30.0, seed = $((5000 + number)) }
objects.density = ${densities[number % 2]}
robots = { count = 1, policy = 'path', start = 'scattered' }
mission.budget_meters = 9000.0
TOML
done
