#include "daemon/report/range_times.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/report/print_state.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

constexpr Nanometers kLayer{100'000};

// Returns the report of a print of four layers, each done 10 s after the one before, after a warm-up of 3 s.
// Its plan has two layers, a rest of 2 s, and a rise of two.
PrintReport report_of_rise() {
  PrintReport report;
  report.states = StateTimes(TimePoint{});
  report.states.enter(testing::print_state("warming up"), TimePoint{});
  report.states.enter(testing::print_state("lowering"), TimePoint{3s});
  for (std::int32_t i = 0; i < 4; ++i) {
    LayerRecord layer;
    layer.layer = i;
    layer.bottom = kLayer * i;
    layer.thickness = kLayer;
    layer.complete = true;
    layer.done_after = 10s * (i + 1);
    report.layers.push_back(layer);
  }
  report.summary.continuous = ContinuousForecast{
      {},
      {{.bottom = {}, .top = kLayer * 2, .rest = 2s},
       {.bottom = kLayer * 2, .top = kLayer * 3 + kLayer / 2, .limit = RiseLimit::Cure},
       {.bottom = kLayer * 3 + kLayer / 2, .top = kLayer * 4, .limit = RiseLimit::Refill}}};
  return report;
}
using Times = std::vector<std::optional<Duration>>;

TEST_CASE("The ranges of a print took the time of their layers, without warm-up, rests and pauses") {
  PrintReport report = report_of_rise();
  CHECK(range_times(report, report.summary.continuous->ranges) == Times{17s, 13s, 5s});
  report.stops.pauses.push_back({3, 31s, 4s});
  CHECK(range_times(report, report.summary.continuous->ranges) == Times{17s, 11s, 3s});
  CHECK(range_times(report, {}).empty());
}

TEST_CASE("A range that a print did not complete, or began before a power cut, has no time") {
  PrintReport report = report_of_rise();
  report.layers.back().complete = false;
  CHECK(range_times(report, report.summary.continuous->ranges) == Times{17s, std::nullopt, std::nullopt});
  report.layers.back().complete = true;
  report.layers.erase(report.layers.begin());
  CHECK(range_times(report, report.summary.continuous->ranges) ==
        Times{std::nullopt, std::nullopt, std::nullopt});
}

}  // namespace
}  // namespace contourd
