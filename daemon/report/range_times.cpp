#include "daemon/report/range_times.hpp"

#include <algorithm>

namespace contourd {
namespace {

// Returns the time that a print took for warm-up and homing.
Duration before_layers(const PrintReport& report) {
  Duration time{};
  for (const auto& [state, spent] : report.states.totals())
    if (state.activity == PrintActivity::Preparing) time += spent;
  return time;
}

// Returns the time of the pauses that ended before a time since the print's start.
Duration pauses_before(const PrintReport& report, Duration time) {
  Duration paused{};
  for (const PrintPause& pause : report.stops.pauses)
    if (pause.at < time) paused += pause.lasted;
  return paused;
}

// Returns the time without pauses at which the print reached a height; nullopt if it did not, or if the
// record does not begin at the plate. Within a layer or slice, time passes evenly.
std::optional<Duration> time_at(const PrintReport& report, Nanometers height) {
  if (report.layers.empty() || report.layers.front().bottom != Nanometers{}) return std::nullopt;
  Duration from = before_layers(report);
  if (height == Nanometers{}) return from;
  for (const LayerRecord& layer : report.layers) {
    const Duration to = layer.done_after - pauses_before(report, layer.done_after);
    const Nanometers top = layer.bottom + layer.thickness;
    if (layer.complete && height <= top) {
      const double part = in_mm(height - layer.bottom) / in_mm(layer.thickness);
      return from + std::chrono::duration_cast<Duration>((to - from) * std::clamp(part, 0.0, 1.0));
    }
    from = to;
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::optional<Duration>> range_times(const PrintReport& report,
                                                 std::span<const ContinuousRange> ranges) {
  std::vector<std::optional<Duration>> times;
  Duration rest{};
  for (const ContinuousRange& range : ranges) {
    const std::optional<Duration> from = time_at(report, range.bottom), to = time_at(report, range.top);
    times.push_back(from && to ? std::optional(std::max(*to - *from - rest, Duration{})) : std::nullopt);
    rest = range.rest;
  }
  return times;
}

}  // namespace contourd
