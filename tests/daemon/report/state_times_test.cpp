#include "daemon/report/state_times.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/report/print_state.hpp"

namespace {

constexpr TimePoint kStart{std::chrono::hours(1000)};

Duration sum_of(const StateTimes& times, PrintActivity activity) {
  Duration sum{};
  for (const StateTimes::Slice& slice : times.slices())
    sum += slice[static_cast<std::size_t>(activity)];
  return sum;
}

}  // namespace

TEST_CASE("Each state gets the time until the next state is entered") {
  StateTimes times(kStart);
  times.enter(print_state("warming up"), kStart);
  times.enter(print_state("homing"), kStart + 5s);
  times.enter(print_state("homing"), kStart + 6s);
  times.enter(print_state("exposing"), kStart + 8s);
  times.enter(kIdle, kStart + 11s);
  CHECK(testing::time_in(times, "warming up") == 5s);
  CHECK(testing::time_in(times, "homing") == 3s);
  CHECK(testing::time_in(times, "exposing") == 3s);
  CHECK(testing::time_in(times, "idle") == 0s);
  CHECK(times.total() == 11s);
}

TEST_CASE("Slices follow each other without gaps, and a long state is in all slices that it spans") {
  StateTimes times(kStart);
  times.enter(print_state("exposing"), kStart);
  times.enter(print_state("paused"), kStart + 250ms);
  times.enter(kIdle, kStart + 420ms);
  REQUIRE(times.slice_width() == 100ms);
  REQUIRE(times.slices().size() == 5);
  const auto in = [&](std::size_t slice, PrintActivity activity) {
    return times.slices()[slice][static_cast<std::size_t>(activity)];
  };
  CHECK(in(1, PrintActivity::Exposing) == 100ms);
  CHECK(in(2, PrintActivity::Exposing) == 50ms);
  CHECK(in(2, PrintActivity::Stopped) == 50ms);
  CHECK(in(3, PrintActivity::Stopped) == 100ms);
  CHECK(in(4, PrintActivity::Stopped) == 20ms);
}

TEST_CASE("A print of a week keeps to the limit of slices, and no time is lost") {
  StateTimes times(kStart);
  TimePoint now = kStart;
  Duration exposing{}, moving{};
  for (int layer = 0; layer < 100'000; ++layer) {
    times.enter(print_state("exposing"), now);
    now += 2'100ms;
    exposing += 2'100ms;
    times.enter(print_state("lifting"), now);
    now += 3'700ms;
    moving += 3'700ms;
  }
  times.enter(kIdle, now);
  CHECK(times.slices().size() <= StateTimes::kMaxSlices);
  CHECK(times.slices().size() > StateTimes::kMaxSlices / 2);
  CHECK(sum_of(times, PrintActivity::Exposing) == exposing);
  CHECK(sum_of(times, PrintActivity::Moving) == moving);
  CHECK(testing::time_in(times, "exposing") == exposing);
  for (std::size_t i = 0; i + 1 < times.slices().size(); ++i) {
    Duration sum{};
    for (const Duration part : times.slices()[i])
      sum += part;
    CHECK(sum == times.slice_width());
  }
}

TEST_CASE("A state that lasts a year keeps to the limit of slices") {
  StateTimes times(kStart);
  times.enter(print_state("paused"), kStart + 1s);
  times.enter(kIdle, kStart + std::chrono::hours(8766));
  CHECK(times.slices().size() <= StateTimes::kMaxSlices);
  CHECK(sum_of(times, PrintActivity::Stopped) == std::chrono::hours(8766) - 1s);
}

TEST_CASE("Every state has an activity, and Paused and Held count as stopped") {
  for (const PrintState& state : print_states())
    CHECK(name_of(state.activity) != "?");
  CHECK(print_state("paused").activity == PrintActivity::Stopped);
  CHECK(print_state("held").activity == PrintActivity::Stopped);
  CHECK(print_state("exposing").activity == PrintActivity::Exposing);
}
