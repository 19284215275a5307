#include "hw/virtual_clock.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

TEST_CASE("A new clock stands at its beginning and is idle") {
  VirtualClock clock;
  CHECK(clock.now() == TimePoint{});
  CHECK(clock.idle());
  CHECK_FALSE(clock.run_next());
  CHECK(clock.now() == TimePoint{});
}

TEST_CASE("Calls are made in the order of their times, and the clock shows the time of each") {
  VirtualClock clock;
  std::string made;
  const auto b = clock.call_after(2s, [&] { made += 'b'; });
  const auto a = clock.call_after(1s, [&] { made += 'a'; });
  const auto c = clock.call_at(TimePoint{3s}, [&] { made += 'c'; });
  CHECK(clock.run_next());
  CHECK(clock.now() == TimePoint{1s});
  CHECK(made == "a");
  CHECK(clock.run_next());
  CHECK(clock.run_next());
  CHECK(clock.now() == TimePoint{3s});
  CHECK(made == "abc");
  CHECK(clock.idle());
  CHECK_FALSE(clock.run_next());
}

TEST_CASE("A call is never made from inside call_at") {
  VirtualClock clock;
  bool made = false;
  const auto timer = clock.call_after(0s, [&] { made = true; });
  CHECK_FALSE(made);
  CHECK_FALSE(clock.idle());
  clock.run_next();
  CHECK(made);
}

TEST_CASE("Calls due at the same time are made in the order in which they were requested") {
  VirtualClock clock;
  std::vector<int> made;
  std::vector<std::unique_ptr<Timer>> timers;
  for (int i = 0; i < 20; ++i)
    timers.push_back(clock.call_after(1s, [&made, i] { made.push_back(i); }));
  while (clock.run_next()) {
  }
  REQUIRE(made.size() == 20);
  for (int i = 0; i < 20; ++i)
    CHECK(made[static_cast<std::size_t>(i)] == i);
}

TEST_CASE("A call for a time in the past is made now, after the calls already due now") {
  VirtualClock clock;
  std::string made;
  const auto first = clock.call_after(5s, [&] { made += '5'; });
  clock.run_next();
  const auto due = clock.call_after(0s, [&] { made += 'd'; });
  const auto late = clock.call_at(TimePoint{1s}, [&] { made += 'l'; });
  clock.run_next();
  clock.run_next();
  CHECK(made == "5dl");
  CHECK(clock.now() == TimePoint{5s});
}

TEST_CASE("A destroyed timer's call is not made") {
  VirtualClock clock;
  bool made = false;
  auto timer = clock.call_after(1s, [&] { made = true; });
  timer.reset();
  CHECK(clock.idle());
  CHECK_FALSE(clock.run_next());
  CHECK_FALSE(made);
  CHECK(clock.now() == TimePoint{});
}

TEST_CASE("A timer may be destroyed after its call") {
  VirtualClock clock;
  std::string made;
  auto timer = clock.call_after(1s, [&] { made += 'a'; });
  clock.run_next();
  const auto other = clock.call_after(1s, [&] { made += 'b'; });
  timer.reset();
  clock.run_next();
  CHECK(made == "ab");
}

TEST_CASE("A timer may be destroyed from inside its own call") {
  VirtualClock clock;
  std::unique_ptr<Timer> timer;
  auto kept_alive = std::make_shared<int>(7);
  int seen = 0;
  timer = clock.call_after(1s, [&timer, &seen, kept_alive] {
    timer.reset();
    seen = *kept_alive;  // the call's captures still exist
  });
  clock.run_next();
  CHECK(seen == 7);
  CHECK(clock.idle());
}

TEST_CASE("A call may cancel another that is due at the same time") {
  VirtualClock clock;
  bool made = false;
  std::unique_ptr<Timer> second;
  const auto first = clock.call_after(1s, [&] { second.reset(); });
  second = clock.call_after(1s, [&] { made = true; });
  while (clock.run_next()) {
  }
  CHECK_FALSE(made);
}

TEST_CASE("A call may replace its own timer by the next") {
  VirtualClock clock;
  std::unique_ptr<Timer> timer;
  int ticks = 0;
  std::function<void()> tick = [&] {
    if (++ticks < 10) timer = clock.call_after(1s, [&] { tick(); });
  };
  timer = clock.call_after(1s, [&] { tick(); });
  while (clock.run_next()) {
  }
  CHECK(ticks == 10);
  CHECK(clock.now() == TimePoint{10s});
}

TEST_CASE("An idle clock wakes its loop once when it gets work") {
  VirtualClock clock;
  int woken = 0;
  clock.on_work([&] { ++woken; });
  const auto a = clock.call_after(1s, [] {});
  CHECK(woken == 1);
  auto b = clock.call_after(2s, [] {});
  CHECK(woken == 1);
  clock.run_next();
  b.reset();
  const auto c = clock.call_after(1s, [] {});
  CHECK(woken == 2);
}

TEST_CASE("Time never goes back, whatever calls are requested") {
  CHECK(rc::check([] {
    VirtualClock clock;
    std::vector<std::unique_ptr<Timer>> timers;
    std::vector<std::pair<TimePoint, int>> made;
    const auto calls = static_cast<int>(testing::draw(1, 30));
    for (int i = 0; i < calls; ++i) {
      const TimePoint when{Duration{testing::draw(-5, 20)}};
      timers.push_back(clock.call_at(when, [&made, &clock, i] { made.emplace_back(clock.now(), i); }));
    }
    while (clock.run_next()) {
    }
    RC_ASSERT(made.size() == static_cast<std::size_t>(calls));
    RC_ASSERT(std::is_sorted(made.begin(), made.end()));
  }));
}
