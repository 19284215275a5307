#include "daemon/control/printer_metrics.hpp"

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

PrinterMetrics idle_printer() {
  return {.printer = "p",
          .state = "idle",
          .print = {},
          .light_may_be_on = false,
          .ready = true,
          .held = false,
          .plate_occupied = false,
          .queued = 0,
          .ended = {},
          .lit = {},
          .late_steps = 0};
}

bool has_line(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

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
  bool run_until(const std::function<bool()>& so) { return testing::run_loop_until(loop, so); }

  testing::TemporaryFolder folder;
  fs::path path = folder.path() / "metrics" / "contourd.prom";
  std::string text = "one\n";
  int looks = 0;
  EventLoop loop;
  testing::LogText log{loop};
  std::optional<MetricsFile> file;
};

}  // namespace

TEST_CASE("The metrics of a running print contain its layer, its light and its time") {
  PrinterMetrics metrics = idle_printer();
  metrics.state = "exposing";
  metrics.print = {7, 120, 90'700ms};
  metrics.light_may_be_on = true;
  metrics.queued = 3;
  metrics.ended = {{"done", 12}, {"failed", 1}};
  metrics.lit = 1234'500ms;
  metrics.late_steps = 9;
  const std::string text = as_open_metrics(metrics);
  CHECK(has_line(text, "contourd_state{state=\"exposing\"} 1"));
  CHECK(has_line(text, "contourd_state{state=\"idle\"} 0"));
  CHECK(has_line(text, "contourd_layer 7"));
  CHECK(has_line(text, "contourd_layers 120"));
  CHECK(has_line(text, "contourd_time_left_seconds 90"));
  CHECK(has_line(text, "contourd_light_may_be_on 1"));
  CHECK(has_line(text, "contourd_queued_jobs 3"));
  CHECK(has_line(text, "contourd_jobs_total{outcome=\"done\"} 12"));
  CHECK(has_line(text, "contourd_light_seconds_total 1234.5"));
  CHECK(has_line(text, "contourd_late_steps_total 9"));
  CHECK(text.ends_with("\n# EOF\n"));
}

TEST_CASE("Without a print there are no metrics of a print") {
  const std::string text = as_open_metrics(idle_printer());
  CHECK(text.find("contourd_layer") == std::string::npos);
  CHECK(text.find("time_left") == std::string::npos);
  CHECK(has_line(text, "contourd_state{state=\"idle\"} 1"));
}

TEST_CASE("Any printer's name is escaped, so that it ends neither a label nor a line") {
  PrinterMetrics metrics = idle_printer();
  metrics.printer = "a\"} 7\nb\\c\xff";
  const std::string text = as_open_metrics(metrics);
  CHECK(text.find("printer=\"a\\\"} 7?b\\\\c\xef\xbf\xbd\"} 1\n") != std::string::npos);
}

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
