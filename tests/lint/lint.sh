#!/usr/bin/env bash
# The house rules as a test: stage order, forbidden calls, sizes, and the names that other documents promise.
# Reads sources only. Each check lists the offending places; tools/report.sh counts them. LINT_ROOT names
# another tree to check; tests/lint/planted.sh has one in which every check must fail.
set -u
export LC_ALL=C
top=$(cd "$(dirname "$0")/../.." && pwd)
. "$top/tools/report.sh"
. "$top/tools/instruction_sets.sh"
cd "${LINT_ROOT:-$top}" || exit 1

# Numerical pitfalls of primary-sample Metropolis renderers that the project's code can have. Each has tests
# with "pitfall N" in their names, and a row in docs/STABILITY.md that lists exactly the files these stand in.
pitfalls=({1..22})

# As in the Makefile, which states the order once.
read -ra stages < <(sed -n 's/^STAGES *:= *//p' Makefile)

mapfile -t core < <(find include src -name '*.hpp' -o -name '*.cpp' | sort)
mapfile -t tests < <(find tests -name '*.hpp' -o -name '*.cpp' | sort)
sources=("${core[@]}" "${tests[@]}" $(find scenes -name '*.cpp'))
mapfile -t everything < <(find . -path ./build -prune -o -path ./.git -prune -o -type f \
  ! -name '*.png' ! -name '*.pfm' -print | grep -v '^./tests/fuzz/corpus/' | sort)

# code FILE...: "file:line:text" without comments, for checks of what is called.
code() { awk '{ sub(/\/\/.*/, ""); if ($0 ~ /[^ ]/) print FILENAME ":" FNR ":" $0 }' "$@"; }
core_code=$(code "${core[@]}")
forbid() { expect_empty "$1" "$(grep -E "$2" <<<"$core_code")"; }

# ---- stages ----

stage_order() {
  awk -v list="${stages[*]}" '
    BEGIN { n = split(list, name, " "); for (i = 1; i <= n; ++i) rank[name[i]] = i }
    FNR == 1 { split(FILENAME, part, "/"); own = rank[part[2]] }
    /^#include "/ {
      split($2, path, /["\/]/)
      if (path[2] == "support" || path[3] == "") next
      if (!(path[2] in rank)) { print FILENAME ":" FNR ": not a stage: " $2; next }
      if (own && rank[path[2]] > own) print FILENAME ":" FNR ": a later stage: " $2
    }' "$@"
}
expect_empty "a stage includes only itself and earlier ones" "$(stage_order "${sources[@]}")"

folders=$(find include src -mindepth 1 -maxdepth 1 -type d -printf '%f\n' | sort -u |
  grep -vxF -f <(printf '%s\n' "${stages[@]}"))
expect_empty "every folder of include and src is a stage" "$folders"

# ---- the floating-point contract and determinism ----

elementary='a?sin|a?cos|a?tan|atan2|sincos|sinh|cosh|tanh|exp2?|expm1|log|log2|log10|log1p|pow|cbrt'
forbid "no libm beyond its exact functions" \
  "(^|[^A-Za-z0-9_.>])(std::|::)?($elementary|hypot|fma|erfc?|[lt]gamma)[fl]?\("
forbid "no random distribution, device or shuffle of the library" \
  'std::[a-z_]+_distribution|std::(shuffle|sample|random_device)|[^a-z_]s?rand\('
forbid "no clock that depends on the date" \
  'system_clock|high_resolution_clock|gettimeofday|[^a-z_]time\((NULL|nullptr|0)\)'
forbid "no container without order" 'unordered_'
forbid "vector operations come from math/vec.hpp" \
  'glm::(dot|cross|normalize|length2?|distance|reflect|refract|inverse|rotate|lookAt|perspective|mix|fma)\b'
forbid "no parallel or relaxed algorithm" 'std::(execution|reduce|transform_reduce)\b'
bit_changing='-Ofast|-ffast-math|-funsafe|-march=native|-ffp-contract=(fast|on)'
expect_empty "no flag that changes the bits" "$(grep -nE -e "$bit_changing" Makefile tools/variants.mk)"

# A set whose condition lacks a flag that it is compiled with would crash on some processor.
set_breaches() {
  local set flags
  for set in $(instruction_sets); do
    flags=$(sed -n "s/^SET_FLAGS_$set *:= *//p" Makefile | tr ' ' '\n' | sed -n 's/^-m//p' | sort)
    [ "$flags" = "$(needs_of "$set" | sort)" ] ||
      echo "$set: the Makefile compiles with ${flags//$'\n'/ }, render/instruction_set.hpp asks for" \
        "$(needs_of "$set" | sort | paste -sd ' ')"
  done
  [ -n "$set" ] || echo "render/instruction_set.hpp lists no instruction set"
}
expect_empty "instruction sets ask the processor for what they are compiled with" "$(set_breaches)"

# ---- sizes and form ----

expect_empty "no file over 400 lines" \
  "$(wc -l "${sources[@]}" | awk '$2 != "total" && $1 > 400 { print $2 ": " $1 " lines" }')"
expect_empty "no line over 110 characters" \
  "$(awk 'length($0) > 110 { print FILENAME ":" FNR ": " length($0) }' "${sources[@]}" tools/*.sh \
    tests/*/*.sh)"

# A function ends at a brace in the column in which its first line began; Google style indents no namespace.
long_functions() {
  awk '
    FNR == 1 { start[0] = start[2] = 0 }
    { match($0, /^ */); indent = RLENGTH }
    /^ *(\/\/|#|$)/ || /^ *(public|private|protected):/ { next }
    indent != 0 && indent != 2 { next }
    /^ *\}$/ {
      size = FNR - start[indent] + 1
      if (start[indent] && size > 60) print FILENAME ":" start[indent] ": " size " lines"
      start[indent] = 0
      next
    }
    /^ *\}/ { start[indent] = 0; next }
    !start[indent] || /^ *[A-Za-z_].*[;{]$/ || /^ *(template|TEST_CASE)/ { start[indent] = FNR }
    /;$/ { start[indent] = 0 }' "$@"
}
expect_empty "no function over 60 lines" "$(long_functions "${core[@]}" "${tests[@]}")"
expect_empty "every header begins with a comment and is included once" "$(
  for file in "${core[@]}" "${tests[@]}"; do
    [[ $file == *.hpp ]] || continue
    head -n 1 "$file" | grep -q '^// ' || echo "$file: no comment on top"
    grep -q '^#pragma once' "$file" || echo "$file: no #pragma once"
  done)"
