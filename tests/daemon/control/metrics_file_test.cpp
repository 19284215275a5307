#include "daemon/control/metrics_file.hpp"

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

class Desk {
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
  // To be called once: an event loop does not run again.
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

TEST_CASE("Figures are in the file when they have changed, and it is not touched when they have not") {
  Desk desk;
  fs::create_directory(desk.path.parent_path());
  desk.begin();
  int looks = 0;
  ino_t first = 0;
  CHECK(desk.run_until([&] {
    if (first == 0 && desk.content() == "one\n") {
      first = desk.inode();
      looks = desk.looks;
    }
    if (first != 0 && desk.text == "one\n" && desk.looks > looks + 20) {
      CHECK(desk.inode() == first);
      desk.text = "two\n";
    }
    return desk.content() == "two\n";
  }));
  CHECK((fs::status(desk.path).permissions() & fs::perms::others_read) != fs::perms::none);
  CHECK(std::distance(fs::directory_iterator(desk.path.parent_path()), {}) == 1);
}

TEST_CASE("The file goes with the printer, and only when it is the printer's") {
  Desk desk;
  fs::create_directory(desk.path.parent_path());
  desk.begin();
  CHECK(desk.run_until([&] { return desk.content() == "one\n"; }));
  desk.file.reset();
  CHECK_FALSE(fs::exists(desk.path));
}

TEST_CASE("A folder that is not there is told once, and the figures are written when it is") {
  Desk desk;
  desk.begin();
  int looks = 0;
  CHECK(desk.run_until([&] {
    if (looks == 0 && desk.log.has("cannot be written")) looks = desk.looks;
    if (looks != 0 && desk.looks > looks + 20) fs::create_directory(desk.path.parent_path());
    return desk.content() == "one\n" && desk.log.has("is written again");
  }));
  CHECK(desk.log.count("cannot be written") == 1);
  CHECK(desk.log.has("contourd.prom cannot be written, which is tried again: No such file or directory"));
}

TEST_CASE("What cannot be replaced by a file stays as it is, also at the end") {
  Desk desk;
  fs::create_directories(desk.path / "full");
  desk.begin();
  CHECK(desk.run_until([&] { return desk.log.has("cannot be written"); }));
  desk.file.reset();
  CHECK(fs::exists(desk.path / "full"));
}
