#include "daemon/system/regular_file.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

// Returns the error's text; empty if the file could be opened.
std::string complaint(const fs::path& path, Links links) {
  try {
    return open_regular_file(path, links).valid() ? "" : "no descriptor";
  } catch (const UnreadableFile& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("A regular file is opened, also through a link if links are followed") {
  const contourd::testing::TemporaryFolder folder;
  const fs::path file = folder.write("a", "text");
  fs::create_symlink("a", folder.path() / "link");
  CHECK(complaint(file, Links::Follow).empty());
  CHECK(complaint(file, Links::Refuse).empty());
  CHECK(complaint(folder.path() / "link", Links::Follow).empty());
  CHECK(complaint(folder.path() / "link", Links::Refuse) == "it is a symbolic link, not a file");
}

TEST_CASE("A file in a linked folder is refused if links are refused") {
  const contourd::testing::TemporaryFolder folder;
  (void)folder.write("real/a", "text");
  fs::create_directory_symlink("real", folder.path() / "link");
  CHECK(complaint(folder.path() / "link" / "a", Links::Follow).empty());
  CHECK(complaint(folder.path() / "link" / "a", Links::Refuse) == "it cannot be read: Not a directory");
}

TEST_CASE("Anything but a regular file is refused without blocking") {
  const contourd::testing::TemporaryFolder folder;
  REQUIRE(::mkfifo((folder.path() / "fifo").c_str(), 0600) == 0);
  const FileDescriptor socket(::socket(AF_UNIX, SOCK_STREAM, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, (folder.path() / "socket").c_str());
  REQUIRE(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  for (const Links links : {Links::Follow, Links::Refuse}) {
    CHECK(complaint(folder.path() / "fifo", links) == "it is not a regular file");
    CHECK(complaint(folder.path() / "socket", links) == "it is not a regular file");
    CHECK(complaint("/dev/null", links) == "it is not a regular file");
    CHECK(complaint(folder.path(), links) == "it is a folder, not a file");
    CHECK(complaint(folder.path() / "none", links) == "there is no such file");
    CHECK(complaint(folder.path() / "none" / "a", links) == "there is no such file");
  }
}
