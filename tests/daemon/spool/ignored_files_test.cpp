#include "daemon/spool/ignored_files.hpp"

#include <sys/stat.h>

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

struct ReportedFiles final : IgnoredFilesObserver {
  void ignored(const std::string& file, WhyIgnored /*why*/) override { files.push_back(file); }
  void more_ignored(std::size_t number) override { more += number; }

  std::vector<std::string> files;
  std::size_t more = 0;
};

class IgnoredFilesFixture {
 public:
  // Runs the loop for `duration`, then calls `then`.
  void run_for(
      Duration duration, const std::function<void()>& then = [] {}) {
    const auto end = loop.at(std::chrono::steady_clock::now() + duration, "the test", [this, then] {
      then();
      loop.stop();
    });
    loop.run();
  }

  EventLoop loop;
  ReportedFiles reported;
  IgnoredFiles ignored{loop, reported, 1s};
};

// kLong is longer than the second after which a file settles; a change comes after kHalf, half of that
// second.
constexpr Duration kLong = 1300ms, kHalf = 500ms;

}  // namespace

TEST_CASE("A file in incoming that will never be printed is ignored with the reason") {
  const testing::TemporaryFolder folder;
  const auto why = [&](const std::string& name) { return why_ignored(folder.write(name, "")); };
  CHECK(why("part.3mf") == WhyIgnored::Model);
  CHECK(why("part.OBJ") == WhyIgnored::Model);
  CHECK(why("part.gcode") == WhyIgnored::Sliced);
  CHECK(why("part.sl1") == WhyIgnored::Sliced);
  CHECK(why("part.ctb") == WhyIgnored::Sliced);
  CHECK(why("part.zip") == WhyIgnored::Archive);
  CHECK(why("part.stl.gz") == WhyIgnored::Archive);
  CHECK(why("notes.txt") == WhyIgnored::Other);
  CHECK(why("part stl") == WhyIgnored::Other);
  fs::create_symlink("part.zip", folder.path() / "link");
  CHECK(why_ignored(folder.path() / "link") == WhyIgnored::NotAFile);
  fs::create_symlink("nowhere", folder.path() / "dangling.json");
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

TEST_CASE("An ignored file is reported once after some seconds, unless it goes or changes in that time") {
  IgnoredFilesFixture fixture;
  fixture.ignored.saw("stays.3mf", WhyIgnored::Model);
  fixture.ignored.saw("goes.3mf", WhyIgnored::Model);
  fixture.ignored.saw("grows", WhyIgnored::Folder);
  CHECK(fixture.ignored.files().empty());
  const auto later = fixture.loop.at(std::chrono::steady_clock::now() + kHalf, "the test", [&] {
    fixture.ignored.forget("goes.3mf");
    fixture.ignored.saw("grows", WhyIgnored::Folder);
  });
  fixture.run_for(kLong, [&] { fixture.ignored.saw("stays.3mf", WhyIgnored::Model); });
  CHECK(fixture.reported.files == std::vector<std::string>{"stays.3mf"});
  CHECK(fixture.ignored.files() == std::map<std::string, WhyIgnored>{{"stays.3mf", WhyIgnored::Model}});
  fixture.ignored.forget_all_but({"grows"});
  CHECK(fixture.ignored.files().empty());
}

TEST_CASE("The first of many ignored files are reported by name, the rest by number, and all are listed") {
  IgnoredFilesFixture fixture;
  for (int i = 0; i < 2000; ++i)
    fixture.ignored.saw("part" + std::to_string(i) + ".3mf", WhyIgnored::Model);
  fixture.run_for(kLong);
  CHECK(fixture.reported.files.size() == 10);
  CHECK(fixture.reported.more == 1990);
  CHECK(fixture.ignored.files().size() == 2000);
}
