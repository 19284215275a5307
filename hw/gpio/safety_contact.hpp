// The contact of a safety input, an emergency stop or a lid: unsafe from its first edge on, whatever comes
// behind it, and safe again only when it has been quiet at its safe level for the debounce time. Pure value;
// neither allocates nor throws.
#pragma once

#include <cstdint>
#include <optional>

#include "hw/clock.hpp"

namespace contourd {

enum class SafetyState : std::uint8_t {
  Safe,
  Debouncing,  // unsafe, and not yet known for how long
  Unsafe,      // for the debounce time, or with edges for as long
};

class SafetyContact {
 public:
  SafetyContact() = default;
  // What is unsafe from the start has been so for long enough.
  SafetyContact(Duration debounce, bool unsafe) noexcept
      : debounce_(debounce),
        state_(unsafe ? SafetyState::Unsafe : SafetyState::Safe),
        moving_(unsafe),
        unsafe_(unsafe) {}

  struct Change {
    SafetyState from = SafetyState::Safe, to = SafetyState::Safe;
    TimePoint since{};  // to Safe: the last edge; else the first of this bout
  };

  // An edge, by its own time. An edge to the level there was says that others were missed: it counts as well.
  // They may come in another order than they were made in.
  void edge(bool unsafe, TimePoint at) noexcept;
  // The level as read: an edge of its own when it is not the last known one.
  void read(bool unsafe, TimePoint at) noexcept {
    if (unsafe != unsafe_) edge(unsafe, at);
  }

  // When to call change(); nothing while nothing is to come without an edge.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  // What has come of it by now, a step a call, until it returns nothing: Debouncing once a bout, then Unsafe
  // if it lasts, then Safe.
  std::optional<Change> change(TimePoint now) noexcept;

  // Of the last change; an edge since then makes it unsafe all the same.
  [[nodiscard]] SafetyState state() const noexcept { return state_; }
  // The last known level.
  [[nodiscard]] bool unsafe_level() const noexcept { return unsafe_; }

 private:
  Change step_to(SafetyState state, TimePoint since) noexcept;

  Duration debounce_{};
  SafetyState state_ = SafetyState::Safe;
  bool moving_ = false;  // a bout of edges is under way
  bool unsafe_ = false;
  TimePoint first_{}, last_{};  // edges of this bout
};

}  // namespace contourd
