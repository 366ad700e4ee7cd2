#!/usr/bin/env bash
# Shows by instruction counts (callgrind) that a scene pays nothing for what it lacks:
#   feature_cost.sh build/<variant> FEATURE...
#   without  a job needs at most 0.5 % more instructions a sample or mutation than in a build that has never
#            heard of the feature (include/integrator/features.hpp), and makes the same film
#   always   the same job in a build in which every scene has the feature is seen to need more than that
#            (less with roulette, which then ends paths)
#   unused   materials, lights and meshes that a scene file mentions and does not use change less than that
# Counts are differences of two lengths of a job, so that start-up is none of them, by one thread and the
# baseline's kernels.
set -u
export LC_ALL=C
cd "$(dirname "$0")/.."
. tools/report.sh
out=${1:?folder of the variant}
shift
work=$out/feature_cost
rm -rf "$work"
mkdir -p "$work"
parallel=${JOBS:-$(nproc)}
limit=0.5
side=24
short=8
long=16

# NAME SCENE OPTION...; between them they lack every feature, with few and with many others.
jobs_of() {
  case $1 in
    box) echo "scenes/CornellBox.txt depth=5 roulette=0" ;;
    box-roulette) echo "scenes/CornellBox.txt depth=8 roulette=2" ;;
    mirror) echo "scenes/mirror.txt depth=4 roulette=0" ;;
    shapes) echo "scenes/furnace_shapes.txt depth=6 roulette=3" ;;
    spheres) echo "scenes/spheres.txt depth=8 roulette=0" ;;
    spheres-roulette) echo "scenes/spheres.txt depth=8 roulette=3" ;;
    *) echo "$work/$1.txt depth=5 roulette=0" ;;
  esac
}
# Jobs that lack a feature, the first being one in which it shows when it is forced.
lacking() {
  case $1 in
    general_geometry) echo box mirror ;;
    general_materials) echo box shapes ;;
    lobe_choice) echo mirror ;;
    many_lights) echo box spheres-roulette ;;
    roulette) echo box spheres ;;
  esac
}
first_lacking() { lacking "$1" | cut -d' ' -f1; }
options_of() {
  [ "$1" = path ] && echo "integrator=path" || echo "integrator=pssmlt bootstrap=1024 chains=4"
}

# count BINARY BUILD JOB INTEGRATOR SPP: instructions and the film's hash, into a file.
count() {
  local file=$work/$2.$3.$4.$5
  # shellcheck disable=SC2046
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$1" $(jobs_of "$3") $(options_of "$4") \
    width=$side height=$side "spp=$5" threads=1 isa=base >"$file.log" 2>&1
  awk '/Collected/ { count = $NF } length($0) == 64 { hash = $0 } END { print count, hash }' "$file.log" \
    >"$file.count"
}
# queue BINARY BUILD JOB: counts both integrators and lengths, as many at a time as there are cores.
queue() {
  local integrator spp
  for integrator in path pssmlt; do
    for spp in $short $long; do
      [ -e "$work/$2.$3.$integrator.$spp.log" ] && continue
      : >"$work/$2.$3.$integrator.$spp.log"
      while [ "$(jobs -rp | wc -l)" -ge "$parallel" ]; do wait -n; done
      count "$1" "$2" "$3" "$integrator" "$spp" &
    done
  done
}
# cost BUILD JOB INTEGRATOR: instructions a sample or mutation; nothing when a run failed.
cost() {
  awk -v pixels=$((side * side)) -v samples=$((long - short)) '{ count[NR] = $1 }
    END { if (0 < count[1] && count[1] < count[2]) printf "%.1f", (count[2] - count[1]) / samples / pixels
    }' \
    "$work/$1.$2.$3.$short.count" "$work/$1.$2.$3.$long.count"
}
hash_of() { cut -d' ' -f2 "$work/$1.$2.$3.$long.count"; }
change() { awk -v a="$1" -v b="$2" 'BEGIN { if (a > 0 && b > 0) printf "%+.2f", 100 * (a / b - 1) }'; }
# above CHANGE LIMIT: also when there is no figure.
above() { [ -z "$1" ] || awk -v c="$1" -v limit="$2" 'BEGIN { exit !(c > limit) }'; }
# failed BUILD JOB INTEGRATOR: what its runs said.
failed() { grep -hvE '^==|^$|^[0-9a-f]{64}$' "$work/$1.$2.$3".*.log | head -n 4; }

