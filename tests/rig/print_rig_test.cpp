#include "tests/rig/print_rig.hpp"

#include "tests/catch.hpp"

using namespace contourd::rig;

TEST_CASE("Whatever goes wrong in a print, its light and its plate are what they are said to be") {
  Figures figures;
  // print-rig --seed N --one tells all of one.
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Scenario scenario = draw_scenario(seed);
    const Verdict verdict = print(scenario);
    figures.add(verdict.figures);
    if (verdict.violations().empty()) continue;
    FAIL_CHECK(report(smaller(scenario)));
  }
  // The rig has had something to look at.
  CHECK(figures.done > 100);
  CHECK(figures.failed > 30);
  CHECK(figures.line_faults > 100);
}
