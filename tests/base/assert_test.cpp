#include "base/assert.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "base/error.hpp"
#include "support/child_process.hpp"

namespace mlt {
namespace {

using test::ChildResult;
using test::run_in_child;

TEST_CASE("a check that holds does nothing") {
  const ChildResult child = run_in_child([] {
    MLT_CHECK(1 + 1 == 2);
    MLT_CHECK_OP(1, <, 2);
  });
  CHECK(child.exit_code == 0);
  CHECK(child.errors.empty());
}

TEST_CASE("a failing check prints expression, values, context and the replay command, and exits with 70") {
  const ChildResult child = run_in_child([] {
    set_replay_command("mlt render scene.txt --seed 9");
    ReplayContext& context = replay_context();
    context.stage = "chain";
    context.seed = 9;
    context.unit = 12;
    context.step = 345;
    const double sum = 2.5;
    MLT_CHECK_OP(sum, <=, 1);
  });
  CHECK(child.exit_code == static_cast<int>(ExitCode::kBug));
  CHECK_THAT(child.errors, Catch::Contains("sum <= 1") && Catch::Contains("2.5 against 1"));
  CHECK_THAT(child.errors, Catch::Contains("chain, seed 9, unit 12, step 345"));
  CHECK_THAT(child.errors, Catch::Contains("mlt render scene.txt --seed 9"));
  CHECK_THAT(child.errors, Catch::Contains("assert_test.cpp:"));
}

TEST_CASE("a failing check with a command longer than its buffer still exits with 70") {
  const ChildResult child = run_in_child([] {
    static const std::string command(10000, 'x');
    set_replay_command(command.c_str());
    MLT_CHECK(command.empty());
  });
  CHECK(child.exit_code == static_cast<int>(ExitCode::kBug));
  CHECK_THAT(child.errors, Catch::Contains("command.empty()"));
  CHECK(child.errors.size() <= 4096);
}

}  // namespace
}  // namespace mlt
