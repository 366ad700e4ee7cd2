#!/usr/bin/env bash
# Proves in layers that between render begin and render end nothing allocates, locks, makes a growth system
# call, takes a page fault, throws or recurses:
#   (a) symbols    what the linker can reach from the render loop calls only what is on the list below
#   (b) recursion  the calls among that code form no cycle
#   (c) guard      a preloaded allocator that ends the process when called in the render zone stays silent
#   (d) strace     between the two marks only the system calls on the list below occur
#   (e) faults     no minor page fault occurs
#   (f) valgrind   the heap is asked as often by 20 times the work
# and shows each layer to see the fault planted for it; and that the program's file stays within its limit:
#   proof.sh build/<variant>
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
out=${1:-build/release}
work=$out/proof
mkdir -p "$work"

# What the loop may call outside of itself. check_failed ends the process, syscall is the futex of base/event.
allowed_symbols='mlt::check_failed\(.*|mlt::replay_context\(\)|clock_gettime|syscall|mem(cpy|move|set|cmp)'
allowed_calls='futex|clock_gettime|clock_nanosleep|getrusage|restart_syscall|sched_yield|prctl|write'
# Where the render zone begins: the phases, what the idle main thread does, the workers and all kernels.
roots=(_ZN3mlt8Renderer5State17render_metropolisEv _ZN3mlt8Renderer5State11render_pathEv
  _ZN3mlt8Renderer5State15report_progressEPv _ZN3mlt10WorkerPool4workEj
  _ZN3mlt13select_kernelEj)

jobs=("scenes/CornellBox.txt integrator=pssmlt width=32 height=32 spp=4 depth=5 chains=24 bootstrap=4096"
  "scenes/spheres.txt integrator=pssmlt width=32 height=32 spp=4 depth=8 chains=24 bootstrap=4096"
  "scenes/corridor.txt integrator=path width=48 height=48 spp=2 depth=8"
  "scenes/spheres.txt integrator=path width=48 height=48 spp=2 depth=8")

# link_core FAULT [SET]: what is reachable from the roots, as one relocatable object, with the kernels of an
# instruction set (Makefile, KERNEL_SETS). base/assert is left out: it formats messages, and is reached only
# to end the process.
link_core() {
  local set=${2:-} own
  local pool=$out/src/render/worker_pool.o undefined=() objects=() object root
  for root in "${roots[@]}"; do undefined+=(-u "$root"); done
  for object in "$out"/src/*/*.o; do
    case $object in
      */src/image/* | */src/compare/* | */src/converge/* | */src/app/*) ;;
      */base/assert.o | *\**) ;;
      "$pool") objects+=("$([ "$1" -eq 0 ] && echo "$pool" || echo "$out/fault$1/worker_pool.o")") ;;
      *)
        own=$out/$set/${object#"$out/src/"}
        if [ -n "$set" ] && [ -e "$own" ]; then objects+=("$own"); else objects+=("$object"); fi
        ;;
    esac
  done
  ld -r --gc-sections "${undefined[@]}" "${objects[@]}" -o "$work/core$1$set.o"
}

# Symbols that the kept code refers to and does not define, without those that are allowed. The symbol table
# alone would also list what only discarded code refers to.
foreign_symbols() {
  local core=$work/core$1.o
  nm "$core" | awk '$1 == "U" { print $2 }' | sort -u >"$work/undefined"
  readelf -rW "$core" | awk '/^Relocation section/ { unwinding = $3 ~ /eh_frame|debug/ }
    $3 ~ /^R_/ && !unwinding { print $5 }' | sort -u | comm -12 - "$work/undefined" | c++filt |
    grep -vxE "$allowed_symbols"
}

# Names of functions on a cycle of direct calls.
recursive_functions() {
  objdump -dr --no-show-raw-insn "$work/core$1.o" | awk '
    /^[0-9a-f]+ <.*>:$/ {
      if (named != "") print own, named
      named = ""
      own = substr($2, 2, length($2) - 3)
      sub(/\.cold.*/, "", own)
      next
    }
    /R_X86_64_(PLT32|PC32|GOTPCREL.*|64)/ {
      target = $NF
      sub(/[-+]0x[0-9a-f]+$/, "", target)
      sub(/^\.text(\.unlikely|\.hot)?\./, "", target)
      sub(/\.cold.*/, "", target)
      if (call) print own, target
      call = 0
      named = ""
      next
    }
    # A call within one section needs no relocation and names its target; jumps within a function do too.
    # With a relocation the name is that of what follows the call, which may be the next function.
    { if (named != "") print own, named
      call = ($2 == "call" || $2 == "jmp")
      named = ($2 == "call" && $NF ~ /^<[^+]*>$/) ? substr($NF, 2, length($NF) - 2) : "" }
    END { if (named != "") print own, named }
  ' | grep -vE '(^| )\.' | sort -u >"$work/calls"
  {
    awk '$1 == $2 { print $1 }' "$work/calls"  # to tsort a pair of equal names is no cycle
    tsort "$work/calls" 2>&1 >/dev/null | grep -v 'input contains a loop' | sed 's/^tsort: //'
  } | c++filt
}

