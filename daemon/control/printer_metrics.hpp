// The printer's metrics for a monitoring system, as text in the OpenMetrics 1.0 format. PrinterStatus fills
// them in, and PrinterService hands the text to MetricsFile. Value type; thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"
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

// A file of metrics for a monitoring system (node-exporter's textfile collector). The metrics are computed
// every few seconds and, if they have changed, written atomically by a separate thread. A problem with the
// folder is logged once and stops nothing else. Event loop's thread only.
class MetricsFile {
 public:
  // `make` returns the file's new content. Loop and log must outlive the object.
  MetricsFile(EventLoop& loop, const Log& log, std::filesystem::path path, std::function<std::string()> make,
              Duration interval = std::chrono::seconds(5));
  // Removes the file; blocks until it is removed.
  ~MetricsFile();
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

 private:
  void update();
  void write(const std::string& text);
  void report(const std::string& trouble);

  EventLoop& loop_;
  const Log& log_;
  std::filesystem::path path_;
  std::function<std::string()> make_;
  Duration interval_;
  std::string written_, trouble_;  // the file's content; the last reported problem
  bool writing_ = false;
  std::shared_ptr<bool> exists_;  // used by the worker: true once it has written the file
  EventLoop::SourcePtr timer_;
  Worker worker_;  // last, so that its thread ends before the members that its tasks use
};

}  // namespace contourd
