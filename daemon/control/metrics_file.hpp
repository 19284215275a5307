// A file of metrics for a monitoring system (node-exporter's textfile collector). The metrics are computed
// every few seconds and, if they have changed, written atomically by a separate thread; the file is removed
// at the end. A problem with the folder is logged once and stops nothing else. Event loop's thread only.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

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
