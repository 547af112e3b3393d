#!/usr/bin/env bash
# Simulated results to the last digit: champion, comparison and link table are those in tests/golden. Some two minutes.
# A change that means to change them writes them anew with UPDATE_GOLDEN=1 and says so in CHANGELOG.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --quiet --release --package umwelt-server --bin umwelt-server
cargo build --quiet --release --package umwelt-core --example link_table
server=${CARGO_TARGET_DIR:-target}/release/umwelt-server
table=${CARGO_TARGET_DIR:-target}/release/examples/link_table
check() {
    local golden=tests/golden/$1.txt printed
    shift
    # How long it took and on how many threads is no result.
    printed=$("$@" 2>/dev/null | sed '/ on [0-9]* threads/d')
    if [ -n "${UPDATE_GOLDEN:-}" ]; then printf '%s\n' "$printed" >"$golden"; fi
    diff "$golden" <(printf '%s\n' "$printed")
    echo "$golden: the same"
}
check evolve-quick "$server" evolve --preset quick --seed 1
check compare-thesis-50 "$server" compare --scenario thesis --trials 50 --seed 1
check link-table-300 "$table" 300
