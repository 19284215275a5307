// A limit on the cost of a mask: its time, and the memory for the sides that its contours are cut into. Every
// function that works on the mask gets the budget; once it is overrun the work is abandoned, and the objects
// that did the work can be used again. Not thread-safe.
//
// A sound section needs some hundred bytes for each of its facets; in a soup of facets the crossings grow
// with the square of the number of facets.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace contourd {

class MaskBudget {
 public:
  using Clock = std::chrono::steady_clock;

  // Limit on the sides in memory at a time, however much time is left: each takes up to 250 bytes, half a
  // gigabyte in all.
  static constexpr std::size_t kMaxSides = std::size_t{1} << 21;
  // The limit for a mask that no one is waiting for: two gigabytes.
  static constexpr std::size_t kMaxSidesEver = std::size_t{1} << 23;

  // Makes a budget without a deadline, for up to kMaxSidesEver sides.
  MaskBudget() = default;
  explicit MaskBudget(std::optional<Clock::time_point> deadline, std::size_t most_sides = kMaxSides)
      : deadline_(deadline), most_sides_(most_sides) {}

  // Counts steps of work (a side cut, a chain joined: 50 to 1000 ns each) and looks at the clock now and
  // then. False if the budget is overrun: the work has to be abandoned.
  [[nodiscard]] bool spend(std::size_t steps) {
    steps_ += steps;
    return steps_ >= next_look_ ? look_at_the_clock() : !overrun_;
  }
  // Looks at the clock, for work whose steps are not worth counting. False if the budget is overrun.
  [[nodiscard]] bool look_at_the_clock() {
    next_look_ = steps_ + kStepsBetweenLooks;
    if (deadline_ && Clock::now() >= *deadline_) overrun_ = true;
    return !overrun_;
  }
  // Checks the number of sides in memory at a time. False if the budget is overrun.
  [[nodiscard]] bool can_hold(std::size_t sides) {
    if (sides > most_sides_) overrun_ = too_many_sides_ = true;
    return !overrun_;
  }

  [[nodiscard]] bool overrun() const { return overrun_; }
  // True if the budget was overrun by the number of sides, not by time.
  [[nodiscard]] bool too_many_sides() const { return too_many_sides_; }
  // Returns the steps counted so far: the same number for the same section on every machine, unless the
  // budget is overrun.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  // Some tens of microseconds of work.
  static constexpr std::uint64_t kStepsBetweenLooks = 256;

  std::optional<Clock::time_point> deadline_;
  std::size_t most_sides_ = kMaxSidesEver;
  std::uint64_t steps_ = 0, next_look_ = 0;
  bool overrun_ = false, too_many_sides_ = false;
};

}  // namespace contourd
