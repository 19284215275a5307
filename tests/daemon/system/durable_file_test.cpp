#include "daemon/system/durable_file.hpp"

#include <sys/stat.h>

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/system/file_contents.hpp"
#include "tests/temporary_folder.hpp"

TEST_CASE("A durable file replaces the old one and leaves no other file") {
  const TemporaryFolder folder;
  write_durably(folder.path() / "a.txt", "one");
  write_durably(folder.path() / "a.txt", "two");
  CHECK(contents_of(folder.path() / "a.txt") == "two");
  CHECK(entry_count(folder.path()) == 1);
}

TEST_CASE("A failure to write a durable file leaves the old one and names it") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "a.txt" /
                                      "full");  // a folder cannot be replaced by a file
  try {
    write_durably(folder.path() / "a.txt", "two");
    FAIL("it should have thrown");
  } catch (const std::system_error& error) {
    CHECK(std::string(error.what()).find("a.txt") != std::string::npos);
  }
  CHECK(entry_count(folder.path()) == 1);
}

TEST_CASE("A durable file is written even if FIFOs have its name and similar ones") {
  const TemporaryFolder folder;
  // Opened for writing, a FIFO waits for a reader.
  for (const char* name : {".a.txt.new", "a.txt.new", "a.txt"})
    REQUIRE(::mkfifo((folder.path() / name).c_str(), 0600) == 0);
  write_durably(folder.path() / "a.txt", "one");
  CHECK(contents_of(folder.path() / "a.txt") == "one");
  CHECK(entry_count(folder.path()) == 3);
}
