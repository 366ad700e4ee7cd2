#!/usr/bin/env bash
# The estimated relMSE against the true one, from the references of ref_images, by scene and integrator:
#   calibration.sh MLT [SEEDS]
# Prints a table of means over the seeds. A ratio of 1 is right; docs/ESTIMATOR.md discusses it.
set -eu
export LC_ALL=C
cd "$(dirname "$0")/.."
mlt=${1:?the program}
seeds=${2:-3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# One value of a flat JSON file.
value() { sed -n "s/^ *\"$2\": \([^,]*\),\{0,1\}$/\1/p" "$1"; }

printf '%-20s %-8s %12s %12s %8s\n' scene method estimated true ratio
for job in "path 64" "pssmlt 256"; do
  read -r method budget <<<"$job"
  while read -r name file _; do
    estimates=0 truths=0
    for seed in $(seq 101 $((100 + seeds))); do
      "$mlt" render "$file" --integrator "$method" --spp "$budget" --width 64 --height 64 --seed "$seed" \
        --quiet --output "$work/image.pfm" --stats "$work/statistics.json" 2>/dev/null
      estimate=$(value "$work/statistics.json" rel_mse_estimate)
      truth=$("$mlt" compare "$work/image.pfm" "ref_images/$name.pfm" |
        awk 'tolower($1) == "relmse" { print $2 }')
      estimates="$estimates $estimate" truths="$truths $truth"
    done
    awk -v name="$name" -v method="$method" -v e="$estimates" -v t="$truths" 'BEGIN {
      n = split(e, es, " "); split(t, ts, " ")
      for (i = 1; i <= n; ++i) { es_sum += es[i]; ts_sum += ts[i] }
      ratio = ts_sum > 0 ? sprintf("%8.3f", es_sum / ts_sum) : "       -"
      printf "%-20s %-8s %12.4g %12.4g %s\n", name, method, es_sum / (n - 1), ts_sum / (n - 1), ratio
    }'
  done < <(grep -vE '^(#|$)' ref_images/INDEX.txt)
done
