#!/usr/bin/env bash
# Is every C++ file formatted as .clang-format says? Names each place that is not; `format.sh --fix` formats them.
set -euo pipefail
cd "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../.."

action=(--dry-run -Werror)
[[ ${1-} == --fix ]] && action=(-i)

find orchestrator templates tests \( -name '*.cpp' -o -name '*.hpp' \) -print0 | sort -z |
  xargs -0 --no-run-if-empty "${CLANG_FORMAT:-clang-format}" --style=file "${action[@]}"
