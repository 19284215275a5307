#include "daemon/spool/ignored_files.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

// What is told in the time that it takes.
struct Told {
  std::vector<std::string> files;
  std::size_t more = 0;
};

class Bench {
 public:
  // Runs until `end`.
  void run_for(
      Duration duration, const std::function<void()>& then = [] {}) {
    const auto end = loop.at(std::chrono::steady_clock::now() + duration, "the test", [this, then] {
      then();
      loop.stop();
    });
    loop.run();
  }

  EventLoop loop;
  Told told;
  IgnoredFiles ignored{loop,
                       {.one = [this](const std::string& file, WhyIgnored) { told.files.push_back(file); },
                        .more = [this](std::size_t files) { told.more += files; }},
                       1s};
};

// Longer than it takes to settle, which is a second; a change comes when half of that has passed.
constexpr Duration kLong = 1300ms, kHalf = 500ms;

}  // namespace

TEST_CASE("What lies in incoming is odd when it will never be printed") {
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

TEST_CASE("A ticket, what is hidden, what is still being written and what has gone is not odd") {
  const testing::TemporaryFolder folder;
  for (const char* name : {"part.json", ".part.3mf", ".hidden", "part.stl.part", "part.3mf.crdownload",
                           "part.TMP", "part.stl.filepart", "part.stl~"})
    CHECK_FALSE(why_ignored(folder.write(name, "")));
  CHECK_FALSE(why_ignored(folder.path() / "gone.3mf"));
}

TEST_CASE("Every why has a sentence that says what is wanted") {
  for (const WhyIgnored why : {WhyIgnored::Folder, WhyIgnored::Model, WhyIgnored::Sliced, WhyIgnored::Archive,
                               WhyIgnored::NotAFile, WhyIgnored::Other})
    CHECK(sentence_for(why).size() > 30);
}

TEST_CASE("What lies there for some seconds is told once, and what has gone or changed in that time is not") {
  Bench bench;
  bench.ignored.saw("stays.3mf", WhyIgnored::Model);
  bench.ignored.saw("goes.3mf", WhyIgnored::Model);
  bench.ignored.saw("grows", WhyIgnored::Folder);
  CHECK(bench.ignored.files().empty());
  const auto later = bench.loop.at(std::chrono::steady_clock::now() + kHalf, "the test", [&] {
    bench.ignored.forget("goes.3mf");
    bench.ignored.saw("grows", WhyIgnored::Folder);
  });
  bench.run_for(kLong, [&] { bench.ignored.saw("stays.3mf", WhyIgnored::Model); });
  CHECK(bench.told.files == std::vector<std::string>{"stays.3mf"});
  CHECK(bench.ignored.files() == std::map<std::string, WhyIgnored>{{"stays.3mf", WhyIgnored::Model}});
  bench.ignored.forget_all_but({"grows"});
  CHECK(bench.ignored.files().empty());
}

TEST_CASE("Of very many the first are named and the rest is counted, and all are known") {
  Bench bench;
  for (int i = 0; i < 2000; ++i)
    bench.ignored.saw("part" + std::to_string(i) + ".3mf", WhyIgnored::Model);
  bench.run_for(kLong);
  CHECK(bench.told.files.size() == 10);
  CHECK(bench.told.more == 1990);
  CHECK(bench.ignored.files().size() == 2000);
}
