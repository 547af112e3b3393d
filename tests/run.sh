#!/usr/bin/env bash
# Everything that must hold: format, lints, tests in parallel, real-time tests alone one at a time, documentation.
# Needs the Rust toolchain of rust-toolchain.toml and nothing else; one step more is done where there is Python.
set -euo pipefail
cd "$(dirname "$0")/.."

# A machine that builds once needs no caches for the next build: 7 of 10 GB.
if [ -n "${CI:-}" ]; then export CARGO_INCREMENTAL=0; fi

step() { printf '\n== %s (%s s)\n' "$1" "$SECONDS"; }

step 'format';          cargo fmt --all --check
step 'lints';           cargo clippy --workspace --all-targets --locked -- -D warnings
                        cargo clippy --workspace --test real_time --locked -- -D warnings
step 'build';           cargo build --workspace --all-targets --locked
step 'parts alone';     cargo clippy -p umwelt-core --no-default-features --locked -- -D warnings
                        cargo test -p umwelt-core --no-default-features --lib --test robot_side --locked
                        cargo clippy -p umwelt-client --no-default-features --all-targets --locked -- -D warnings
step 'tests';           cargo test --workspace --locked
step 'real-time tests'; cargo test --workspace --test real_time --locked -- --test-threads=1
step 'contract';        bash tests/contract.sh
step 'documentation';   RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps --locked
step 'done'
