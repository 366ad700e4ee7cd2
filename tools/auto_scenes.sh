#!/usr/bin/env bash
# Writes twenty variations of the scenes, in light size, gap width and depth, into a folder:
#   auto_scenes.sh DIR
# They are what --integrator auto is judged on besides the scenes themselves (tools/auto_table.sh). A lamp
# that is scaled keeps its power.
set -eu
export LC_ALL=C
out=${1:?folder for the scenes}
cd "$(dirname "$0")/.."
mkdir -p "$out"

# vary NAME BASE PROGRAM: scenes/BASE.txt through sed; a program that changes nothing is a mistake.
vary() {
  sed -E "$3" "scenes/$2.txt" >"$out/$1.txt"
  ! cmp -s "scenes/$2.txt" "$out/$1.txt" || { echo "$1: the variation changes nothing" >&2; exit 1; }
}

# lamp NAME BASE SCALE: the emitting quad, which lies in a plane of constant height, scaled about its centre.
lamp() {
  awk -v s="$3" '
    function scaled(x, c) { return c + s * (x - c) }
    $1 == "quad" && /emit/ {
      cx = ($2 + $8) / 2; cz = ($4 + $10) / 2
      printf "quad"
      for (i = 2; i <= 13; i += 3) printf " %.9g %s %.9g", scaled($i, cx), $(i + 1), scaled($(i + 2), cz)
      printf " material white emit %.9g %.9g %.9g\n", $17 / s / s, $18 / s / s, $19 / s / s
      found = 1
      next
    }
    { print }
    END { exit !found }' "scenes/$2.txt" >"$out/$1.txt"
}

lamp box_lamp_0.05 CornellBox 0.05
lamp box_lamp_0.3 CornellBox 0.3
lamp box_lamp_3 CornellBox 3
vary box_depth_3 CornellBox 's/^depth .*/depth 3/'
vary box_depth_24 CornellBox 's/^depth .*/depth 24/'

for gap in 10 20 80 160; do  # mm; 40 in the scene
  vary "hidden_gap_$gap" cornell_hidden \
    "s/^box 262 -10 350  562.8 558.8 410/box 262 -10 $((310 + gap))  562.8 558.8 $((370 + gap))/"
done
vary hidden_depth_6 cornell_hidden 's/^depth .*/depth 6/'
lamp hidden_lamp_0.3 cornell_hidden 0.3

lamp box2_lamp_0.3 CornellBox2 0.3
vary box2_lamp_high CornellBox2 '/emit/s/ 110 / 240 /g'
vary box2_depth_5 CornellBox2 's/^depth .*/depth 5/'

lamp corridor_lamp_0.3 corridor 0.3
vary corridor_depth_10 corridor 's/^depth .*/depth 10/'
for edge in 4 7; do  # where the second stretch begins, 6 in the scene: it ends at 8
  vary "corridor_gap_$((8 - edge))" corridor "/^quad/s/\b([27]) (0|2\.5) 6\b/\1 \2 $edge/g"
done

lamp spheres_lamp_0.4 spheres 0.4
lamp spheres_lamp_3 spheres 3
