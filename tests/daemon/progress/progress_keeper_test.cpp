#include "daemon/progress/progress_keeper.hpp"

#include <filesystem>
#include <future>
#include <set>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

PrintProgress in_layer(std::int32_t layer, PrintPhase phase, Duration light = {}) {
  return {phase, layer, Nanometers{layer * 50'000}, Nanometers{50'000}, 2s, light, false, {}};
}

class KeeperFixture {
 public:
  // Begins the record of a print of 20 layers.
  void begin() {
    keeper.begin({.job = "part", .layers = 20, .print = in_layer(0, PrintPhase::Starting)}, [] {
      return JobMarks{"mark", 7};
    });
  }
  [[nodiscard]] std::optional<JobProgress> recorded() const { return ProgressRecord(file).read().progress; }
  bool recorded_in(std::int32_t layer, PrintPhase phase) {
    return testing::run_loop_until(loop, [&] {
      const std::optional<JobProgress> found = recorded();
      return found && found->print.layer == layer && found->print.phase == phase;
    });
  }

  testing::TemporaryFolder folder;
  std::filesystem::path file = folder.path() / "print-progress";
  EventLoop loop;
  testing::LogText log{loop};
  bool lit = false;
  ProgressKeeper keeper{loop, log.log, file, [this] { return lit; }};
};

}  // namespace

TEST_CASE(
    "The latest phase of a print reaches the disk, with the mark of its files and the light before it") {
  KeeperFixture fixture;
  fixture.begin();
  fixture.keeper.keep(in_layer(0, PrintPhase::Lit, 2s));
  fixture.keeper.keep(in_layer(0, PrintPhase::Lifting, 2s));
  fixture.keeper.keep(in_layer(1, PrintPhase::Lowering));
  fixture.keeper.keep(in_layer(1, PrintPhase::Lit, 3s));
  fixture.keeper.keep(in_layer(2, PrintPhase::Lowering));
  REQUIRE(fixture.recorded_in(2, PrintPhase::Lowering));
  const JobProgress progress = *fixture.recorded();
  CHECK((progress.job == "part" && progress.marks == JobMarks{"mark", 7}));
  CHECK(progress.lit == 5s);
  CHECK_FALSE(fixture.log.has("the disk is slower than the print"));
}

TEST_CASE("A disk that does not answer for a second is reported once, and the print goes on meanwhile") {
  std::promise<void> answer;
  KeeperFixture fixture;
  fixture.keeper.begin({.job = "part", .layers = 20, .print = in_layer(0, PrintPhase::Starting)},
                       [answers = answer.get_future().share()] {
                         answers.wait();
                         return JobMarks{};
                       });
  CHECK(testing::run_loop_until(fixture.loop, [&] {
    fixture.keeper.keep(in_layer(3, PrintPhase::Lit));
    return fixture.log.has("the disk is slower than the print");
  }));
  fixture.keeper.keep(in_layer(3, PrintPhase::Lifting));
  CHECK(fixture.log.count("the disk is slower than the print") == 1);
  answer.set_value();
}

TEST_CASE("No progress is written while the light may be on, and the next phase in the dark is") {
  KeeperFixture fixture;
  fixture.begin();
  fixture.lit = true;
  fixture.keeper.keep(in_layer(0, PrintPhase::BeforeLight));
  std::set<PrintPhase> seen;
  int turns = 0;
  CHECK(testing::run_loop_until(fixture.loop, [&] {
    const std::optional<JobProgress> found = fixture.recorded();
    if (!found) return false;
    seen.insert(found->print.phase);
    constexpr int kLitTurns = 100;  // after the begin is on the disk
    if (++turns == kLitTurns) {
      fixture.lit = false;
      fixture.keeper.keep(in_layer(0, PrintPhase::Lit, 2s));
    }
    return found->print.phase == PrintPhase::Lit;
  }));
  CHECK(seen == std::set<PrintPhase>{PrintPhase::Starting, PrintPhase::Lit});
}

TEST_CASE("The record goes with the end of the print, and nothing is written without a print") {
  KeeperFixture fixture;
  fixture.keeper.keep(in_layer(1, PrintPhase::Lit));
  fixture.begin();
  bool ended = false;
  CHECK(testing::run_loop_until(fixture.loop, [&] {
    if (ended) return !std::filesystem::exists(fixture.file);
    if (!fixture.recorded()) return false;
    fixture.keeper.end();
    fixture.keeper.keep(in_layer(1, PrintPhase::Lit));
    ended = true;
    return false;
  }));
  // The marks of a next print are asked for on the keeper's thread, after all that was to be written before.
  std::promise<bool> left;
  fixture.keeper.begin({.job = "next", .layers = 20, .print = in_layer(0, PrintPhase::Starting)}, [&] {
    left.set_value(std::filesystem::exists(fixture.file));
    return JobMarks{};
  });
  CHECK_FALSE(left.get_future().get());
}

TEST_CASE("A print goes on if its progress cannot be recorded, which is reported once") {
  KeeperFixture fixture;
  std::filesystem::create_directories(fixture.file / "full");
  fixture.begin();
  CHECK(testing::run_loop_until(fixture.loop, [&] {
    fixture.keeper.keep(in_layer(1, PrintPhase::Lit));
    return fixture.log.has("the progress of the print cannot be recorded");
  }));
  CHECK(fixture.log.count("cannot be recorded") == 1);
}

TEST_CASE("The end of a pause waits until the record no longer trusts the height of the pause") {
  KeeperFixture fixture;
  fixture.begin();
  int left = 0;
  const auto leave = [&] { fixture.keeper.leave_pause([&](bool recorded) { left += recorded ? 1 : 0; }); };
  leave();
  CHECK(left == 1);
  PrintProgress paused = in_layer(2, PrintPhase::Paused);
  paused.plate = PrintProgress::Heights{Nanometers{30'000'000}, Nanometers{30'000'000}};
  fixture.keeper.keep(paused);
  bool asked = false;
  CHECK(testing::run_loop_until(fixture.loop, [&] {
    if (!asked && is_at_rest(fixture.recorded().value_or(JobProgress{}).print)) {
      asked = true;
      leave();
      CHECK(left == 1);
    }
    return left == 2;
  }));
  CHECK(fixture.recorded()->print.plate ==
        PrintProgress::Heights{Nanometers{100'000}, Nanometers{30'000'000}});
}

TEST_CASE("A disk that refuses the record does not keep a print paused") {
  KeeperFixture fixture;
  fixture.file = fixture.folder.path() / "missing" / "print-progress";
  ProgressKeeper keeper(fixture.loop, fixture.log.log, fixture.file, [] { return false; });
  keeper.begin({.job = "part", .layers = 20, .print = in_layer(0, PrintPhase::Paused)},
               [] { return JobMarks{}; });
  bool left = false;
  keeper.leave_pause([&](bool recorded) { left = recorded; });
  CHECK(testing::run_loop_until(fixture.loop, [&] { return left; }));
}
