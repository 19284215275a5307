#include "daemon/spool/state_records.hpp"

#include <sys/stat.h>

#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

unsigned mode_of(const fs::path& path) {
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  return status.st_mode & 07777U;
}

}  // namespace

TEST_CASE("The state folder is the service manager's, or beside the spool without one") {
  ::unsetenv("STATE_DIRECTORY");
  CHECK(state_folder_path("/a/spool") == "/a/spool.state");
  CHECK(state_folder_path("/a/spool/") == "/a/spool.state");
  ::setenv("STATE_DIRECTORY", "/var/lib/contourd:/var/lib/other", 1);
  CHECK(state_folder_path("/a/spool") == "/var/lib/contourd");
  ::unsetenv("STATE_DIRECTORY");
}

TEST_CASE("Other users have no permissions for the state folder, even if it existed before") {
  const contourd::testing::TemporaryFolder folder;
  const fs::path state = folder.path() / "state";
  make_state_folder(state);
  CHECK(mode_of(state) == 0700);
  REQUIRE(::chmod(state.c_str(), 0777) == 0);
  make_state_folder(state);
  CHECK(mode_of(state) == 0700);
}

TEST_CASE("A state folder that is a link, a file or cannot be made is refused with its path") {
  const contourd::testing::TemporaryFolder folder;
  fs::create_directory(folder.path() / "real");
  fs::create_directory_symlink("real", folder.path() / "link");
  (void)folder.write("file", "");
  for (const fs::path& path :
       {folder.path() / "link", folder.path() / "file", folder.path() / "no" / "state"}) {
    CAPTURE(path);
    CHECK(testing::message_of<std::runtime_error>([&] {
            make_state_folder(path);
          }).starts_with("cannot use the state folder " + path.string() + ": "));
  }
}
