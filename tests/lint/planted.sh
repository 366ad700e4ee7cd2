#!/usr/bin/env bash
# Shows that the lint sees: a tree with one breach of every rule, in which each check of lint.sh must fail.
set -u
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../../tools/report.sh"
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
mkdir -p "$tree"/{include/{base,math,elsewhere,render},src/{base,math},tests/{base,repro},tools}
touch "$tree"/tools/none.sh "$tree"/tests/base/none.sh

cat >"$tree/Makefile" <<'TEXT'
STAGES   := base math
CONTRACT := -O3 -ffast-math
SET_FLAGS_avx2 := -mavx2 -mfma
TEXT
cat >"$tree/include/render/instruction_set.hpp" <<'TEXT'
#define MLT_INSTRUCTION_SETS(X) \
  X(avx2, "", MLT_CPU_HAS("avx2"))
TEXT
touch "$tree/tools/variants.mk"

# Words that the lint forbids are split here, since it reads this file too.
cat >"$tree/include/base/breach.hpp" <<TEXT
#include "math/other.hpp"
#include <glm/glm.hpp>
#include <unordered_map>
// T""ODO: cite [Nobody99] and look into /w""ork/main.
inline float f(glm::vec3 a) { return glm::dot(a, a) + std::sin(a.x); }
std::mt19937 g{std::random_device{}()};
auto now = std::chrono::system_clock::now();
std::unordered_map<int, int> table;
auto sum = std::reduce(begin, end);
TEXT
sed -i 's/""//g' "$tree/include/base/breach.hpp"
printf '// Own header.\n#pragma once\n' >"$tree/include/base/order.hpp"
printf '#include <cmath>\n#include "base/order.hpp"\n' >"$tree/src/base/order.cpp"
{
  echo "void long_one() {"
  for _ in $(seq 60); do echo "  step();"; done
  echo "}"
} >"$tree/src/math/long_function.cpp"
for _ in $(seq 401); do echo "int x;"; done >"$tree/src/math/long_file.cpp"
printf '// %0110d\n// \303\244\n' 0 >"$tree/src/math/wide.cpp"
echo "job hash" >"$tree/tests/repro/expected_hashes.txt"

LINT_ROOT=$tree bash "$here/lint.sh" >"$tree/output.txt" 2>&1
while IFS= read -r line; do
  case $line in
    "ok    "*) fail "the lint sees a breach of: ${line#ok    }" ;;
    "FAIL  "*) pass "the lint sees a breach of: ${line#FAIL  }" ;;
  esac
done <"$tree/output.txt"
expect_empty "the lint ran" \
  "$(grep -qE '^0 passed, [1-9][0-9]* failed$' "$tree/output.txt" || cat "$tree/output.txt")"
closing
