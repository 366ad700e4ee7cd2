#!/usr/bin/env bash
# Valgrind's memcheck over small renders of every integrator: no read of an uninitialised or freed value, no
# leak, and the same film as without: memcheck.sh build/<variant>
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
out=${1:-build/release}
log=$out/memcheck.txt
while read -r job; do
  read -ra options <<<"$job"
  plain=$("$out/film_hash" "${options[@]}")
  checked=$(valgrind --quiet --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=all \
    "$out/film_hash" "${options[@]}" 2>"$log")
  status=$?
  if [ $status -eq 0 ] && [ -n "$plain" ] && [ "$checked" = "$plain" ]; then
    pass "memcheck: $job"
  else
    fail "memcheck: $job" "exit code $status, film $checked instead of $plain"$'\n'"$(head -n 40 "$log")"
  fi
done <<'JOBS'
scenes/spheres.txt integrator=pssmlt width=16 height=16 spp=8 depth=8 chains=8 bootstrap=2048 threads=2
scenes/CornellBox.txt integrator=pssmlt width=16 height=16 spp=8 depth=5 chains=8 bootstrap=2048 threads=2
scenes/spheres.txt integrator=path width=16 height=16 spp=8 depth=8 threads=2
build/scenes/mesh.txt integrator=path width=16 height=16 spp=4 depth=5 threads=2
JOBS
closing
