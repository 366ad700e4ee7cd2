#!/usr/bin/env bash
# Runs every fuzz harness for some seconds, side by side: fuzz.sh SECONDS. New inputs that reach new code are
# kept below build/fuzz/corpus; an input that fails is left in build/fuzz and its report printed.
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
seconds=${1:-600}
out=build/fuzz
make -j"${JOBS:-$(nproc)}" VARIANT=fuzz fuzzers || exit 1

run() {
  local name=$1
  mkdir -p "$out/corpus/$name"
  "$out/fuzz_$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="$out/$name-" "$out/corpus/$name" "tests/fuzz/corpus/$name" >"$out/$name.txt" 2>&1
  echo $? >"$out/$name.status"
}
for source in tests/fuzz/*_fuzz.cpp; do
  while [ "$(jobs -rp | wc -l)" -ge "${JOBS:-$(nproc)}" ]; do wait -n; done
  run "$(basename "$source" _fuzz.cpp)" &
done
wait
for source in tests/fuzz/*_fuzz.cpp; do
  name=$(basename "$source" _fuzz.cpp)
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$out/$name.txt")
  if [ "$(cat "$out/$name.status")" = 0 ] && [ "${runs:-0}" -gt 0 ]; then
    pass "fuzz $name: $runs inputs in $seconds s"
  else
    fail "fuzz $name" "$(tail -n 40 "$out/$name.txt")"
  fi
done
closing
