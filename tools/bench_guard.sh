#!/usr/bin/env bash
# Counts the instructions of fixed jobs under callgrind and compares them with tests/bench/instructions.txt:
#   bench_guard.sh build/<variant> [accept]
# More than 3 % above the stored count fails, with the job's name; more than 3 % below asks for the table to
# be renewed by `accept`. Counts do not depend on how busy a machine is, but on compiler and libraries: the
# table names those it was made with. Each job renders enough paths that start-up is a few per cent at most.
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
. tools/instruction_sets.sh
out=${1:?folder of the variant}
mode=${2:-check}
table=tests/bench/instructions.txt
work=$out/bench_guard
mkdir -p "$work"
jobs=${JOBS:-$(nproc)}

# obstacle JOB: why it cannot be counted here. Valgrind shows a program what it can run itself, which is no
# AVX-512: the best set is then another than outside, and this one is refused.
obstacle() {
  local set lacking
  set=$(sed -nE 's/.*\bisa=([a-z0-9]+).*/\1/p' <<<"$1")
  lacking=$(lacks_for "$set")
  if [[ $set == avx512* ]]; then
    echo "Valgrind cannot run $set"
  elif [ -n "$lacking" ]; then
    echo "this processor lacks $lacking"
  fi
}

# count NAME JOB: instructions of one job into a file of that name.
count() {
  local name=$1
  shift
  # shellcheck disable=SC2086
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$out/film_hash" $* threads=1 \
    >"$work/$name.log" 2>&1
  awk '/Collected/ { print $NF }' "$work/$name.log" >"$work/$name.count"
}

while read -r name stored job; do
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
  [ -z "$(obstacle "$job")" ] || continue
  count "$name" "$job" &
done < <(grep -vE '^(#|$)' "$table")
wait

if [ "$mode" = accept ]; then
  {
    grep -E '^#' "$table" | grep -v '^# compiler:'
    echo "# compiler: $(g++ --version | head -n 1)"
    grep -vE '^(#|$)' "$table" | while read -r name stored job; do
      echo "$name $(cat "$work/$name.count") $job"
    done
  } >"$work/table" && mv "$work/table" "$table"
  exit 0
fi

while read -r name stored job; do
  if [ -n "$(obstacle "$job")" ]; then
    echo "skip  $name: $(obstacle "$job")"
    continue
  fi
  found=$(cat "$work/$name.count")
  change=$(awk -v a="${found:-0}" -v b="$stored" 'BEGIN { printf "%+.2f", 100 * (a / b - 1) }')
  wrong=
  if [ -z "$found" ]; then
    wrong=$(tail -n 5 "$work/$name.log")
  elif awk -v c="$change" 'BEGIN { exit !(c > 3) }'; then
    wrong="stored $stored, found $found: $(grep '^# compiler' "$table")"
  fi
  expect_empty "$name: $found instructions, $change %" "$wrong"
  if awk -v c="$change" 'BEGIN { exit !(c < -3) }'; then
    echo "      fewer than stored: tools/bench_guard.sh $out accept"
  fi
done < <(grep -vE '^(#|$)' "$table")
closing