# ---- scenes that mention what they do not use ----

cp scenes/CornellBox.txt "$work/plain.txt"
mention() { cp scenes/CornellBox.txt "$work/unused-$1.txt" && cat >>"$work/unused-$1.txt"; }
mention materials <<'TEXT'
material unused_diffuse diffuse reflectance 0.5
material unused_mirror mirror reflectance 0.9
material unused_glass dielectric ior 1.5
material unused_gold conductor preset gold roughness 0.2
TEXT
# What has no area gives no light.
mention lights <<'TEXT'
define unused_lamp emit 17 12 4
sphere 278 273 280 0  material white $unused_lamp
triangle 278 273 280  278 273 280  278 273 280  material white $unused_lamp
quad 278 273 280  278 273 280  278 273 280  278 273 280  material white $unused_lamp
TEXT
printf 'v 278 273 280\nv 279 273 280\nv 280 273 280\nf 1 2 3\n' >"$work/line.obj"
printf '%s\n' ply 'format ascii 1.0' 'element vertex 3' 'property float x' 'property float y' \
  'property float z' 'element face 1' 'property list uchar int vertex_indices' end_header \
  '278 273 280' '279 273 280' '280 273 280' '3 0 1 2' >"$work/line.ply"
mention meshes <<'TEXT'
mesh line.obj  material white
mesh line.ply  material white
inline_mesh  material white
vertex 278 273 280
vertex 279 273 280
vertex 280 273 280
face 0 1 2
end
TEXT

# ---- runs ----

for feature in "$@"; do
  for job in $(lacking "$feature"); do
    queue "$out/film_hash" full "$job"
    queue "$out/without_$feature/film_hash" "without_$feature" "$job"
  done
  queue "$out/always_$feature/film_hash" "always_$feature" "$(first_lacking "$feature")"
done
queue "$out/film_hash" full plain
for kind in materials lights meshes; do queue "$out/film_hash" full "unused-$kind"; done
wait

# ---- results ----

kernels() { nm -C "$1" | grep -c 'mlt::run_chain_turn<'; }
for feature in "$@"; do
  [ -n "$(lacking "$feature")" ] || fail "without $feature: no job in tools/feature_cost.sh lacks it"
  all=$(kernels "$out/always_$feature/film_hash")
  left=$(kernels "$out/without_$feature/film_hash")
  expect_empty "without $feature: $left kernels of $all are left" \
    "$([ "$left" -gt 0 ] && [ "$left" -lt "$all" ] || echo "the build has heard of it")"
  for job in $(lacking "$feature"); do
    for integrator in path pssmlt; do
      full=$(cost full "$job" $integrator)
      without=$(cost "without_$feature" "$job" $integrator)
      bare=$(hash_of "without_$feature" "$job" $integrator)
      more=$(change "$full" "$without")
      wrong=
      if above "$more" "$limit"; then
        wrong="allowed is $limit %; $(failed "without_$feature" "$job" $integrator)"
      elif [ "$(hash_of full "$job" $integrator)" != "$bare" ]; then
        wrong="another film"
      fi
      expect_empty \
        "without $feature: $job, $integrator: $full instructions, $without when unheard of, $more %" "$wrong"
    done
  done
done
for feature in "$@"; do
  job=$(first_lacking "$feature")
  for integrator in path pssmlt; do
    full=$(cost full "$job" $integrator)
    more=$(change "$(cost "always_$feature" "$job" $integrator)" "$full")
    expect_empty "always $feature: $job, $integrator: would be $more %, which is seen" \
      "$([ -n "$more" ] && above "${more#-}" "$limit" || echo "not told from noise")"
  done
done
for kind in materials lights meshes; do
  for integrator in path pssmlt; do
    more=$(change "$(cost full "unused-$kind" $integrator)" "$(cost full plain $integrator)")
    expect_empty "unused $kind: $integrator: $more %" \
      "$(above "${more#-}" "$limit" && echo "allowed is $limit %" && failed full "unused-$kind" $integrator)"
  done
done
closing
