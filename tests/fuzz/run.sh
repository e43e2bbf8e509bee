#!/usr/bin/env bash
# Runs one target: run.sh script|ini|protocol|trace [libFuzzer options]. Needs a nightly toolchain and nothing else.
set -euo pipefail
cd "$(dirname "$0")"
target=$1
shift
triple=$(rustc -vV | sed -n 's/^host: //p')
export RUSTFLAGS="--cfg fuzzing -Clink-dead-code -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Zsanitizer=address"
# With a target named, build scripts and macros are built without those flags.
cargo +nightly build --release --target "$triple" --bin "$target"
mkdir -p found
"${CARGO_TARGET_DIR:-target}/$triple/release/$target" -artifact_prefix=found/ "$@" corpus/"$target"
