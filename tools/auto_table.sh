#!/usr/bin/env bash
# How well `--integrator auto` chooses (docs/RESULTS.md): on every scene and on the variations of
# auto_scenes.sh its efficiency, pilot included, against that of both integrators, at SIDE pixels on the
# longer side (256) and BUDGET samples or mutations a pixel (64), against the images of REFERENCES
# (ref_images/256), which have that size.
#   auto_table.sh MLT DIR [SIDE_BY_SIDE [CASE]...]
# About two hours of one core. Each case has a folder DIR/CASE; what is complete is not made again. Then
# DIR/table.md holds the table, as Markdown.
# The image of auto is that of the integrator it chooses, bit for bit. So both integrators are measured once,
# by `mlt converge`, and auto costs what the chosen one does and its pilot, which `mlt info` runs for each of
# many seeds.
set -eu
export LC_ALL=C
mlt=$(realpath "${1:?the program}")
out=$(realpath -m "${2:?folder for the results}")
side_by_side=${3:-1}
cases=("${@:4}")
cd "$(dirname "$0")/.."
side=${SIDE:-256}
budget=${BUDGET:-64}
references=${REFERENCES:-ref_images/256}
replicates=16
pilots=256

tools/auto_scenes.sh "$out/scenes"
mapfile -t scenes < <(grep -vE '^(#|$)' "$references/INDEX.txt" | cut -d' ' -f1)
mapfile -t variations < <(basename -s .txt "$out"/scenes/*.txt)
[ ${#cases[@]} -gt 0 ] || cases=("${scenes[@]}" "${variations[@]}")

# Of a variation; a reference says its own.
height_of() { case $1 in corridor*) echo $((side * 3 / 4)) ;; *) echo "$side" ;; esac; }

# A reference for a variation: by the integrator that its scene is easier for, with random numbers that no
# replicate has. Its own error, relMSE 0.001 to 0.02, is in the errors of all methods alike.
make_reference() {  # make_reference CASE SCENE
  local how=(--integrator pssmlt --mutations 512)
  case $1 in box_*) how=(--integrator path --spp 512) ;; esac
  "$mlt" render "$2" "${how[@]}" --width "$side" --height "$(height_of "$1")" --seed 7 --threads 1 --quiet \
    -o "$out/$1/reference.pfm"
}

# CASE: both integrators, then the choices of auto, one line a seed: what was chosen, the pilot's seconds, the
# work that it found PSSMLT to need relative to the path tracer.
run_case() {
  local folder=$out/$1 scene=$out/scenes/$1.txt reference=$references/$1.pfm seed height
  mkdir -p "$folder"
  if [ -e "$reference" ]; then
    scene=$(awk -v name="$1" '$1 == name { print $2 }' "$references/INDEX.txt")
    if [ ! -e "$scene" ]; then
      echo "$scene: missing; make scenes"
      return
    fi
  else
    reference=$folder/reference.pfm
    [ -e "$reference" ] || make_reference "$1" "$scene"
  fi
  [ -e "$folder/summary.json" ] ||
    "$mlt" converge "$scene" --reference "$reference" --threads 1 --quiet --integrators path,pssmlt \
      --budgets "$budget" --replicates $replicates -o "$folder" >"$folder/text.txt" \
      2>"$folder/warnings.txt" ||
    echo "$folder: exit code $?"
  [ -e "$folder/choices.txt" ] && return
  height=$(head -n 2 "$reference" | tail -n 1 | cut -d' ' -f2)
  for ((seed = 1; seed <= pilots; ++seed)); do
    "$mlt" info "$scene" --integrator auto --spp "$budget" --width "$side" --height "$height" --threads 1 \
      --seed $seed | awk '
        /^choice / { chosen = $2; for (i = 3; i < NF; ++i) if ($i == "needed") needed = $(i + 1) }
        /^pilot / { seconds = $(NF - 1) }
        END { sub(":", "", chosen); print chosen, seconds, needed }'
  done >"$folder/choices.part"
  mv "$folder/choices.part" "$folder/choices.txt"
}
for name in "${cases[@]}"; do
  while [ "$(jobs -rp | wc -l)" -ge "$side_by_side" ]; do wait -n; done
  run_case "$name" &
done
wait

# One row. The work of an integrator is its median relMSE times its median processor seconds: replicates of
# both take turns, so that what other programs add, they add to both, as to pilots; that of auto the mean over
# seeds of the chosen one's relMSE times the seconds of both it and the pilot. Efficiency is 1 / work. Below a
# relMSE of 1e-9 the path tracer's error is rounding, and only times are compared.
row() {
  awk -v name="$1" -v pilots=$pilots '
    function median(what, m,  n, i, j, t) {
      n = count[m]
      for (i = 2; i <= n; ++i)
        for (j = i; j > 1 && value[what, m, j] < value[what, m, j - 1]; --j) {
          t = value[what, m, j]; value[what, m, j] = value[what, m, j - 1]; value[what, m, j - 1] = t
        }
      return (value[what, m, int((n + 1) / 2)] + value[what, m, int(n / 2) + 1]) / 2
    }
    FILENAME ~ /csv$/ && FNR == 1 { split($0, names, ","); for (i in names) column[names[i]] = i; next }
    FILENAME ~ /csv$/ {
      split($0, field, ",")
      m = field[column["method"]]
      value["error", m, ++count[m]] = field[column["rel_mse"]] + 0
      value["time", m, count[m]] = field[column["cpu_seconds"]] + 0
      next
    }
    { ++choices[$1]; pilot += $2 / pilots }
    END {
      for (m in count) { e[m] = median("error", m); time[m] = median("time", m) }
      exact = e["path"] < 1e-9
      if (exact) { e["path"] = 1; e["pssmlt"] = 1e9 }
      seeds = choices["path"] + choices["pssmlt"]
      for (m in e) { work[m] = e[m] * time[m]; auto += choices[m] / seeds * e[m] * (time[m] + pilot) }
      best = work["path"] < work["pssmlt"] ? work["path"] : work["pssmlt"]
      ratio = exact ? "exact" : sprintf("%.3g", work["path"] / work["pssmlt"])
      printf "| %s | %s | %d of %d | %.2f s | %.2f |\n", name, ratio, choices["pssmlt"], seeds, pilot, \
        best / auto
    }' "$out/$1/converge.csv" "$out/$1/choices.txt"
}
{
  echo '| scene | pssmlt over path | auto chose pssmlt | pilot | auto over the better one |'
  echo '|---|---|---|---|---|'
  for name in "${cases[@]}"; do row "$name"; done
} >"$out/table.md"
echo "$out/table.md"
