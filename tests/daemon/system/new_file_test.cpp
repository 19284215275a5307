#include "daemon/system/new_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using contourd::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

}  // namespace

TEST_CASE("A new file takes no other's name, and may try another") {
  const TemporaryFolder folder;
  (void)folder.write("part.stl", "old");
  NewFile file(folder.path());
  file.write("n");
  file.write("ew");
  CHECK_FALSE(file.appear("part.stl"));
  CHECK(file.appear("part-2.stl"));
  CHECK(content(folder.path() / "part.stl") == "old");
  CHECK(content(folder.path() / "part-2.stl") == "new");
  CHECK(entries(folder.path()) == 2);
}

TEST_CASE("Nobody sees a new file being written") {
  const TemporaryFolder folder;
  NewFile file(folder.path());
  file.write("a model");
  REQUIRE(file.appear("part.stl"));
  // A lease is given only while nobody has the file open for writing; `file` is still there.
  const FileDescriptor seen(::open((folder.path() / "part.stl").c_str(), O_RDONLY | O_CLOEXEC));
  CHECK(::fcntl(seen.get(), F_SETLEASE, F_RDLCK) == 0);
}

TEST_CASE("A new file that is given up leaves nothing behind") {
  const TemporaryFolder folder;
  {
    NewFile file(folder.path());
    file.write("a model");
  }
  CHECK(entries(folder.path()) == 0);
  CHECK_THROWS_AS(NewFile(folder.path() / "none"), std::system_error);
}

TEST_CASE("The group may read a new file whatever the umask says") {
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

TEST_CASE("What was not given its name yet is removed, and nothing else is") {
  const TemporaryFolder folder;
  for (const char* name : {".contourd-0123456789abcdef.new", ".contourd-x", "a.new", ".a.new", "a.txt"})
    (void)folder.write(name, "");
  remove_unfinished_files(folder.path());
  CHECK(entries(folder.path()) == 4);
  CHECK_FALSE(std::filesystem::exists(folder.path() / ".contourd-0123456789abcdef.new"));
  remove_unfinished_files(folder.path() / "none");
}
