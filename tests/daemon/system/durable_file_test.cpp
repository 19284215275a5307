#include "daemon/system/durable_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <filesystem>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/system/file_contents.hpp"
#include "tests/message_of.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using contourd::testing::contents_of;
using contourd::testing::entry_count;
using contourd::testing::TemporaryFolder;
namespace fs = std::filesystem;

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
  CHECK(testing::message_of<std::system_error>([&] {
          write_durably(folder.path() / "a.txt", "two");
        }).find("a.txt") != std::string::npos);
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

TEST_CASE("A new file does not take an existing file's name and can try another name") {
  const TemporaryFolder folder;
  (void)folder.write("part.stl", "old");
  NewFile file(folder.path());
  file.write("n");
  file.write("ew");
  CHECK_FALSE(file.appear("part.stl"));
  CHECK(file.appear("part-2.stl"));
  CHECK(contents_of(folder.path() / "part.stl") == "old");
  CHECK(contents_of(folder.path() / "part-2.stl") == "new");
  CHECK(entry_count(folder.path()) == 2);
}

TEST_CASE("A new file is not open for writing once its name exists") {
  const TemporaryFolder folder;
  NewFile file(folder.path());
  file.write("a model");
  REQUIRE(file.appear("part.stl"));
  // A read lease is granted only if no process has the file open for writing; `file` still exists.
  const FileDescriptor seen(::open((folder.path() / "part.stl").c_str(), O_RDONLY | O_CLOEXEC));
  CHECK(::fcntl(seen.get(), F_SETLEASE, F_RDLCK) == 0);
}

TEST_CASE("A discarded new file leaves nothing in the folder") {
  const TemporaryFolder folder;
  {
    NewFile file(folder.path());
    file.write("a model");
  }
  CHECK(entry_count(folder.path()) == 0);
  CHECK_THROWS_AS(NewFile(folder.path() / "none"), std::system_error);
}

TEST_CASE("The group may read a new file regardless of the umask") {
  const TemporaryFolder folder;
  const mode_t before = ::umask(0077);
  NewFile file(folder.path());
  (void)::umask(before);
  file.let_group_read();
  REQUIRE(file.appear("part.stl"));
  struct stat status {};
  REQUIRE(::stat((folder.path() / "part.stl").c_str(), &status) == 0);
  CHECK((status.st_mode & 0777U) == 0640);
}

TEST_CASE("Only temporary files without their final name are removed") {
  const TemporaryFolder folder;
  for (const char* name : {".contourd-0123456789abcdef.new", ".contourd-x", "a.new", ".a.new", "a.txt"})
    (void)folder.write(name, "");
  remove_unfinished_files(folder.path());
  CHECK(entry_count(folder.path()) == 4);
  CHECK_FALSE(std::filesystem::exists(folder.path() / ".contourd-0123456789abcdef.new"));
  remove_unfinished_files(folder.path() / "none");
}
