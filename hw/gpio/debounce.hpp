// Debounces a contact: a level counts when it has lasted. Pure value; neither allocates nor throws.
#pragma once

#include <array>
#include <optional>

#include "hw/clock.hpp"

namespace contourd {

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
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
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

}  // namespace contourd
