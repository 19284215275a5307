// Analyzes all layers of a print while it runs, on a thread of its own that gives way to everything else: the
// first light does not wait for the analysis. Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

struct AnalysisTask {
  std::unique_ptr<ContourEngine> engine;  // not the print's, which computes masks at the same time
  DisplayGeometry display;
  std::vector<Nanometers> layers;         // thickness of each layer
  std::vector<Duration> layer_durations;  // how long each layer takes
  AnalysisOptions options{};
};

struct AnalyzedPrint {
  // The findings, or why there are none.
  std::variant<PrintFindings, std::string> findings;
  Duration took{};
};

class PrintAnalyst {
 public:
  explicit PrintAnalyst(EventLoop& loop);
  // Blocks for at most one layer's mask.
  ~PrintAnalyst();
  PrintAnalyst(const PrintAnalyst&) = delete;
  PrintAnalyst& operator=(const PrintAnalyst&) = delete;

  // Starts an analysis, and cancels one that is still under way. `done` is called from the loop.
  void start(AnalysisTask task, std::function<void(AnalyzedPrint)> done);
  // Cancels the analysis; its `done` is not called any more.
  void cancel();
  // True if an analysis was started and its `done` is still to be called.
  [[nodiscard]] bool busy() const { return busy_; }

 private:
  bool busy_ = false;
  std::stop_source stop_;
  Worker worker_;
};

}  // namespace contourd
