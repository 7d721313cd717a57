#!/usr/bin/env bash
# Does clang-tidy accept every C++ file that is compiled? `tidy.sh [BUILD_FOLDER [PATTERN]]`: the folder holds
# compile_commands.json (default .build/release); only files whose path matches the extended regular expression PATTERN
# are looked at. Takes minutes, so a file that was clean is looked at again only when it, a header, or the checks change.
set -euo pipefail
cd "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../.."

export build=${1:-.build/release} tidy=${CLANG_TIDY:-clang-tidy}
pattern=${2:-.}
command -v "$tidy" >/dev/null || {
  echo "tidy.sh: skipped, $tidy is missing; apt-get install clang-tidy" >&2
  exit 77
}
[[ -r $build/compile_commands.json ]] || {
  echo "tidy.sh: $build/compile_commands.json is missing; build first" >&2
  exit 7
}

# What every verdict rests on besides the file itself: the checks, all our headers, the compiler's arguments.
export common clean=$build/tidy
common=$({
  "$tidy" --version
  cat .clang-tidy "$build/compile_commands.json"
  find orchestrator templates tests -name '*.hpp' -print0 | sort -z | xargs -0 sha256sum
} | sha256sum)
mkdir -p "$clean"

check_one() {
  local digest
  digest=$({ echo "$common" && echo "$1" && cat "$1"; } | sha256sum)
  digest=${digest%% *}
  [[ -e $clean/$digest ]] && return 0
  # GCC's own warning options are unknown to clang; they say nothing about the code.
  "$tidy" -p "$build" --quiet --extra-arg=-Wno-unknown-warning-option "$1" 2>/dev/null && touch "$clean/$digest"
}
export -f check_one

# shellcheck disable=SC2016 # $1 belongs to the inner bash
/usr/bin/python3 - "$build" "$pattern" <<'LIST' | xargs -0 --no-run-if-empty -P "$(nproc)" -I{} bash -c 'check_one "$1"' _ {}
import json, os, re, sys
here = os.getcwd() + os.sep
files = {os.path.realpath(entry["file"]) for entry in json.load(open(sys.argv[1] + "/compile_commands.json"))}
for name in sorted(name.removeprefix(here) for name in files if name.startswith(here)):
    if re.search(sys.argv[2], name):
        print(name, end="\0")
LIST
