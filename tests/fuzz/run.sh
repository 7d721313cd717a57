#!/usr/bin/env bash
# Fuzzes for so many seconds: `run.sh TARGET SECONDS [BUILD_FOLDER]`, TARGET being workflow, template or protocol; or
# `run.sh build` builds all three into .build/fuzz. Starts from corpus/TARGET; what is found new goes to the build folder.
# An input that breaks something is kept there as crash-*, to be run again: BUILD_FOLDER/tests/fuzz/fuzz_TARGET crash-...
set -euo pipefail
cd "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../.."

command -v clang++-19 >/dev/null || {
  echo "run.sh: skipped, clang++-19 is missing; apt-get install clang-19 libclang-rt-19-dev" >&2
  exit 77
}
build=${3:-.build/fuzz}
if [[ $1 == build ]]; then
  launcher=$(command -v ccache || true)
  cmake --preset fuzz -B "$build" -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" >/dev/null
  exec ninja -C "$build" -j "${SANDGLASS_JOBS:-$(nproc)}" fuzz_workflow fuzz_template fuzz_protocol
fi
target=$1 seconds=$2
declare -A more=([workflow]=workflows [template]=templates [protocol]=) # what the project has to begin with
found=$build/found/$target
mkdir -p "$found"
# 1 GB (sanitizers take their part) and 10 s for one input: far above what any needs, and a limit all the same.
"$build/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1000 -max_len=20000 -close_fd_mask=1 \
  -print_final_stats=1 -artifact_prefix="$build/" ${SANDGLASS_FUZZ_MORE-} "$found" "tests/fuzz/corpus/$target" ${more[$target]} 2>&1 | tail -n 25
exit "${PIPESTATUS[0]}"