# system_calls STRACE_LOG: names of those made between the marks by any thread.
foreign_calls() {
  awk '/prctl\(PR_SET_NAME, "mlt:render"/ { inside = 1 }
    /prctl\(PR_SET_NAME, "mlt"/ { inside = 0; ended = 1 }
    inside {
      line = $0
      sub(/^[0-9]+ +/, "", line)
      sub(/^<\.\.\. /, "", line)
      if (line ~ /^(\+\+\+|---)/) next
      match(line, /^[a-z0-9_]+/)
      print substr(line, 1, RLENGTH)
    }
    END { if (!ended) print "no marks of the render zone in the trace" }' "$1" | sort | uniq -c |
    awk -v allowed="^($allowed_calls)\$" '$2 !~ allowed'
}

guarded() {  # guarded BINARY JOB: silent when the guard is
  LD_PRELOAD=$PWD/$out/malloc_guard.so "$@" threads=3 2>&1 >/dev/null || echo "exit code $?"
}
traced() {
  local binary=$1
  shift
  strace -f -o "$work/strace" "$binary" "$@" threads=3 >/dev/null 2>"$work/errors" || cat "$work/errors"
  foreign_calls "$work/strace"
}
# The kernel may move a page while the render runs, which is counted as a fault too; the render's own come
# again every time, so the least of three runs counts.
faults() {
  for _ in 1 2 3; do "$@" threads=3 statistics=1 | awk '$1 == "minor_faults" { print $2 }'; done |
    sort -n | head -n 1
}
# heap_use BINARY OPTION...: allocations and frees of the process as Valgrind counts them. The bytes may
# differ: the plan's lines, written before the render, hold numbers of more digits.
heap_use() {
  local binary=$1
  shift
  valgrind --undef-value-errors=no --leak-check=no "$binary" "$@" threads=2 2>&1 >/dev/null |
    sed -n 's/.*total heap usage: \(.* frees\),.*/\1/p'
}
heap_of_units() {  # heap_of_units BINARY FACTOR
  heap_use "$1" scenes/CornellBox.txt integrator=pssmlt width=16 height=16 depth=5 bootstrap=1024 \
    chains=$((4 * $2)) spp=$((2 * $2))
}

# More kernels for more features and instruction sets must not make the program grow without bound.
size_limit=8000000
oversize() {  # oversize FILE: silent when it keeps to the limit
  local bytes
  bytes=$(stat -c %s "$1")
  [ "$bytes" -le $size_limit ] || echo "$1 takes $bytes bytes, allowed are $size_limit"
}

# ---- the render itself ----

# check_code SET: layers (a) and (b) for the kernels of one instruction set, the variant's own when empty.
check_code() {
  local set=$1 name=${1:-base} kept
  if ! link_core 0 "$set" 2>"$work/errors"; then
    fail "(a) symbols, $name: the reachable code links" "$(cat "$work/errors")"
    return
  fi
  expect_empty "(a) symbols, $name: the render loop calls nothing outside itself but what is allowed" \
    "$(foreign_symbols "0$set")"
  expect_empty "(b) recursion, $name: the calls of the render loop form no cycle" \
    "$(recursive_functions "0$set")"
  kept=$(nm "$work/core0$set.o" | grep -ciE ' [tw] ')
  expect_empty "(a) symbols, $name: the kernels are among what was looked at" \
    "$([ "$kept" -gt 100 ] || echo "only $kept functions are reachable from the roots: were they renamed?")"
}
check_code ""
for combined in "$out"/kernel_set_*.o; do
  [ -e "$combined" ] || continue
  set=${combined##*/kernel_set_}
  check_code "${set%.o}"
  # The choice of a set takes one without a table for one that the binary was linked without.
  expect_empty "(a) symbols, ${set%.o}: the program holds the set" \
    "$(nm "$out/film_hash" | grep -q " mlt_kernel_set_${set%.o}$" || echo "no mlt_kernel_set_${set%.o}")"
done
for job in "${jobs[@]}"; do
  read -ra options <<<"$job"
  name=$(basename "${options[0]}" .txt)-${options[1]#integrator=}
  expect_empty "(c) guard: $name" "$(guarded "$out/film_hash" "${options[@]}")"
  expect_empty "(d) strace: $name" "$(traced "$out/film_hash" "${options[@]}")"
  found=$(faults "$out/film_hash" "${options[@]}")
  expect_empty "(e) faults: $name" "$([ "$found" = 0 ] || echo "minor faults: $found")"
done
once=$(heap_of_units "$out/film_hash" 1)
more=$(heap_of_units "$out/film_hash" 20)
[ -n "$once" ] && [ "$once" = "$more" ] && differs= || differs="1x: $once; 20x: $more"
expect_empty "(f) valgrind: 20 times the work asks the heap as often" "$differs"
expect_empty "size: the program takes $(stat -c %s "$out/mlt") bytes of at most $size_limit" \
  "$(oversize "$out/mlt")"

# ---- each layer sees its fault ----

read -ra options <<<"${jobs[0]}"
caught() {  # caught NAME EVIDENCE: passes when there is some
  if [ -n "$2" ]; then pass "$1"; else fail "$1" "the planted fault was not seen"; fi
}
names=(- allocation lock "growth call" "page fault" exception recursion)
planted() { echo "planted ${names[$1]} is caught by layer $2"; }
for k in 1 2 3 5; do
  link_core $k
  caught "$(planted $k "(a)")" "$(foreign_symbols $k)"
done
link_core 6
caught "$(planted 6 "(b)")" "$(recursive_functions 6)"
for k in 1 5; do caught "$(planted $k "(c)")" "$(guarded "$out/film_hash_fault$k" "${options[@]}")"; done
caught "$(planted 3 "(d)")" "$(traced "$out/film_hash_fault3" "${options[@]}")"
found=$(faults "$out/film_hash_fault4" "${options[@]}")
caught "$(planted 4 "(e)")" "$([ "${found:-0}" -gt 0 ] && echo "$found")"
once=$(heap_of_units "$out/film_hash_fault1" 1)
more=$(heap_of_units "$out/film_hash_fault1" 20)
caught "$(planted 1 "(f)")" "$([ "$once" = "$more" ] || echo "$once; $more")"
truncate -s $((size_limit + 1)) "$work/oversize"
caught "a file beyond the limit of size is caught" "$(oversize "$work/oversize")"

closing
