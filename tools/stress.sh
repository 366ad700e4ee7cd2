#!/usr/bin/env bash
# All sweeps of tests/stress, the short ones of `make test` too: stress.sh build/<variant>. Prints their
# tables, which are kept in build/<variant>/stress.txt, and Catch's closing line.
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
out=${1:?folder of the variant}
"$out/test_stress" '*' --durations yes >"$out/stress.txt" 2>&1
status=$?
cat "$out/stress.txt"
exit $status
