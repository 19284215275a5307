// One digital output, one digital input: what the axis needs of a line, real or modelled. Levels are logical
// ("active" is on, closed, pressed), whatever the polarity of the wire.
#pragma once

#include <optional>
#include <span>

#include "hw/clock.hpp"

namespace contourd {

// Any one thread at a time. An implementation's destructor leaves the line inactive.
class OutputLine {
 public:
  OutputLine() = default;
  OutputLine(const OutputLine&) = delete;
  OutputLine& operator=(const OutputLine&) = delete;
  virtual ~OutputLine() = default;

  // True when the line has that level now. Neither allocates nor locks: for real-time threads.
  [[nodiscard]] virtual bool set(bool active) noexcept = 0;
};

// An output that any thread may make inactive, at any time, beside the one that sets it.
class CuttableLine : public OutputLine {
 public:
  // True when the line is inactive now. Neither allocates nor locks.
  [[nodiscard]] virtual bool cut() noexcept = 0;
  // What else it can be cut by (line_descriptor.hpp), the line's; -1 for a line that has none.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
};

struct LineEdge {
  bool active = false;  // the level from then on
  TimePoint at{};       // CLOCK_MONOTONIC, by the kernel where it is a real line
};

// Any one thread at a time; level() from any thread.
class InputLine {
 public:
  InputLine() = default;
  InputLine(const InputLine&) = delete;
  InputLine& operator=(const InputLine&) = delete;
  virtual ~InputLine() = default;

  // Readable while edges wait. The line's; -1 for a line that has none.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
  // The level now; nothing when it cannot be read.
  [[nodiscard]] virtual std::optional<bool> level() noexcept = 0;
  // Takes edges that wait, oldest first, into `edges`; how many. Does not block, does not allocate.
  [[nodiscard]] virtual std::size_t read_edges(std::span<LineEdge> edges) noexcept = 0;
};

}  // namespace contourd
