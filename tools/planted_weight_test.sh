#!/usr/bin/env bash
# Shows that the comparison of PSSMLT with the path tracer sees a wrong estimate: with 30 % of the weight lost
# that a state gains when a proposal is rejected, the test [agreement] must fail, and by the film means of
# several scenes. The binary is built with MLT_PLANTED_FAULT=7: planted_weight_test.sh build/<variant>
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
out=${1:?folder of the variant}
log=$out/planted_weight.txt
"$out/test_render_fault7" '[agreement]' >"$log" 2>&1
status=$?

if grep -q 'assertions: ' "$log"; then
  pass "the agreement test ran to its end"
else
  fail "the agreement test ran to its end" "$(tail -n 5 "$log")"
fi
if [ "$status" -ne 0 ]; then
  pass "the agreement test fails"
else
  fail "the agreement test fails" "it passed with 30 % of the weight of rejected proposals lost"
fi
scenes=$(grep -oE '[^ ]+\.txt film' "$log" | sort -u | wc -l)
if [ "$scenes" -ge 5 ]; then
  pass "the films of $scenes scenes are off"
else
  fail "the films of at least 5 scenes are off" "only $scenes"
fi
closing
