// Interfaces of a digital output and a digital input, implemented by real lines and by models. Levels are
// logical ("active" is on, closed, pressed), whatever the polarity of the wire.
#pragma once

#include <optional>
#include <span>

#include "hw/clock.hpp"
#include "hw/interface.hpp"

namespace contourd {

// An output. One thread at a time, which may be any. The implementation's destructor leaves the line
// inactive.
class OutputLine : public Interface {
 public:
  // Sets the level. True if the line has that level now. Neither allocates nor locks: for real-time threads.
  [[nodiscard]] virtual bool set(bool active) noexcept = 0;
};

// An output that any thread may make inactive at any time, in addition to the thread that sets it.
class CuttableLine : public OutputLine {
 public:
  // Makes the line inactive. True if it is inactive now. Neither allocates nor locks.
  [[nodiscard]] virtual bool cut() noexcept = 0;
  // Returns a descriptor by which the line can also be cut (set_line_inactive()). The line owns it; -1 if it
  // has none.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
};

struct LineEdge {
  bool active = false;  // the level after the edge
  TimePoint at{};       // CLOCK_MONOTONIC; the kernel's time stamp for a real line
};

// An input. One thread at a time, which may be any; level() may be called from any thread at any time.
class InputLine : public Interface {
 public:
  // Returns a descriptor that is readable while edges are pending. The line owns it; -1 if it has none.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
  // Returns the present level, or nullopt if it cannot be read.
  [[nodiscard]] virtual std::optional<bool> level() noexcept = 0;
  // Moves pending edges, oldest first, into `edges`. Returns their number. Neither blocks nor allocates.
  [[nodiscard]] virtual std::size_t read_edges(std::span<LineEdge> edges) noexcept = 0;
};

}  // namespace contourd