expect_empty "a source file includes its own header first" "$(
  for file in "${core[@]}"; do
    [[ $file == src/*.cpp ]] || continue
    header=${file#src/} header=${header%.cpp}.hpp
    [ -e "include/$header" ] || continue
    first=$(grep -m 1 '^#include' "$file")
    [ "$first" = "#include \"$header\"" ] || echo "$file: $first"
  done)"
expect_empty "sources are plain ASCII" "$(grep -nP '[^\x00-\x7F]' "${sources[@]}")"
expect_empty "nothing left to do later" "$(grep -nwE 'T[O]DO|F[I]XME|X[X]X|H[A]CK' "${everything[@]}")"
machine='(^|[^A-Za-z0-9_.])/(w[o]rk|f[a]rm)(/|\b)|(^|[^A-Za-z0-9_])s[h]ared/|/home/[a-z]'
expect_empty "no path of the machine it was written on" "$(grep -nE "$machine" "${everything[@]}")"

# ---- what other documents promise ----

# "N file" for each number in the names of the tests of a file, "pitfalls 3 and 14" counting for both. A name
# may be wrapped over two lines.
tested_pitfalls() {
  awk '/TEST_CASE\(/ { on = 2 } on-- > 0 { print FILENAME " " $0 }' "${tests[@]}" |
    sed -nE 's/^tests\/([^ ]*)\.cpp .*pitfalls? ([0-9]+((,| and) *[0-9]+)*).*/\1 \2/p' |
    awk '{ for (i = 2; i <= NF; ++i) if ($i + 0) print $i + 0, $1 }' | sort -u
}
# "N file" for each row `| N | what | file, file |` of the table.
listed_pitfalls() {
  awk -F' *[|] *' '$2 ~ /^[0-9]+$/ {
      n = split($4, file, ", *")
      for (i = 1; i <= n; ++i) print $2, file[i]
    }' docs/STABILITY.md 2>/dev/null | sort -u
}
pitfall_breaches() {
  local number
  for number in "${pitfalls[@]}"; do
    grep -q "^$number " <<<"$(tested_pitfalls)" || echo "no test is named \"pitfall $number\""
  done
  comm -23 <(tested_pitfalls) <(listed_pitfalls) | sed 's/^/docs\/STABILITY.md does not list for pitfall /'
  comm -13 <(tested_pitfalls) <(listed_pitfalls) | sed 's/^/docs\/STABILITY.md has, but no test, pitfall /'
}
expect_empty "every pitfall has tests of its name, which docs/STABILITY.md lists" "$(pitfall_breaches)"

cited=$(grep -ohE '\[[A-Z][A-Za-z]+[0-9]{2}[a-z]?[] ,;]' "${core[@]}" | tr -d '[] ,;' | sort -u)
expect_empty "every cited work is in docs/REFERENCES.md" "$(
  for key in $cited; do grep -q "^- \[$key\]" docs/REFERENCES.md 2>/dev/null || echo "[$key]"; done)"

wrong=
for golden in tests/repro/expected_hashes.txt ref_images/hashes.txt; do
  [ -e "$golden" ] || continue
  digest=$(sha256sum "$golden" | cut -c1-16)
  grep -q "golden: $digest" CHANGELOG.md 2>/dev/null ||
    wrong+="$golden changed: CHANGELOG.md needs a line with 'golden: $digest' and the reason"$'\n'
done
expect_empty "CHANGELOG.md names the film hashes in force" "$wrong"

closing
