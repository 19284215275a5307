// A printer in figures for a monitoring system, as text by OpenMetrics 1.0. Value type; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "hw/clock.hpp"

namespace contourd {

struct PrinterMetrics {
  struct Print {
    std::int32_t layer = 0, layers = 0;  // the one under way, from 1, of all
    Duration time_left{};
  };

  std::string printer;  // what people call it
  std::string_view state;
  std::optional<Print> print;  // nothing while none is under way
  bool light_may_be_on = false, ready = false, held = false, plate_occupied = false;
  std::size_t queued = 0;
  // Since contourd started.
  std::map<std::string, std::uint64_t, std::less<>> ended;  // jobs by outcome
  Duration lit{};                                           // light that prints gave, at most
  std::uint64_t late_steps = 0;
};

// Names and labels are escaped, whatever they are made of. The same figures are the same text.
[[nodiscard]] std::string as_open_metrics(const PrinterMetrics& metrics);

}  // namespace contourd
