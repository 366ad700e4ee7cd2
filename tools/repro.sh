#!/usr/bin/env bash
# Renders the jobs of tests/repro/expected_hashes.txt by other thread counts, compilers, optimisations,
# sanitizers and machines, and compares the hashes of the films: repro.sh quick|rest|full|accept
#   quick   thread counts, shared films, g++ and clang++, three levels, ASan with UBSan, TSan, Valgrind
#   rest    link-time optimisation, AVX2 with FMA, AVX-512, MSan, emulated processors and aarch64
#   full    both
#   accept  writes the hashes of build/release into the file (CHANGELOG.md must then say why)
# Each line is: scene integrator options hash.
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
. tools/instruction_sets.sh
mode=${1:-quick}
expected=tests/repro/expected_hashes.txt
build_jobs=${JOBS:-$(nproc)}
log=build/repro
mkdir -p "$log"

build() {  # build VARIANT: its film_hash, or a failing cell
  make -j"$build_jobs" VARIANT="$1" "build/$1/film_hash" >"$log/$1.txt" 2>&1 && return 0
  fail "$1 builds" "$(grep -E 'error|\*\*\*' "$log/$1.txt" | head -n 10)"
  return 1
}

# render_jobs FILTER COMMAND...: the lines of the list whose scene and integrator match, with the hash that
# the command gives, as many at a time as there are cores.
render_jobs() {
  local filter=$1
  shift
  # shellcheck disable=SC2016
  grep -vE '^(#|$)' "$expected" | grep -E "$filter" | awk '{ NF--; print }' |
    xargs -d '\n' -P "$build_jobs" -I LINE bash -c '
      read -ra word <<<"$1"
      hash=$("${@:2}" "${word[0]}" "integrator=${word[1]}" "${word[@]:2}" 2>&1 | tail -n 1)
      printf "%s %s\n" "$1" "$hash"' job LINE "$@" | sort
}

# cell NAME FILTER COMMAND...: one entry of the matrix; lists each job whose film differs.
cell() {
  local name=$1 filter=$2 start=$SECONDS found wrong
  shift 2
  found=$(render_jobs "$filter" "$@")
  wrong=$(diff <(grep -vE '^(#|$)' "$expected" | grep -E "$filter" | sort) <(printf '%s\n' "$found") |
    sed -n 's/^</expected/p; s/^>/found   /p')
  if [ -n "$found" ]; then
    expect_empty "$name ($(wc -l <<<"$found") jobs, $((SECONDS - start)) s)" "$wrong"
  else
    fail "$name" "no job matches $filter"
  fi
}
all=.
# For machines that are slow to emulate, the jobs with the smallest scenes.
small='^scenes/(CornellBox|spheres|conductor).*seed=0 '

variant() {  # variant NAME [COMMAND...]: every job, by 3 threads
  local name=$1
  shift
  build "$name" && cell "$name" "$all" "$@" "build/$name/film_hash" threads=3
}

make -j"$build_jobs" scenes >"$log/scenes.txt" 2>&1 || fail "scenes" "$(tail -n 5 "$log/scenes.txt")"
build release || { closing; exit 1; }

if [ "$mode" = accept ]; then
  render_jobs "$all" build/release/film_hash threads=2 >"$log/accepted"
  if grep -vE ' [0-9a-f]{64}$' "$log/accepted"; then
    echo "These jobs gave no hash; the list stays as it is."
    exit 1
  fi
  # The list keeps its order and comments.
  awk 'NR == FNR { hash = $NF; NF--; fresh[$0] = hash; next }
    /^(#|$)/ { print; next }
    { NF--; print $0, fresh[$0] }' "$log/accepted" "$expected" >"$log/list" && mv "$log/list" "$expected"
  echo "CHANGELOG.md needs a line with 'golden: $(sha256sum "$expected" | cut -c1-16)' and the reason."
  exit 0
fi

has_cpu() { grep -qw "$1" /proc/cpuinfo; }
skip() { echo "skip  $1: $2"; }
# refuses NAME SET COMMAND...: a processor that lacks the set says so and what it has.
refuses() {
  local name=$1 set=$2 said
  shift 2
  said=$("$@" scenes/CornellBox.txt width=8 height=8 "isa=$set" 2>&1 | grep -v 'TCG does')
  expect_empty "$name refuses $set" "$(grep -qxE -e \
    "--isa: found $set, which this processor or this binary does not have, allowed is base.*" <<<"$said" ||
    echo "said: $said")"
}

# ---- quick ----

if [ "$mode" != rest ]; then
  same=$(grep -vE '^(#|$)' "$expected" | awk '{ print $NF }' | sort | uniq -d)
  expect_empty "different jobs and seeds have different hashes" \
    "$(grep -F "${same:-nothing is the same}" "$expected")"
  for threads in 1 2 3 7 16 64; do
    cell "threads $threads" "$all" build/release/film_hash "threads=$threads"
  done
  # Jobs so small have a film for each thread unless told otherwise.
  cell "threads 7, one film" " pssmlt " build/release/film_hash threads=7 film_memory=0
  # The kernels of each instruction set that a release build holds.
  for set in $(instruction_sets); do
    lacking=$(lacks_for "$set")
    if [ -n "$lacking" ]; then
      skip "kernels for $set" "this processor lacks $lacking"
    else
      cell "kernels for $set" "$all" build/release/film_hash threads=3 "isa=$set"
    fi
  done
  for name in gcc-O0 gcc-O3 clang clang-O0 clang-O3 asan tsan; do variant "$name"; done
  cell "tsan, one film" " pssmlt .*seed=0 " build/tsan/film_hash threads=3 film_memory=0
  # Valgrind has no AVX-512 and shows none to the program, which then falls back.
  cell "valgrind" "$small" valgrind --quiet --undef-value-errors=no build/release/film_hash threads=2
  refuses "valgrind" avx512 valgrind --quiet build/release/film_hash
fi

# ---- rest ----

if [ "$mode" != quick ]; then
  variant gcc-lto
  variant clang-asan
  for compiler in gcc clang; do
    if has_cpu avx2 && has_cpu fma; then
      variant "$compiler-avx2"
    else
      skip "$compiler-avx2" "this processor lacks AVX2 or FMA"
    fi
    if has_cpu avx512vl && has_cpu avx512bw && has_cpu avx512dq && has_cpu avx512cd; then
      variant "$compiler-v4"
    else
      skip "$compiler-v4" "this processor lacks AVX-512"
    fi
  done
  variant msan
  for name in aarch64 clang-aarch64; do
    build "$name" && cell "$name under qemu" "$all" qemu-aarch64 "build/$name/film_hash" threads=2
  done
  # From a processor without SSE3 to one with AVX2: the libraries choose other code on each.
  for model in qemu64 core2duo Nehalem Haswell; do
    cell "emulated $model" "$small" qemu-x86_64 -cpu "$model" build/release/film_hash threads=2
    refuses "emulated $model" avx512 qemu-x86_64 -cpu "$model" build/release/film_hash
  done
fi
closing
