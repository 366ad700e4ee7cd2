#!/usr/bin/env bash
# All sweeps of tests/stress in full: stress.sh build/<variant>. Prints their tables, which are kept in
# build/<variant>/stress.txt, then the worst error of each, and Catch's closing line. The points that
# `make test` takes from the sweeps are left out, for the sweeps contain them.
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
out=${1:?folder of the variant}
"$out/test_stress" '*' '~*some points*' --durations yes >"$out/stress.txt" 2>&1
status=$?
cat "$out/stress.txt"
awk '/^[^ ]/ { title = $0 } /^  worst error/ { printf "%-46s %s\n", title, substr($0, 3) }' "$out/stress.txt"
grep -E '^(All tests passed|test cases:)' "$out/stress.txt" || status=1
exit $status
