#!/usr/bin/env bash
# Measures what docs/RESULTS.md tells, about an hour of one core:
#   results.sh MLT DIR [SIDE_BY_SIDE [TABLE]...]
# Each run of `mlt converge` has a folder DIR/TABLE/SCENE; those that are complete are not made again. Then
# DIR/tables.md holds the tables, as Markdown.
set -eu
export LC_ALL=C
cd "$(dirname "$0")/.."
mlt=${1:?the program}
out=${2:?folder for the results}
side_by_side=${3:-1}
tables=("${@:4}")
[ ${#tables[@]} -gt 0 ] || tables=(equal-time large-step step-size chains bootstrap start roulette-path
  roulette-pssmlt together larger larger-settings size-64 size-128 size-512)
telling=(CornellBox cornell_hidden corridor spheres)
mapfile -t scenes < <(grep -vE '^(#|$)' ref_images/INDEX.txt | cut -d' ' -f1)

# The scenes of a table.
scenes_of() {
  case $1 in
    equal-time) echo "${scenes[@]}" ;;
    larger) echo "${telling[@]}" CornellBox2 mesh ;;
    size-*) echo CornellBox cornell_hidden ;;
    larger-settings) echo cornell_hidden corridor spheres ;;
    *) echo "${telling[@]}" ;;
  esac
}

# converge FOLDER SCENE OPTION...: one run into DIR/FOLDER/SCENE; what it prints stays there as text.txt.
converge() {
  local folder=$out/$1/$2 file
  [ -e "$folder/summary.json" ] && return
  mkdir -p "$folder"
  file=$(awk -v name="$2" '$1 == name { print $2 }' ref_images/INDEX.txt)
  # Roulette as it was in the tables of docs/RESULTS.md, for methods that state nothing else.
  "$mlt" converge "$file" "${@:3}" --roulette 8 --threads 1 --quiet -o "$folder" >"$folder/text.txt" \
    2>"$folder/warnings.txt" || echo "$folder: exit code $?"
}

# The methods of each sweep: the first is the one that the others are compared with.
sweep() {  # sweep NAME SCENE
  local methods=() method size=(--reference "ref_images/$2.pfm" --budgets 64 --replicates 8)
  # There are no references of these sizes, so the error is the variance over replicates.
  case $1 in
    larger*) size=(--width 256 --height 256 --budgets 16 --replicates 6) ;;
    size-*) size=(--width "${1#size-}" --height "${1#size-}" --budgets 16 --replicates 6) ;;
  esac
  while read -r method; do methods+=(--method "$method"); done < <(methods_of "$1")
  converge "$1" "$2" "${methods[@]}" "${size[@]}"
}
methods_of() {
  case $1 in
    large-step) printf 'pssmlt%s\n' '' ' --large-step '{0.05,0.1,0.3,0.5,0.7,0.9} ;;
    step-size)
      printf 'pssmlt%s\n' '' ' --step-size '{0.0625,0.25,4,16} ' --mutation gaussian'{,' --step-size 4'}
      ;;
    chains) printf 'pssmlt%s\n' '' ' --chains '{1,16,64,1024,10000} ;;
    bootstrap) printf 'pssmlt%s\n' '' ' --bootstrap '{1000,5000,100000} ;;
    start) printf 'pssmlt%s\n' '' ' --start first-hit' ' --chains 16'{,' --start first-hit'} ;;
    roulette-path) printf 'path%s\n' '' ' --roulette '{2,4,off} ;;
    roulette-pssmlt) printf 'pssmlt%s\n' '' ' --roulette '{2,4,off} ;;
    together) printf 'pssmlt%s\n' '' ' --large-step '{0.3,0.5}{,' --step-size '{2,4}} ;;
    size-*) printf '%s\n' path pssmlt ;;
    larger-settings)
      printf 'pssmlt%s\n' '' ' --large-step 0.1' ' --step-size '{0.5,2} ' --chains 1024' ' --roulette 4'
      ;;
    larger)
      printf '%s\n' path pssmlt 'pssmlt --step-size 0.25' 'pssmlt --large-step 0.5'{,' --step-size 2'}
      ;;
  esac
}
run_job() {  # run_job TABLE SCENE
  local budgets=4,16,64
  [[ " ${telling[*]} " == *" $2 "* ]] && budgets=4,16,64,256
  case $1 in
    equal-time)
      converge equal-time "$2" --reference "ref_images/$2.pfm" --integrators path,pssmlt \
        --budgets "$budgets" --replicates 12
      ;;
    *) sweep "$1" "$2" ;;
  esac
}
for table in "${tables[@]}"; do
  for scene in $(scenes_of "$table"); do
    while [ "$(jobs -rp | wc -l)" -ge "$side_by_side" ]; do wait -n; done
    run_job "$table" "$scene" &
  done
done
wait

# ---- tables ----

# ratios FOLDER SCENE: "method|ratio [low, high]" by processor time for each method.
ratios() {
  sed -nE 's/^(.*): efficiency against .* by processor time ([^ ]+ \[.*\])$/\1|\2/p' "$out/$1/$2/text.txt"
}

equal_time_table() {
  local scene last
  echo '| scene | relMSE of path | of pssmlt | cpu s of path | of pssmlt | efficiency of pssmlt over path |'
  echo '|---|---|---|---|---|---|'
  for scene in "${scenes[@]}"; do
    # Below 1e-9 the path tracer's error is rounding, and no ratio to it means anything.
    last=$(awk 'NF > 8 && $1 ~ /^(path|pssmlt)$/ { e[$1] = $6; t[$1] = $4 }
      END { print (e["path"] < 1e-9 ? "none" : e["path"]) " | " e["pssmlt"] " | " t["path"] " | " \
        t["pssmlt"] }' \
      "$out/equal-time/$scene/text.txt")
    [[ $last == none* ]] && echo "| $scene | $last | - |" && continue
    echo "| $scene | $last | $(ratios equal-time "$scene" | sed -n 's/^pssmlt|//p') |"
  done
}
sweep_table() {  # sweep_table NAME
  local method scene
  # shellcheck disable=SC2046
  printf '| method |%s\n' "$(printf ' %s |' $(scenes_of "$1"))"
  # shellcheck disable=SC2046
  printf '|---|%s\n' "$(printf -- '---|%.0s' $(scenes_of "$1"))"
  while read -r method; do
    printf '| `%s` |' "$method"
    for scene in $(scenes_of "$1"); do
      ratios "$1" "$scene" | awk -F'|' -v method="$method" '$1 == method { printf " %s |", $2 }'
    done
    printf '\n'
  done < <(methods_of "$1")
}
for table in "${tables[@]}"; do
  printf '## %s\n\n' "$table"
  if [ "$table" = equal-time ]; then equal_time_table; else sweep_table "$table"; fi
  printf '\n'
done >"$out/tables.md"
echo "$out/tables.md"
