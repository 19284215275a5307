// The printer's metrics for a monitoring system, as text in the OpenMetrics 1.0 format. PrinterStatus fills
// them in, and PrinterService hands the text to MetricsFile. Value type; thread-safe.
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
    std::int32_t layer = 0, layers = 0;  // the current one, from 1; their number
    Duration time_left{};
  };

  std::string printer;  // the configured name
  std::string_view state;
  std::optional<Print> print;  // nullopt while nothing prints
  bool light_may_be_on = false, ready = false, held = false, plate_occupied = false;
  std::size_t queued = 0;
  // Counted since contourd started:
  std::map<std::string, std::uint64_t, std::less<>> ended;  // jobs by outcome
  Duration lit{};                                           // upper bound of the light in all prints
  std::uint64_t late_steps = 0;
};

// Returns the metrics as text. Names and labels are escaped. Equal metrics give equal text.
[[nodiscard]] std::string as_open_metrics(const PrinterMetrics& metrics);

}  // namespace contourd
