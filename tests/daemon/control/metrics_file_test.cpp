#include "daemon/control/metrics_file.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

class MetricsFileFixture {
 public:
  void begin() {
    file.emplace(
        loop, log.log, path,
        [this] {
          ++looks;
          return text;
        },
        1ms);
  }
  [[nodiscard]] std::string content() const {
    std::ifstream stream(path);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  [[nodiscard]] ino_t inode() const {
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
  }
  // May be called only once, because an event loop cannot run again.
  bool run_until(const std::function<bool()>& so) {
    bool reached = false;
    const auto given_up =
        loop.at(std::chrono::steady_clock::now() + 20s, "the test", [this] { loop.stop(); });
    const auto looks_at_it = loop.when_idle("the test", [&] {
      reached = so();
      if (reached) loop.stop();
      return !reached;
    });
    loop.run();
    return reached;
  }

  testing::TemporaryFolder folder;
  fs::path path = folder.path() / "metrics" / "contourd.prom";
  std::string text = "one\n";
  int looks = 0;
  EventLoop loop;
  testing::LogText log{loop};
  std::optional<MetricsFile> file;
};

}  // namespace

TEST_CASE("The file is written only when the metrics have changed") {
  MetricsFileFixture fixture;
  fs::create_directory(fixture.path.parent_path());
  fixture.begin();
  int looks = 0;
  ino_t first = 0;
  CHECK(fixture.run_until([&] {
    if (first == 0 && fixture.content() == "one\n") {
      first = fixture.inode();
      looks = fixture.looks;
    }
    if (first != 0 && fixture.text == "one\n" && fixture.looks > looks + 20) {
      CHECK(fixture.inode() == first);
      fixture.text = "two\n";
    }
    return fixture.content() == "two\n";
  }));
  CHECK((fs::status(fixture.path).permissions() & fs::perms::others_read) != fs::perms::none);
  CHECK(std::distance(fs::directory_iterator(fixture.path.parent_path()), {}) == 1);
}

TEST_CASE("The file is removed when the printer stops") {
  MetricsFileFixture fixture;
  fs::create_directory(fixture.path.parent_path());
  fixture.begin();
  CHECK(fixture.run_until([&] { return fixture.content() == "one\n"; }));
  fixture.file.reset();
  CHECK_FALSE(fs::exists(fixture.path));
}

TEST_CASE("A missing folder is reported once, and the metrics are written when it exists") {
  MetricsFileFixture fixture;
  fixture.begin();
  int looks = 0;
  CHECK(fixture.run_until([&] {
    if (looks == 0 && fixture.log.has("cannot be written")) looks = fixture.looks;
    if (looks != 0 && fixture.looks > looks + 20) fs::create_directory(fixture.path.parent_path());
    return fixture.content() == "one\n" && fixture.log.has("is written again");
  }));
  CHECK(fixture.log.count("cannot be written") == 1);
  CHECK(fixture.log.has("contourd.prom cannot be written and is tried again: No such file or directory"));
}

TEST_CASE("A folder in the file's place is left as it is, even at the end") {
  MetricsFileFixture fixture;
  fs::create_directories(fixture.path / "full");
  fixture.begin();
  CHECK(fixture.run_until([&] { return fixture.log.has("cannot be written"); }));
  fixture.file.reset();
  CHECK(fs::exists(fixture.path / "full"));
}
