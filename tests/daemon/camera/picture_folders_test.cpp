#include "daemon/camera/picture_folders.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace contourd {
namespace {

class PictureFoldersFixture {
 public:
  PictureFoldersFixture() {
    for (const char* each : {"printing", "done", "failed"})
      fs::create_directory(folder.path() / each);
  }
  void write(const fs::path& file, const std::string& text = "x") const {
    std::ofstream(folder.path() / file) << text;
  }
  // Takes a picture of each of these layers of a job, which is under way.
  void take(const std::string& job, const std::vector<std::int32_t>& layers) const {
    folders.make(job);
    for (const std::int32_t layer : layers)
      write(picture_file(folders.current(job), layer), "picture");
  }
  [[nodiscard]] bool has(const fs::path& path) const { return fs::exists(folder.path() / path); }

  testing::TemporaryFolder folder;
  PictureFolders folders{folder.path()};
};

}  // namespace

TEST_CASE_METHOD(PictureFoldersFixture, "A job's pictures are found while it prints and beside its files") {
  CHECK(folders.find("part").empty());
  take("part", {4, 9});
  CHECK(folders.find("part") == folder.path() / "pictures" / "part");
  write("done/part.report.json");
  folders.tidy();
  CHECK(folders.find("part") == folder.path() / "done" / "part.pictures");
  CHECK_FALSE(has("pictures/part"));
  const StoredPictures stored = pictures_in(folders.find("part"));
  CHECK(stored.layers == std::vector<std::int32_t>{4, 9});
  CHECK(stored.bytes == 14);
}

TEST_CASE_METHOD(PictureFoldersFixture, "The pictures of a print under way stay") {
  take("part", {0});
  write("printing/part.stl");
  SECTION("a model") {}
  SECTION("one that a power cut has ended before") {
    write("failed/part.reason.txt");
  }
  folders.tidy();
  CHECK(has("pictures/part/00001.jpg"));
}

TEST_CASE_METHOD(PictureFoldersFixture, "The pictures of a job without a report go beside its reason") {
  take("part", {0});
  write("failed/part.reason.txt");
  folders.tidy();
  CHECK(has("failed/part.pictures/00001.jpg"));
  struct stat status {};
  REQUIRE(::stat((folder.path() / "failed/part.pictures").c_str(), &status) == 0);
  CHECK((status.st_mode & S_IWGRP) != 0);  // members of the group may delete them with the job
}

TEST_CASE_METHOD(PictureFoldersFixture, "The pictures of a job of which nothing is left are removed") {
  take("part", {0});
  folders.tidy();
  CHECK_FALSE(has("pictures/part"));
}

TEST_CASE_METHOD(PictureFoldersFixture,
                 "No pictures are moved into what another user has put in their place") {
  take("part", {0});
  write("done/part.report.json");
  fs::create_directory(folder.path() / "elsewhere");
  fs::create_directory_symlink(folder.path() / "elsewhere", folder.path() / "done/part.pictures");
  CHECK_THROWS_AS(folders.tidy(), std::system_error);
  CHECK(fs::is_empty(folder.path() / "elsewhere"));
  CHECK(has("pictures/part/00001.jpg"));
  // Nor is anything read there.
  fs::remove_all(folder.path() / "pictures");
  CHECK(folders.find("part").empty());
}

TEST_CASE_METHOD(PictureFoldersFixture, "A print of which no picture was taken has no folder of pictures") {
  take("part", {});
  write("done/part.report.json");
  folders.tidy();
  CHECK(folders.find("part").empty());
}

TEST_CASE_METHOD(PictureFoldersFixture, "Only files that are named by a layer are pictures") {
  folders.make("part");
  for (const char* each : {"00012.jpg", "12.jpg.new", "a.jpg", ".jpg", "-1.jpg", "00000.jpg",
                           "time-lapse.mp4", "99999999999.jpg", "5x.jpg"})
    write(folders.current("part") / each);
  CHECK(pictures_in(folders.current("part")).layers == std::vector<std::int32_t>{11});
  CHECK(picture_file("f", 11) == fs::path("f/00012.jpg"));
}

TEST_CASE_METHOD(PictureFoldersFixture, "Only contourd can change the pictures of a print under way") {
  const mode_t before = ::umask(0002);  // as in contourd.service
  folders.make("part");
  ::umask(before);
  struct stat status {};
  REQUIRE(::stat(folders.current("part").c_str(), &status) == 0);
  CHECK((status.st_mode & 0777U) == 0755);
}

}  // namespace contourd
