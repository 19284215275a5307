// Analyses a whole print beside it, on a thread of its own that gives way to everything else: the first light
// does not wait for it. Event loop's thread only.
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
  std::unique_ptr<ContourEngine> engine;  // its own: the print's computes masks meanwhile
  DisplayGeometry display;
  std::vector<Nanometers> layers;         // their thicknesses
  std::vector<Duration> layer_durations;  // by layer
  AnalysisOptions options{};
};

struct AnalyzedPrint {
  // Or why there are none.
  std::variant<PrintFindings, std::string> findings;
  Duration took{};
};

class PrintAnalyst {
 public:
  explicit PrintAnalyst(EventLoop& loop);
  // Waits for at most one layer's mask.
  ~PrintAnalyst();
  PrintAnalyst(const PrintAnalyst&) = delete;
  PrintAnalyst& operator=(const PrintAnalyst&) = delete;

  // `done` is called from the loop. An analysis still under way is cancelled.
  void start(AnalysisTask task, std::function<void(AnalyzedPrint)> done);
  // Its `done` is not called any more.
  void cancel();
  // An analysis was started and its `done` is still to come.
  [[nodiscard]] bool busy() const { return busy_; }

 private:
  bool busy_ = false;
  std::stop_source stop_;
  Worker worker_;
};

}  // namespace contourd
