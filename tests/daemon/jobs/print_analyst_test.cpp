#include "daemon/jobs/print_analyst.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/models/models.hpp"

namespace {

AnalysisTask task_for(std::int32_t layers) {
  AnalysisTask task;
  task.engine =
      std::make_unique<ContourEngine>(HeightIndex(models::box({0, 0, 0}, {3, 2, 1})),
                                      EngineSettings{testing::kSmallDisplay, AntiAliasing::On},
                                      std::vector{PixelMap::true_scale(testing::kSmallDisplay, {1.5, 1})});
  task.display = testing::kSmallDisplay;
  task.layers.assign(static_cast<std::size_t>(layers), Nanometers{100'000});
  task.layer_durations.assign(static_cast<std::size_t>(layers), 2s);
  return task;
}

}  // namespace

TEST_CASE("A print is analyzed on another thread, and its findings arrive on the event loop") {
  EventLoop loop;
  PrintAnalyst analyst(loop);
  AnalyzedPrint analyzed;
  analyst.start(task_for(10), [&](AnalyzedPrint print) {
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

TEST_CASE("A cancelled analysis reports nothing, and the next one does") {
  EventLoop loop;
  PrintAnalyst analyst(loop);
  std::vector<int> reported;
  analyst.start(task_for(100'000), [&](const AnalyzedPrint&) { reported.push_back(1); });
  analyst.cancel();
  CHECK(!analyst.busy());
  analyst.start(task_for(100'000), [&](const AnalyzedPrint&) { reported.push_back(2); });
  analyst.start(task_for(3), [&](const AnalyzedPrint&) {
    reported.push_back(3);
    loop.stop();
  });
  loop.run();
  CHECK(reported == std::vector{3});
}
