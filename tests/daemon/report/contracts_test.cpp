// Tests of the contract checks in daemon/report.

#include <string>
#include <vector>

#include "daemon/report/html_page.hpp"
#include "daemon/report/light_histogram.hpp"
#include "daemon/report/plate_copies.hpp"
#include "daemon/report/state_times.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/report/print_state.hpp"

TEST_CASE("svg_plot requires rising heights") {
  if (testing::costly_checks_are_off()) return;
  const PlotPoint rising[] = {{1, 5}, {1, 6}, {2, 4}}, falling[] = {{1, 5}, {0.5, 6}};
  CHECK(contract_broken_by([&] { (void)svg_plot("area", rising); }).empty());
  CHECK(contract_broken_by([&] { (void)svg_plot("area", falling); }) == "heights rise");
}

TEST_CASE("StateTimes::enter requires times that do not fall") {
  const TimePoint start{std::chrono::hours(1)};
  StateTimes times(start);
  CHECK(contract_broken_by([&] {
          times.enter(print_state("homing"), start - std::chrono::nanoseconds(1));
        }) == "times do not fall");
  CHECK(contract_broken_by([&] { times.enter(print_state("homing"), start); }).empty());
}

TEST_CASE("Drawing a light histogram requires bins") {
  CHECK(contract_broken_by([] { (void)svg_of(LightHistogram{}); }) == "a histogram has bins");
}

TEST_CASE("Dark copies require exclusions of copies, by rising layers") {
  const std::vector<PlateCopy> copies(2);
  const auto broken = [&](const std::vector<Exclusion>& exclusions) {
    return contract_broken_by([&] { (void)dark_copies(exclusions, copies, {}, {}); });
  };
  const std::string known = "exclusions are those of copies, by rising layers";
  CHECK(broken({{0, "", 3}, {1, "", 3}}).empty());
  CHECK(broken({{0, "", 3}, {1, "", 2}}) == known);
  CHECK(broken({{2, "", 3}}) == known);
}
