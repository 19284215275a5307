#include "daemon/jobs/print_analyst.hpp"

#include <exception>
#include <optional>
#include <utility>

namespace contourd {
namespace {

// With this niceness the analysis gets a tenth of the processor time of the event loop's thread if the two
// compete.
constexpr int kAnalystNiceness = 10;

// Returns nullopt if `stop` was requested.
std::optional<AnalyzedPrint> analyze(const AnalysisTask& task, const std::stop_token& stop) {
  const auto start = std::chrono::steady_clock::now();
  AnalyzedPrint analyzed;
  try {
    auto findings = analyze_print(
        *task.engine, task.display, task.layers,
        [&task](std::int32_t layer) { return task.layer_durations[static_cast<std::size_t>(layer)]; }, stop,
        task.options);
    if (!findings) return std::nullopt;
    analyzed.findings = std::move(*findings);
  } catch (const std::exception& error) {
    analyzed.findings = std::string(error.what());
  }
  analyzed.took = std::chrono::steady_clock::now() - start;
  return analyzed;
}

}  // namespace

PrintAnalyst::PrintAnalyst(EventLoop& loop) : worker_(loop, "contourd-layers", kAnalystNiceness) {}

PrintAnalyst::~PrintAnalyst() {
  cancel();
}

void PrintAnalyst::start(AnalysisTask task, std::function<void(AnalyzedPrint)> done) {
  cancel();
  busy_ = true;
  stop_ = std::stop_source();
  // Tasks of a worker are copied, but an engine cannot be.
  const auto shared = std::make_shared<const AnalysisTask>(std::move(task));
  const std::stop_token stop = stop_.get_token();
  worker_.run([shared, stop] { return analyze(*shared, stop); },
              [this, stop, done = std::move(done)](std::optional<AnalyzedPrint> analyzed) {
                if (stop.stop_requested()) return;
                busy_ = false;
                done(std::move(*analyzed));
              });
}

void PrintAnalyst::cancel() {
  stop_.request_stop();
  busy_ = false;
}

}  // namespace contourd
