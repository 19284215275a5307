// What a mask may cost: time, and memory for what its contours' sides become when they are cut where they
// meet. Handed to whatever works on the mask; once it is overrun, the work is left as it is, and what worked
// on it can be used again. Not thread-safe.
//
// A sound section needs some hundred bytes for each of its facets; a soup of them crosses itself in as many
// places as the square of their number.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace contourd {

class MaskBudget {
 public:
  using Clock = std::chrono::steady_clock;

  // Sides at a time, whatever the time left: each takes up to 250 bytes, half a gigabyte in all.
  static constexpr std::size_t kMaxSides = std::size_t{1} << 21;
  // The same where nobody waits: two gigabytes.
  static constexpr std::size_t kMaxSidesEver = std::size_t{1} << 23;

  // As much time as it takes.
  MaskBudget() = default;
  explicit MaskBudget(std::optional<Clock::time_point> deadline, std::size_t most_sides = kMaxSides)
      : deadline_(deadline), most_sides_(most_sides) {}

  // Counts so many steps of work (a side cut, a chain joined: 50 to 1000 ns each), and looks at the clock now
  // and then. False when the budget is overrun: what is being worked on is to be abandoned.
  [[nodiscard]] bool spend(std::size_t steps) {
    steps_ += steps;
    return steps_ >= next_look_ ? look_at_the_clock() : !overrun_;
  }
  // Of work whose steps are not worth counting. False when the budget is overrun.
  [[nodiscard]] bool look_at_the_clock() {
    next_look_ = steps_ + kStepsBetweenLooks;
    if (deadline_ && Clock::now() >= *deadline_) overrun_ = true;
    return !overrun_;
  }
  // The same for sides that are in memory at a time.
  [[nodiscard]] bool can_hold(std::size_t sides) {
    if (sides > most_sides_) overrun_ = too_many_sides_ = true;
    return !overrun_;
  }

  [[nodiscard]] bool overrun() const { return overrun_; }
  // By them, not by time.
  [[nodiscard]] bool too_many_sides() const { return too_many_sides_; }
  // So far: the same for the same section on every machine, as long as the budget is kept.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  // Some tens of microseconds apart.
  static constexpr std::uint64_t kStepsBetweenLooks = 256;

  std::optional<Clock::time_point> deadline_;
  std::size_t most_sides_ = kMaxSidesEver;
  std::uint64_t steps_ = 0, next_look_ = 0;
  bool overrun_ = false, too_many_sides_ = false;
};

}  // namespace contourd
