#include "hw/gpio/step_history.hpp"

#include <atomic>
#include <thread>

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

TimePoint at_ns(std::int64_t ns) {
  return TimePoint{Duration{ns}};
}

}  // namespace

TEST_CASE("A history's count at a time equals a naive count") {
  CHECK(rc::check([] {
    StepHistory history;
    std::vector<std::int64_t> times;
    std::int64_t time = 0;
    for (std::int64_t steps = draw(0, 300); steps > 0; --steps) {
      time += draw(0, 3);  // sometimes two at one time
      times.push_back(time);
      history.add(at_ns(time));
    }
    RC_ASSERT(history.count() == times.size());
    for (std::int64_t asked = -1; asked <= time + 1; ++asked) {
      const auto made = std::ranges::count_if(times, [asked](std::int64_t t) { return t <= asked; });
      RC_ASSERT(history.count_at(at_ns(asked)) == static_cast<std::uint64_t>(made));
    }
  }));
}

TEST_CASE("A history keeps the last steps and the number of earlier ones") {
  StepHistory history;
  const auto all = static_cast<std::int64_t>(StepHistory::kKept * 2 + 100);
  for (std::int64_t step = 1; step <= all; ++step)
    history.add(at_ns(step));
  // A few of the oldest are left out, since the writer may be overwriting them.
  const std::int64_t gone = all - static_cast<std::int64_t>(StepHistory::kKept) + 64;
  CHECK(history.count_at(at_ns(0)) == static_cast<std::uint64_t>(gone));
  CHECK(history.count_at(at_ns(gone)) == static_cast<std::uint64_t>(gone));
  CHECK(history.count_at(at_ns(gone + 1)) == static_cast<std::uint64_t>(gone + 1));
  CHECK(history.count_at(at_ns(all)) == static_cast<std::uint64_t>(all));
}

TEST_CASE("A reader of a history's count finds that step's time, however fast steps are added", "[threads]") {
  StepHistory history;
  std::atomic<bool> quit{false};
  std::thread writer([&] {
    // Step n is made at time n.
    for (std::int64_t step = 1; !quit; ++step)
      history.add(at_ns(step));
  });
  std::uint64_t last = 0;
  int compared = 0;
  bool grows = true, finds = true;
  for (int look = 0; look < 20'000; ++look) {
    const std::uint64_t made = history.count();
    const std::uint64_t found = history.count_at(at_ns(static_cast<std::int64_t>(made)));
    const std::uint64_t then = history.count();
    grows = grows && made >= last;
    last = made;
    // A reader that was delayed for all kept steps gets the number of steps that are no longer kept.
    if (then - made > StepHistory::kKept / 2) continue;
    finds = finds && found == made;
    ++compared;
  }
  quit = true;
  writer.join();
  CHECK(grows);
  CHECK(finds);
  CHECK(compared > 0);
}
