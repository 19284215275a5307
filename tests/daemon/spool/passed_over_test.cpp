#include "daemon/spool/passed_over.hpp"

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
  PassedOver passed_over{
      loop,
      {.one = [this](const std::string& file, WhyPassedOver) { told.files.push_back(file); },
       .more = [this](std::size_t files) { told.more += files; }},
      1s};
};

// Longer than it takes to settle, which is a second; a change comes when half of that has passed.
constexpr Duration kLong = 1300ms, kHalf = 500ms;

}  // namespace

TEST_CASE("What lies in incoming is odd when it will never be printed") {
  const testing::TemporaryFolder folder;
  const auto why = [&](const std::string& name) { return why_passed_over(folder.write(name, "")); };
  CHECK(why("part.3mf") == WhyPassedOver::Model);
  CHECK(why("part.OBJ") == WhyPassedOver::Model);
  CHECK(why("part.gcode") == WhyPassedOver::Sliced);
  CHECK(why("part.sl1") == WhyPassedOver::Sliced);
  CHECK(why("part.ctb") == WhyPassedOver::Sliced);
  CHECK(why("part.zip") == WhyPassedOver::Archive);
  CHECK(why("part.stl.gz") == WhyPassedOver::Archive);
  CHECK(why("notes.txt") == WhyPassedOver::Other);
  CHECK(why("part stl") == WhyPassedOver::Other);
  fs::create_symlink("part.zip", folder.path() / "link");
  CHECK(why_passed_over(folder.path() / "link") == WhyPassedOver::NotAFile);
  fs::create_symlink("nowhere", folder.path() / "dangling.json");
  CHECK(why_passed_over(folder.path() / "dangling.json") == WhyPassedOver::NotAFile);
  REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
  CHECK(why_passed_over(folder.path() / "pipe") == WhyPassedOver::NotAFile);
}

TEST_CASE("A ticket, what is hidden, what is still being written and what has gone is not odd") {
  const testing::TemporaryFolder folder;
  for (const char* name : {"part.json", ".part.3mf", ".hidden", "part.stl.part", "part.3mf.crdownload",
                           "part.TMP", "part.stl.filepart", "part.stl~"})
    CHECK_FALSE(why_passed_over(folder.write(name, "")));
  CHECK_FALSE(why_passed_over(folder.path() / "gone.3mf"));
}

TEST_CASE("Every why has a sentence that says what is wanted") {
  for (const WhyPassedOver why : {WhyPassedOver::Folder, WhyPassedOver::Model, WhyPassedOver::Sliced,
                                  WhyPassedOver::Archive, WhyPassedOver::NotAFile, WhyPassedOver::Other})
    CHECK(sentence_for(why).size() > 30);
}

TEST_CASE("What lies there for some seconds is told once, and what has gone or changed in that time is not") {
  Bench bench;
  bench.passed_over.saw("stays.3mf", WhyPassedOver::Model);
  bench.passed_over.saw("goes.3mf", WhyPassedOver::Model);
  bench.passed_over.saw("grows", WhyPassedOver::Folder);
  CHECK(bench.passed_over.files().empty());
  const auto later = bench.loop.at(std::chrono::steady_clock::now() + kHalf, "the test", [&] {
    bench.passed_over.forget("goes.3mf");
    bench.passed_over.saw("grows", WhyPassedOver::Folder);
  });
  bench.run_for(kLong, [&] { bench.passed_over.saw("stays.3mf", WhyPassedOver::Model); });
  CHECK(bench.told.files == std::vector<std::string>{"stays.3mf"});
  CHECK(bench.passed_over.files() ==
        std::map<std::string, WhyPassedOver>{{"stays.3mf", WhyPassedOver::Model}});
  bench.passed_over.forget_all_but({"grows"});
  CHECK(bench.passed_over.files().empty());
}

TEST_CASE("Of very many the first are named and the rest is counted, and all are known") {
  Bench bench;
  for (int i = 0; i < 2000; ++i)
    bench.passed_over.saw("part" + std::to_string(i) + ".3mf", WhyPassedOver::Model);
  bench.run_for(kLong);
  CHECK(bench.told.files.size() == 10);
  CHECK(bench.told.more == 1990);
  CHECK(bench.passed_over.files().size() == 2000);
}
