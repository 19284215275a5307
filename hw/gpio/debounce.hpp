// A contact that bounces: its level counts when it has lasted. Pure value; neither allocates nor throws.
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
    bool changed = false;  // or else it only bounced, and is where it was
    TimePoint since{};     // the earliest edge to this level
  };

  // An edge, by its own time. An edge to the level there was says that others were missed: it counts as well.
  // They may come in another order than they were made in.
  void edge(bool level, TimePoint at) noexcept;
  // The level as read: an edge of its own when it is not the last known one.
  void read(bool level, TimePoint at) noexcept {
    if (level != raw_) edge(level, at);
  }

  // When to call settle(); nothing while nothing has moved.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  // What it has settled to, once after each bout of edges.
  std::optional<Settled> settle(TimePoint now) noexcept;

  [[nodiscard]] bool raw() const noexcept { return raw_; }
  [[nodiscard]] bool settled() const noexcept { return settled_; }

 private:
  Duration lasting_{};
  bool raw_ = false, settled_ = false;
  bool moving_ = false;
  TimePoint last_{};
  std::array<std::optional<TimePoint>, 2> first_{};  // edge to each level of this bout
};

}  // namespace contourd
