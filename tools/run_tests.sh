#!/usr/bin/env bash
# Runs the stage tests, the lint and the quick proofs of one variant side by side:
#   run_tests.sh build/<variant> [--only TAG] STAGE...
# Output goes to build/<variant>/log; failing programs are shown in full. Ends with 'N passed, N failed',
# the sum of test cases (Catch) and checks (scripts).
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
out=${1:?folder of the variant}
shift
filter=()
scripts=(tests/lint/lint.sh tests/lint/planted.sh tools/proof.sh)
if [ "${1:-}" = --only ]; then
  filter=("$2")
  shift 2
  scripts=()
fi
# Lint and proofs read sources and the release objects; once, beside all stages, is enough.
[ "$out" = build/release ] && [ $# -gt 1 ] || scripts=()
log=$out/log
rm -rf "$log"
mkdir -p "$log"
jobs=${JOBS:-$(nproc)}
export out log MLT_BINARY=${MLT_BINARY:-$out/mlt}

names=()
run() {  # run NAME COMMAND...: one program, its output, exit code and seconds into the log
  local name=$1 start=$EPOCHREALTIME status end
  shift
  "$@" >"$log/$name.txt" 2>&1
  status=$?
  end=$EPOCHREALTIME
  echo "$status $(((${end/./} - ${start/./}) / 10000))" >"$log/$name.status"
}

# The longest first, so that no core is left with it alone at the end.
ordered=()
for stage in "$@"; do
  if [ "$stage" = render ]; then ordered=("$stage" "${ordered[@]}"); else ordered+=("$stage"); fi
done
for stage in "$@"; do names+=("test_$stage"); done
for stage in "${ordered[@]}"; do
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
  run "test_$stage" "$out/test_$stage" --durations yes "${filter[@]}" &
done
for script in "${scripts[@]}"; do
  name=$(basename "$script" .sh)
  names+=("$name")
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
  run "$name" bash "$script" "$out" &
done
wait

# count NAME: sets cases_passed and cases_failed from the closing lines of Catch or tools/report.sh.
count() {
  read -r cases_passed cases_failed < <(awk '
    /^All tests passed \(/ { for (i = 1; i < NF; ++i) if ($(i + 1) ~ /^test/) passed = $i; found = 1 }
    /^test cases:/ {
      n = split($0, part, "|")
      for (i = 2; i <= n; ++i) {
        split(part[i], word, " ")
        if (word[2] == "failed") failed = word[1]; else passed += word[1]
      }
      found = 1
    }
    /^[0-9]+ passed, [0-9]+ failed$/ { passed = $1; failed = $3; found = 1 }
    /^No tests ran/ { found = 1 }
    END { if (!found) failed = 1; print passed + 0, failed + 0 }' "$log/$1.txt")
}

total_passed=0
total_failed=0
for name in "${names[@]}"; do
  read -r status centiseconds <"$log/$name.status"
  count "$name"
  # A program that dies after its closing line, or is killed by a sanitizer, has failed too.
  if [ "$status" -ne 0 ] && [ "$cases_failed" -eq 0 ]; then cases_failed=1; fi
  total_passed=$((total_passed + cases_passed))
  total_failed=$((total_failed + cases_failed))
  [ "$cases_failed" -eq 0 ] || { echo "---- $name failed (exit code $status)"; cat "$log/$name.txt"; }
done
printf '\n%-20s %8s %8s %9s\n' program passed failed seconds
for name in "${names[@]}"; do
  read -r status centiseconds <"$log/$name.status"
  count "$name"
  printf '%-20s %8d %8d %6d.%02d\n' "$name" "$cases_passed" "$cases_failed" \
    $((centiseconds / 100)) $((centiseconds % 100))
done
echo "Slowest test cases:"
grep -ahE '^[0-9]+\.[0-9]+ s: ' "$log"/test_*.txt | sort -rn | head -5 | sed 's/^/  /'
# Once more, at the end, where the shortest excerpt of this output still has them: what failed, and how.
if [ "$total_failed" -ne 0 ]; then
  echo "Failed:"
  for name in "${names[@]}"; do
    awk -v name="$name" '
      /^-+$/ { rule = NR }
      NR == rule + 1 && !/^tests\// { title = $0 }
      /: FAILED:$/ || /^FAIL/ { print "  " name ": " title ": " $0; shown = 4; next }
      shown > 0 && NF { print "    " $0; --shown }' "$log/$name.txt" | head -n 40
  done
fi
echo
echo "$total_passed passed, $total_failed failed"
[ "$total_failed" -eq 0 ]
