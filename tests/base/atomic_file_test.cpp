#include "base/atomic_file.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "base/error.hpp"
#include "support/temporary_folder.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

void write_file(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  REQUIRE(file.write(text.data(), text.size()));
  file.commit();
}

TEST_CASE("an atomic file appears whole on commit and replaces what was there") {
  const TemporaryFolder folder;
  const std::string path = folder / "out.bin";
  write_file(path, std::string("a\0b", 3));
  CHECK(read_text(path) == std::string("a\0b", 3));
  {
    AtomicFile file(path);
    REQUIRE(file.write("second", 6));
    CHECK(read_text(path) == std::string("a\0b", 3));
    file.commit();
  }
  CHECK(read_text(path) == "second");
  CHECK(folder.file_count() == 1);
}

TEST_CASE("an atomic file that is not committed leaves nothing and changes nothing") {
  const TemporaryFolder folder;
  write_file(folder / "old", "old");
  {
    AtomicFile replaced(folder / "old");
    AtomicFile fresh(folder / "fresh");
    CHECK(replaced.write("new", 3));
    CHECK(fresh.write("new", 3));
  }
  CHECK(read_text(folder / "old") == "old");
  CHECK(folder.file_count() == 1);
}

TEST_CASE("replacing a file keeps its permissions, and a new one gets the user's default") {
  const TemporaryFolder folder;
  const std::string path = folder / "out";
  write_file(path, "1");
  const mode_t mask = ::umask(0);
  ::umask(mask);
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == (0666 & ~mask));
  REQUIRE(::chmod(path.c_str(), 0640) == 0);
  write_file(path, "2");
  REQUIRE(::stat(path.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0640);
}

TEST_CASE("a symbolic link stays and what it points to is replaced") {
  const TemporaryFolder folder;
  write_file(folder / "target", "old");
  fs::create_symlink(folder / "target", folder / "link");
  write_file(folder / "link", "new");
  CHECK(read_text(folder / "target") == "new");
  CHECK(fs::is_symlink(folder / "link"));
}

TEST_CASE("output paths that cannot be written are bad input and are named") {
  const TemporaryFolder folder;
  write_file(folder / "plain", "x");
  fs::create_directory(folder / "sub");
  struct Row {
    std::string path, fragment;
  };
  const Row rows[] = {
      {folder / "missing/out.png", "No such file or directory"},
      {folder / "plain/out.png", "not a folder"},
      {folder / "sub", "is a folder"},
      {folder / "sub/", "does not name a file"},
      {"", "does not name a file"},
      {folder / std::string(300, 'n'), "File name too long"},
      {"/proc/mlt_test_output", "cannot be written"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.path);
    CHECK_THROWS_AS(require_writable(row.path), InputError);
    CHECK_THROWS_WITH(require_writable(row.path), Catch::Contains(row.path) && Catch::Contains(row.fragment));
  }
  CHECK_THROWS_AS(AtomicFile(folder / "missing/out.png"), InputError);
  CHECK(folder.file_count() == 2);
}

TEST_CASE("a path that can be written passes the check and is not created by it") {
  const TemporaryFolder folder;
  require_writable(folder / "out.png");
  CHECK(folder.file_count() == 0);
  require_writable("/dev/null");
}

/// Runs `body` in a child process and returns its exit code; root's rights and limits are the child's own.
template <class Body>
int exit_code_of(Body body) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) ::_exit(body());
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

TEST_CASE("a folder or file without write permission is bad input") {
  const TemporaryFolder folder;
  write_file(folder / "kept", "x");
  REQUIRE(::chmod((folder / "kept").c_str(), 0444) == 0);
  REQUIRE(::chmod(folder.path().c_str(), 0555) == 0);
  const auto is_refused = [](const std::string& path) {
    return exit_code_of([&path] {
      // Root writes anywhere; "nobody" does not.
      if (::geteuid() == 0 && ::seteuid(65534) != 0) return 99;
      try {
        require_writable(path);
      } catch (const InputError& error) {
        return std::string(error.what()).find("Permission denied") != std::string::npos ? 2 : 98;
      }
      return 0;
    });
  };
  CHECK(is_refused(folder / "fresh") == 2);
  REQUIRE(::chmod(folder.path().c_str(), 0777) == 0);
  CHECK(is_refused(folder / "fresh") == 0);
  CHECK(is_refused(folder / "kept") == 2);
}

TEST_CASE("a full disk is a resource limit, names the file and leaves nothing") {
  const TemporaryFolder folder;
  write_file(folder / "old", "old");
  SECTION("a device that is always full, reached through a link") {
    fs::create_symlink("/dev/full", folder / "full");
    AtomicFile file(folder / "full");
    CHECK_FALSE(file.write("data", 4));
    CHECK_FALSE(file.write("more", 4));
    CHECK_THROWS_AS(file.commit(), ResourceError);
    CHECK(fs::is_symlink(folder / "full"));
    CHECK(fs::is_character_file("/dev/full"));
  }
  SECTION("a limit that allows a part of the bytes, which gives a short write first") {
    const int code = exit_code_of([&folder] {
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{1000, 1000};
      if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 99;
      try {
        AtomicFile file(folder / "old");
        const std::string text(3000, 'x');
        if (file.write(text.data(), text.size())) return 98;
        file.commit();
      } catch (const ResourceError& error) {
        return std::string(error.what()).find(folder / "old") == 0 ? 3 : 97;
      }
      return 0;
    });
    CHECK(code == 3);
    CHECK(read_text(folder / "old") == "old");
    CHECK(folder.file_count() == 1);
  }
}

TEST_CASE("is_same_file sees through links, and compares names of files that do not exist yet") {
  const TemporaryFolder folder;
  write_file(folder / "a", "x");
  fs::create_symlink(folder / "a", folder / "link");
  CHECK(is_same_file(folder / "a", folder / "link"));
  CHECK(is_same_file(folder / "new", folder / "./new"));
  CHECK_FALSE(is_same_file(folder / "a", folder / "new"));
  CHECK_FALSE(is_same_file(folder / "new", folder / "other"));
}

}  // namespace
}  // namespace mlt
