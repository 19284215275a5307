#include "daemon/jobs/print_analyst.hpp"

#include <memory>
#include <vector>

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

const DisplayGeometry kDisplay{Pixels{64}, Pixels{48}, Micrometers{100.0}};

AnalysisTask task(std::int32_t layers) {
  AnalysisTask task;
  task.engine = std::make_unique<ContourEngine>(HeightIndex(models::box({0, 0, 0}, {3, 2, 1})),
                                                EngineSettings{kDisplay, AntiAliasing::On},
                                                std::vector{PixelMap::true_scale(kDisplay, {1.5, 1})});
  task.display = kDisplay;
  task.layers.assign(static_cast<std::size_t>(layers), Nanometers{100'000});
  task.layer_durations.assign(static_cast<std::size_t>(layers), 2s);
  return task;
}

}  // namespace

TEST_CASE("A print is analysed beside the loop and its findings come back on it") {
  EventLoop loop;
  PrintAnalyst analyst(loop);
  AnalyzedPrint analyzed;
  analyst.start(task(10), [&](AnalyzedPrint print) {
    analyzed = std::move(print);
    loop.stop();
  });
  CHECK(analyst.busy());
  loop.run();
  CHECK(!analyst.busy());
  const auto& findings = std::get<PrintFindings>(analyzed.findings);
  CHECK(findings.layers() == 10);
  CHECK(findings.layer_time == 20s);
  CHECK(findings.volume_mm3 == testing::Approx(6).epsilon(1e-12));
}

TEST_CASE("A cancelled analysis is not heard of and the next one is") {
  EventLoop loop;
  PrintAnalyst analyst(loop);
  std::vector<int> heard;
  analyst.start(task(100'000), [&](const AnalyzedPrint&) { heard.push_back(1); });
  analyst.cancel();
  CHECK(!analyst.busy());
  analyst.start(task(100'000), [&](const AnalyzedPrint&) { heard.push_back(2); });
  analyst.start(task(3), [&](const AnalyzedPrint&) {
    heard.push_back(3);
    loop.stop();
  });
  loop.run();
  CHECK(heard == std::vector{3});
}
