#!/usr/bin/env bash
# Runs the benchmark programs one after the other and joins their rows (tests/bench/row.hpp) to one table and
# one file, both with the machine's description in their head:
#   bench.sh FOLDER FLAGS_FILE PROGRAM...      writes FOLDER/bench.csv
# FLAGS_FILE holds the compiler's command. Head lines of the CSV begin with '#'.
set -eu -o pipefail
export LC_ALL=C
cd "$(dirname "$0")/.."
folder=${1:?folder} flags=${2:?file of flags}
shift 2
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
columns=figure,scene,unit,median,quartile_1,quartile_3,runs,rival,rival_median,ratio_to_rival,note

# user nice system idle iowait irq softirq steal of all processors, in ticks
ticks() { awk '/^cpu / { print $2, $3, $4, $5, $6, $7, $8, $9 }' /proc/stat; }
# Processor seconds of this script's finished children. A pipe would make a shell that has none.
own_seconds() {
  times >"$work/times"
  awk 'NR == 2 { gsub(/[ms]/, " "); print 60 * $1 + $2 + 60 * $3 + $4 }' "$work/times"
}

governor() { cat /sys/devices/system/cpu/cpu0/cpufreq/scaling_governor 2>/dev/null || echo "not shown"; }

# What else the processors did while the programs ran: shares of all their time.
disturbance() {
  echo "$before $after $(getconf CLK_TCK) $own" | awk '{
    for (i = 1; i <= 8; ++i) { spent[i] = $(i + 8) - $i; total += spent[i] }
    busy = total - spent[4] - spent[5] - spent[8]
    printf "%.0f s; of all processor time %.0f %% these programs, %.0f %% other processes, %.0f %% steal\n",
           total / $17 / '"$(nproc)"', 100 * $18 * $17 / total, 100 * (busy - $18 * $17) / total,
           100 * spent[8] / total }'
}

head_lines() {
  echo "# version: $(git describe --always --dirty 2>/dev/null || echo unknown)"
  echo "# processor: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores," \
    "governor $(governor)"
  echo "# memory: $(awk '/^MemTotal/ { printf "%.1f GB", $2 / 1e6 }' /proc/meminfo)"
  echo "# system: $(uname -sr)"
  echo "# compiler: $("$(cut -d ' ' -f 1 "$flags")" --version | head -n 1)"
  echo "# flags: $(cat "$flags")"
  echo "# run: $([ "${BENCH_QUICK:-}" = 1 ] && echo "quick, ")$(disturbance)"
}

# Columns of a table for the terminal, as wide as their widest cell.
table() {
  awk -F , '{
    cells[NR, 1] = $1; cells[NR, 2] = $2; cells[NR, 3] = $4; cells[NR, 4] = $3
    cells[NR, 5] = NR == 1 ? "quartiles" : $5 == $6 ? "" : $5 " to " $6
    cells[NR, 6] = NR == 1 ? "compared" : $8 == "" ? $11 : $10 " x " $8 " (" $9 ")"
    for (i = 1; i <= 6; ++i) if (length(cells[NR, i]) > width[i]) width[i] = length(cells[NR, i])
  }
  END {
    for (row = 1; row <= NR; ++row) {
      line = ""
      for (i = 1; i <= 6; ++i) line = line sprintf("%" (i == 3 ? "" : "-") width[i] "s  ", cells[row, i])
      sub(/ +$/, "", line)
      print line
    }
  }'
}

before=$(ticks)
own_seconds >"$work/own_before"
for program in "$@"; do
  began=$SECONDS
  "$program" >>"$work/rows"
  echo "$program: $((SECONDS - began)) s" >&2
done
after=$(ticks)
awk -F , 'NF != 11 { print "not a row: " $0; wrong = 1 } END { exit wrong }' "$work/rows" >&2
own_seconds >"$work/own_after"
own=$(awk 'NR == 1 { before = $1 } NR == 2 { print $1 - before }' "$work/own_before" "$work/own_after")

head_lines >"$work/head"
{ cat "$work/head" && echo "$columns" && cat "$work/rows"; } >"$folder/bench.csv.part"
mv "$folder/bench.csv.part" "$folder/bench.csv"
cat "$work/head"
{ echo "$columns" && cat "$work/rows"; } | table
echo "# $folder/bench.csv"
