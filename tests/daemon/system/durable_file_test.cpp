#include "daemon/system/durable_file.hpp"

#include <sys/stat.h>

#include <system_error>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

using namespace contourd;
using contourd::testing::TemporaryFolder;

namespace {

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t entries(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

}  // namespace

TEST_CASE("A durable file replaces the old one and leaves nothing else behind") {
  const TemporaryFolder folder;
  write_durably(folder.path() / "a.txt", "one");
  write_durably(folder.path() / "a.txt", "two");
  CHECK(content(folder.path() / "a.txt") == "two");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("A durable file that cannot be written leaves the old one, and says which it is") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "a.txt" /
                                      "full");  // a folder cannot be replaced by a file
  try {
    write_durably(folder.path() / "a.txt", "two");
    FAIL("it should have thrown");
  } catch (const std::system_error& error) {
    CHECK(std::string(error.what()).find("a.txt") != std::string::npos);
  }
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("A durable file is written whatever lies under names like its own") {
  const TemporaryFolder folder;
  // Opened for writing, a FIFO waits for a reader.
  for (const char* name : {".a.txt.new", "a.txt.new", "a.txt"})
    REQUIRE(::mkfifo((folder.path() / name).c_str(), 0600) == 0);
  write_durably(folder.path() / "a.txt", "one");
  CHECK(content(folder.path() / "a.txt") == "one");
  CHECK(entries(folder.path()) == 3);
}
