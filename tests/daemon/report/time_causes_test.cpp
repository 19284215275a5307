#include "daemon/report/time_causes.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/report/print_state.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;
using Causes = std::vector<TimeCause>;

constexpr TimePoint kBegin{};

// Returns the report of a print that was lit for 100 s and lifted for this long, of two layers with a
// forecast of 100 s each.
PrintReport report_of_lifts(Duration lifted) {
  PrintReport report;
  report.outcome = PrintOutcome::Done;
  report.states = StateTimes(kBegin);
  report.states.enter(testing::print_state("exposing"), kBegin);
  report.states.enter(testing::print_state("lifting"), kBegin + 100s);
  report.states.enter(kIdle, kBegin + 100s + lifted);
  report.layers.resize(2);
  report.forecast.time[TimeCause::Light] = 100s;
  report.forecast.time[TimeCause::Lifting] = 300s;
  return report;
}

TEST_CASE("The times of all states, rises among them, add up by cause to the time of the print") {
  StateTimes states(kBegin);
  TimePoint now = kBegin;
  for (const PrintState& state : print_states()) {
    states.enter(state, now);
    now += 1s;
  }
  states.enter(kIdle, now);
  const TimeByCause times = time_by_cause(states);
  CHECK(times.total() == states.total());
  CHECK(times[TimeCause::Light] == 3s);  // exposing, rising, slowing
  CHECK(times[TimeCause::Recovering] == 1s);
  for (const Duration time : times.each)
    CHECK(time > Duration{});
}

TEST_CASE("A cause that differs by more than a fiftieth of the print's expected time is marked") {
  CHECK(differing_causes(report_of_lifts(308s)).empty());
  CHECK(differing_causes(report_of_lifts(308s + 1ms)) == Causes{TimeCause::Lifting});
  CHECK(differing_causes(report_of_lifts(291s)) == Causes{TimeCause::Lifting});
  CHECK(times_table(report_of_lifts(308s)).find('!') == std::string::npos);
  CHECK(times_table(report_of_lifts(330s)).find("class=\"differs\">+30.0 s !") != std::string::npos);
  PrintReport short_print = report_of_lifts(305s);
  short_print.forecast.time[TimeCause::Light] = 99s;
  CHECK(differing_causes(short_print).empty());  // less than 5 s
  PrintReport canceled = report_of_lifts(50s);
  canceled.outcome = PrintOutcome::Canceled;
  CHECK(differing_causes(canceled).empty());
}

TEST_CASE("The report has the forecast beside the time that the print and its mean layer took") {
  const auto json = times_json(report_of_lifts(330s));
  CHECK(json["forecast"]["time_s"] == 400.0);
  CHECK(json["forecast"]["causes_s"]["lifting"] == 300.0);
  CHECK(json["took_s"]["lifting"] == 330.0);
  CHECK(json["took_a_layer_s"]["lifting"] == 165.0);
  CHECK(json["differs"] == nlohmann::ordered_json{"lifting"});
  CHECK(json["took_s"].size() == kTimeCauses);
}

TEST_CASE("A line names the causes of a time, the longest first") {
  TimeByCause time;
  time[TimeCause::Light] = 30s;
  time[TimeCause::Lifting] = 50s;
  CHECK(causes_line(time) == "1 min 20 s: 50.0 s lifting, 30.0 s light");
}

}  // namespace
}  // namespace contourd
