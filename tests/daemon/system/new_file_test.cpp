#include "daemon/system/new_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <filesystem>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/system/file_contents.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

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
