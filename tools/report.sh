# For check scripts, to be sourced: counts and prints results in the form that tools/run_tests.sh reads.
passed=0
failed=0
pass() { passed=$((passed + 1)); echo "ok    $1"; }
fail() {  # fail NAME [DETAILS]
  failed=$((failed + 1))
  echo "FAIL  $1"
  [ -n "${2:-}" ] && printf '%s\n' "$2" | sed 's/^/      /'
}
# expect_empty NAME TEXT: passes when TEXT is empty; otherwise TEXT lists the offending places.
expect_empty() { if [ -z "$2" ]; then pass "$1"; else fail "$1" "$2"; fi; }
closing() {
  echo "$passed passed, $failed failed"
  [ "$failed" -eq 0 ]
}
