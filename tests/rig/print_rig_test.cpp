#include "tests/rig/print_rig.hpp"

#include "tests/catch.hpp"

using namespace contourd::rig;

TEST_CASE("Whatever goes wrong in a print, its records of light and plate are true") {
  Figures figures;
  // print-rig --seed N --one shows everything about one print.
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Scenario scenario = draw_scenario(seed);
    const Verdict verdict = print(scenario);
    figures.add(verdict.figures);
    if (verdict.violations().empty()) continue;
    FAIL_CHECK(report(smaller(scenario)));
  }
  // The rig must have had enough events to judge.
  CHECK(figures.done > 100);
  CHECK(figures.failed > 30);
  CHECK(figures.line_faults > 100);
  CHECK(figures.slices > 300);
}

TEST_CASE(
    "A layer interrupted by the lid while the loop was held up beyond its end gets the rest of its light") {
  constexpr int kExposing = 8;  // number of the print's states up to the exposure
  Scenario scenario;
  scenario.light = LightKind::Line;
  scenario.exposure = 500ms;
  scenario.layers = 1;
  scenario.happenings = {{Happening::Kind::LoopHeldUp, kExposing, 50ms, 1s, 1},
                         {Happening::Kind::OpenLid, kExposing, 200ms, 100ms, 1}};
  const Verdict verdict = print(scenario);
  INFO(report(scenario));
  CHECK(verdict.violations().empty());
  CHECK(verdict.figures.interruptions > 0);
}
