// The contacts of the axis: plain ones and those of safety inputs. Pure values; neither allocate nor throw.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hw/clock.hpp"

namespace contourd {

// Debounces a contact: a level counts when it has lasted.
class Debounce {
 public:
  Debounce() = default;
  Debounce(Duration lasting, bool level) noexcept : lasting_(lasting), raw_(level), settled_(level) {}

  struct Settled {
    bool level = false;
    bool changed = false;  // false after a bounce that returned to the old level
    TimePoint since{};     // the earliest edge to this level
  };

  // Takes an edge with its own time stamp. An edge to the present level counts too, because it shows that
  // others were missed. Edges may be passed in another order than they occurred in.
  void edge(bool level, TimePoint at) noexcept;
  // Takes a level that was read. A level other than the last known one counts as an edge.
  void read(bool level, TimePoint at) noexcept {
    if (level != raw_) edge(level, at);
  }

  // Returns when to call settle(), or nullopt if there was no edge since the contact settled.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept {
    return moving_ ? std::optional(last_ + lasting_) : std::nullopt;
  }
  // Returns the settled level, once after each burst of edges; nullopt otherwise.
  std::optional<Settled> settle(TimePoint now) noexcept;

  [[nodiscard]] bool raw() const noexcept { return raw_; }
  [[nodiscard]] bool settled() const noexcept { return settled_; }

 private:
  Duration lasting_{};
  bool raw_ = false, settled_ = false;
  bool moving_ = false;
  TimePoint last_{};
  std::array<std::optional<TimePoint>, 2> first_{};  // the first edge to each level in this burst
};

enum class SafetyState : std::uint8_t {
  Safe,
  Debouncing,  // unsafe for less than the debounce time
  Unsafe,      // unsafe, or with edges, for the debounce time or longer
};

// The contact of a safety input: an emergency stop, a lid or a power-fail signal. It is unsafe from its first
// edge on, whatever follows, and safe again only when it has been quiet at its safe level for the debounce
// time.
class SafetyContact {
 public:
  SafetyContact() = default;
  // A contact that is unsafe at the start counts as unsafe for longer than the debounce time.
  SafetyContact(Duration debounce, bool unsafe) noexcept
      : debounce_(debounce),
        state_(unsafe ? SafetyState::Unsafe : SafetyState::Safe),
        moving_(unsafe),
        unsafe_(unsafe) {}

  struct Change {
    SafetyState from = SafetyState::Safe, to = SafetyState::Safe;
    TimePoint since{};  // the last edge for a change to Safe; else the first edge of this burst
  };

  // Takes an edge with its own time stamp. An edge to the present level counts too, because it shows that
  // others were missed. Edges may be passed in another order than they occurred in.
  void edge(bool unsafe, TimePoint at) noexcept;
  // Takes a level that was read. A level other than the last known one counts as an edge.
  void read(bool unsafe, TimePoint at) noexcept {
    if (unsafe != unsafe_) edge(unsafe, at);
  }

  // Returns when to call change(), or nullopt if there is no change without a further edge.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  // Makes and returns the next change of state up to `now`; nullopt if there is none left. A burst of edges
  // gives Debouncing, then Unsafe if it lasts, then Safe.
  std::optional<Change> change(TimePoint now) noexcept;

  // Returns the state after the last change(). A later edge makes the contact unsafe before change() says so.
  [[nodiscard]] SafetyState state() const noexcept { return state_; }
  // Returns the last known level.
  [[nodiscard]] bool unsafe_level() const noexcept { return unsafe_; }

 private:
  Change step_to(SafetyState state, TimePoint since) noexcept;

  Duration debounce_{};
  SafetyState state_ = SafetyState::Safe;
  bool moving_ = false;  // in a burst of edges
  bool unsafe_ = false;
  TimePoint first_{}, last_{};  // the first and the last edge of this burst
};

}  // namespace contourd
