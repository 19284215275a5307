// A file of figures for a monitoring system (node-exporter's textfile collector): looked at every few
// seconds, written by a thread of its own where they have changed, always whole, and removed at the end. What
// is wrong with its folder is told once and keeps nothing from going on. Event loop's thread only.
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
  // `make` returns what is to be in it now. Loop and log must outlive the file.
  MetricsFile(EventLoop& loop, const Log& log, std::filesystem::path path, std::function<std::string()> make,
              Duration interval = std::chrono::seconds(5));
  // Removes it, and waits for that.
  ~MetricsFile();
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

 private:
  void look();
  void write(const std::string& text);
  void note(const std::string& trouble);

  EventLoop& loop_;
  const Log& log_;
  std::filesystem::path path_;
  std::function<std::string()> make_;
  Duration interval_;
  std::string written_, trouble_;  // what is in the file; why it is not, told already
  bool writing_ = false;
  std::shared_ptr<bool> there_;  // the worker's: it has written the file
  EventLoop::SourcePtr timer_;
  Worker worker_;  // last: its thread ends before what its tasks use
};

}  // namespace contourd
