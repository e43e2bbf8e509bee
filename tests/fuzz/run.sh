#!/usr/bin/env bash
# Runs one target: run.sh script|ini|protocol|trace|gcode-line|gcode-program [libFuzzer options]. Needs a nightly toolchain and nothing else.
# `run.sh TARGET -pack` minimises what the last runs left in found/corpus/TARGET, and packs it as corpus/TARGET.tar.gz.
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
program="${CARGO_TARGET_DIR:-target}/$triple/release/$target"
mkdir -p found/corpus
tar -xzf "corpus/$target.tar.gz" -C found/corpus
if [ "${1:-}" = -pack ]; then
    smallest=$(mktemp -d)
    mkdir "$smallest/$target"
    "$program" -set_cover_merge=1 "$smallest/$target" "found/corpus/$target"
    tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --format=ustar -C "$smallest" -cf - "$target" |
        gzip -9n > "corpus/$target.tar.gz"
    rm -r "$smallest"
else
    "$program" -artifact_prefix=found/ "$@" "found/corpus/$target"
fi
