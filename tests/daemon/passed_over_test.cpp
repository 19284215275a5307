#include "daemon/passed_over.hpp"

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
  PassedOver passed_over{loop,
                         {.one = [this](const std::string& file, Oddity) { told.files.push_back(file); },
                          .more = [this](std::size_t files) { told.more += files; }},
                         1s};
};

// Longer than it takes to settle, which is a second; a change comes when half of that has passed.
constexpr Duration kLong = 1300ms, kHalf = 500ms;

}  // namespace

TEST_CASE("What lies in incoming is odd when it will never be printed") {
  const testing::TemporaryFolder folder;
  const auto oddity = [&](const std::string& name) { return oddity_of(folder.write(name, "")); };
  CHECK(oddity("part.3mf") == Oddity::Model);
  CHECK(oddity("part.OBJ") == Oddity::Model);
  CHECK(oddity("part.gcode") == Oddity::Sliced);
  CHECK(oddity("part.sl1") == Oddity::Sliced);
  CHECK(oddity("part.ctb") == Oddity::Sliced);
  CHECK(oddity("part.zip") == Oddity::Archive);
  CHECK(oddity("part.stl.gz") == Oddity::Archive);
  CHECK(oddity("notes.txt") == Oddity::Other);
  CHECK(oddity("part stl") == Oddity::Other);
  fs::create_symlink("part.zip", folder.path() / "link");
  CHECK(oddity_of(folder.path() / "link") == Oddity::NotAFile);
  fs::create_symlink("nowhere", folder.path() / "dangling.json");
  CHECK(oddity_of(folder.path() / "dangling.json") == Oddity::NotAFile);
  REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
  CHECK(oddity_of(folder.path() / "pipe") == Oddity::NotAFile);
}

TEST_CASE("A ticket, what is hidden, what is still being written and what has gone is not odd") {
  const testing::TemporaryFolder folder;
  for (const char* name : {"part.json", ".part.3mf", ".hidden", "part.stl.part", "part.3mf.crdownload",
                           "part.TMP", "part.stl.filepart", "part.stl~"})
    CHECK_FALSE(oddity_of(folder.write(name, "")));
  CHECK_FALSE(oddity_of(folder.path() / "gone.3mf"));
}

TEST_CASE("Every oddity has a sentence that says what is wanted") {
  for (const Oddity oddity :
       {Oddity::Folder, Oddity::Model, Oddity::Sliced, Oddity::Archive, Oddity::NotAFile, Oddity::Other})
    CHECK(sentence_for(oddity).size() > 30);
}

TEST_CASE("What lies there for some seconds is told once, and what has gone or changed in that time is not") {
  Bench bench;
  bench.passed_over.saw("stays.3mf", Oddity::Model);
  bench.passed_over.saw("goes.3mf", Oddity::Model);
  bench.passed_over.saw("grows", Oddity::Folder);
  CHECK(bench.passed_over.files().empty());
  const auto later = bench.loop.at(std::chrono::steady_clock::now() + kHalf, "the test", [&] {
    bench.passed_over.forget("goes.3mf");
    bench.passed_over.saw("grows", Oddity::Folder);
  });
  bench.run_for(kLong, [&] { bench.passed_over.saw("stays.3mf", Oddity::Model); });
  CHECK(bench.told.files == std::vector<std::string>{"stays.3mf"});
  CHECK(bench.passed_over.files() == std::map<std::string, Oddity>{{"stays.3mf", Oddity::Model}});
  bench.passed_over.forget_all_but({"grows"});
  CHECK(bench.passed_over.files().empty());
}

TEST_CASE("Of very many the first are named and the rest is counted, and all are known") {
  Bench bench;
  for (int i = 0; i < 2000; ++i)
    bench.passed_over.saw("part" + std::to_string(i) + ".3mf", Oddity::Model);
  bench.run_for(kLong);
  CHECK(bench.told.files.size() == 10);
  CHECK(bench.told.more == 1990);
  CHECK(bench.passed_over.files().size() == 2000);
}
