#!/usr/bin/env bash
# How well `--integrator auto` chooses (docs/RESULTS.md): on every scene and on the variations of
# auto_scenes.sh its efficiency, pilot included, against that of both integrators, at 256 pixels on the
# longer side.
#   auto_table.sh MLT DIR [SIDE_BY_SIDE [CASE]...]
# About an hour and a half of one core. Each case has a folder DIR/CASE; those that are complete are not made
# again. Then DIR/table.md holds the table, as Markdown.
set -eu
export LC_ALL=C
mlt=$(realpath "${1:?the program}")
out=$(realpath -m "${2:?folder for the results}")
side_by_side=${3:-1}
cases=("${@:4}")
cd "$(dirname "$0")/.."
budget=64
replicates=4

tools/auto_scenes.sh "$out/scenes"
mapfile -t scenes < <(grep -vE '^(#|$)' ref_images/256/INDEX.txt | cut -d' ' -f1)
mapfile -t variations < <(basename -s .txt "$out"/scenes/*.txt)
[ ${#cases[@]} -gt 0 ] || cases=("${scenes[@]}" "${variations[@]}")

# A reference for a variation: by the integrator that its scene is easier for, with random numbers that no
# replicate has. Its own error, relMSE 0.001 to 0.02, is in the errors of all methods alike.
make_reference() {  # make_reference CASE SCENE
  local how=(--integrator pssmlt --mutations 512) height=256
  case $1 in box_*) how=(--integrator path --spp 512) ;; esac
  case $1 in corridor*) height=192 ;; esac
  "$mlt" render "$2" "${how[@]}" --width 256 --height $height --seed 7 --threads 1 --quiet \
    -o "$out/$1/reference.pfm"
}

run_case() {
  local folder=$out/$1 scene=$out/scenes/$1.txt reference
  [ -e "$folder/summary.json" ] && return
  mkdir -p "$folder"
  reference=ref_images/256/$1.pfm
  if [ -e "$reference" ]; then
    scene=$(awk -v name="$1" '$1 == name { print $2 }' ref_images/256/INDEX.txt)
  else
    reference=$folder/reference.pfm
    [ -e "$reference" ] || make_reference "$1" "$scene"
  fi
  "$mlt" converge "$scene" --reference "$reference" --threads 1 --quiet --integrators path,pssmlt,auto \
    --budgets $budget --replicates $replicates -o "$folder" >"$folder/text.txt" 2>"$folder/warnings.txt" ||
    echo "$folder: exit code $?"
}
for name in "${cases[@]}"; do
  while [ "$(jobs -rp | wc -l)" -ge "$side_by_side" ]; do wait -n; done
  run_case "$name" &
done
wait

# One row from converge.csv: efficiencies are 1 / (median relMSE times median processor seconds), relative to
# the better integrator's. What was chosen shows in the film's hash. Below a relMSE of 1e-9 the path tracer's
# error is rounding, and only times are compared.
row() {
  awk -F, -v name="$1" '
    function median(key, n,  i, j, t) {
      for (i = 2; i <= n; ++i)
        for (j = i; j > 1 && value[key, j] < value[key, j - 1]; --j) {
          t = value[key, j]; value[key, j] = value[key, j - 1]; value[key, j - 1] = t
        }
      return n % 2 ? value[key, (n + 1) / 2] : (value[key, n / 2] + value[key, n / 2 + 1]) / 2
    }
    NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    {
      m = $column["method"]; n = ++count[m]
      value["e" m, n] = $column["rel_mse"]; value["t" m, n] = $column["cpu_seconds"]
      hash[m, $column["seed"]] = $column["film_hash"]
    }
    END {
      for (key in hash) {
        split(key, part, SUBSEP)
        if (part[1] == "auto" && hash[key] == hash["pssmlt", part[2]]) ++chosen
      }
      for (m in count) { e[m] = median("e" m, count[m]); t[m] = median("t" m, count[m]) }
      exact = e["path"] < 1e-9
      if (exact) for (m in count) e[m] = m == "pssmlt" ? 1e9 : 1
      for (m in count) work[m] = e[m] * t[m]
      best = work["path"] < work["pssmlt"] ? work["path"] : work["pssmlt"]
      ratio = exact ? "0" : sprintf("%.3g", work["path"] / work["pssmlt"])
      printf "| %s | %s | %d of %d | %.2f |\n", name, ratio, chosen, count["auto"], best / work["auto"]
    }' "$out/$1/converge.csv"
}
{
  echo '| scene | efficiency of pssmlt over path | auto chose pssmlt | auto over the better one |'
  echo '|---|---|---|---|'
  for name in "${cases[@]}"; do row "$name"; done
} >"$out/table.md"
echo "$out/table.md"
