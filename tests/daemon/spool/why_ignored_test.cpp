#include "daemon/spool/why_ignored.hpp"

#include <sys/stat.h>

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

TEST_CASE("A file in incoming that will never be printed is ignored with the reason") {
  const testing::TemporaryFolder folder;
  const auto why = [&](const std::string& name) { return why_ignored(folder.write(name, "")); };
  CHECK(why("part.step") == WhyIgnored::Model);
  CHECK(why("part.PLY") == WhyIgnored::Model);
  CHECK(why("part.gcode") == WhyIgnored::Sliced);
  CHECK(why("part.ctb") == WhyIgnored::Sliced);
  CHECK(why("part.7z") == WhyIgnored::Archive);
  CHECK(why("part.tar.gz") == WhyIgnored::Archive);
  CHECK(why("notes.txt") == WhyIgnored::Other);
  CHECK(why("part stl") == WhyIgnored::Other);
  std::filesystem::create_symlink("part.zip", folder.path() / "link");
  CHECK(why_ignored(folder.path() / "link") == WhyIgnored::NotAFile);
  std::filesystem::create_symlink("nowhere", folder.path() / "dangling.json");
  CHECK(why_ignored(folder.path() / "dangling.json") == WhyIgnored::NotAFile);
  REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
  CHECK(why_ignored(folder.path() / "pipe") == WhyIgnored::NotAFile);
}

TEST_CASE("Tickets, hidden files, unfinished uploads and missing files are not reported as ignored") {
  const testing::TemporaryFolder folder;
  for (const char* name : {"part.json", ".part.3mf", ".hidden", "part.stl.part", "part.3mf.crdownload",
                           "part.TMP", "part.stl.filepart", "part.stl~"})
    CHECK_FALSE(why_ignored(folder.write(name, "")));
  CHECK_FALSE(why_ignored(folder.path() / "gone.3mf"));
}

TEST_CASE("Every reason to ignore a file has a sentence for the user") {
  for (const WhyIgnored why : {WhyIgnored::Folder, WhyIgnored::Model, WhyIgnored::Sliced, WhyIgnored::Archive,
                               WhyIgnored::NotAFile, WhyIgnored::Other})
    CHECK(sentence_for(why).size() > 30);
}
