#include "base/error.hpp"

#include <catch2/catch.hpp>

namespace mlt {
namespace {

TEST_CASE("a diagnostic prints its place and leaves out what is 0") {
  CHECK(Diagnostic{"scene.txt", 3, 14, "found x"}.to_string() == "scene.txt:3:14: found x");
  CHECK(Diagnostic{"scene.txt", 3, 0, "found x"}.to_string() == "scene.txt:3: found x");
  CHECK(Diagnostic{"--depth", 0, 0, "found x"}.to_string() == "--depth: found x");
  CHECK(Diagnostic{"scene.txt", 0, 14, "found x"}.to_string() == "scene.txt: found x");
}

TEST_CASE("an input error's text has one line for each diagnostic") {
  const InputError error({Diagnostic{"a", 1, 2, "first"}, Diagnostic{"b", 0, 0, "second"}});
  CHECK(std::string(error.what()) == "a:1:2: first\nb: second");
  CHECK(error.diagnostics().size() == 2);
}

TEST_CASE("suggest names the nearest allowed words") {
  const std::vector<std::string> allowed{"diffuse", "mirror", "dielectric", "conductor"};
  CHECK(suggest("difuse", allowed) == ", did you mean 'diffuse'?");
  CHECK(suggest("miror", allowed) == ", did you mean 'mirror'?");
  CHECK(suggest("mirror", allowed) == ", did you mean 'mirror'?");
}

TEST_CASE("suggest is silent when nothing is near") {
  CHECK(suggest("xyzzy", {"diffuse", "mirror"}).empty());
  CHECK(suggest("anything", {}).empty());
  CHECK(suggest("", {"diffuse"}).empty());
  CHECK(suggest(std::string(100000, 'm'), {"mirror"}).empty());
}

TEST_CASE("suggest orders by distance, then by name, and stops at three") {
  // Distances from "cat": cat 0, bat 1, car 1, cart 1, coat 1.
  CHECK(suggest("cat", {"coat", "cart", "car", "cat", "bat"}) == ", did you mean 'cat' or 'bat' or 'car'?");
}

TEST_CASE("the exit codes are the documented ones") {
  CHECK(static_cast<int>(ExitCode::kOk) == 0);
  CHECK(static_cast<int>(ExitCode::kCompareFailed) == 1);
  CHECK(static_cast<int>(ExitCode::kBadInput) == 2);
  CHECK(static_cast<int>(ExitCode::kResourceLimit) == 3);
  CHECK(static_cast<int>(ExitCode::kBug) == 70);
  CHECK(static_cast<int>(ExitCode::kInterrupted) == 75);
}

}  // namespace
}  // namespace mlt
