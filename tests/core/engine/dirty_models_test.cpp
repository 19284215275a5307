// A sample of what dirty-masks checks: masks of dirty models against the reference of the clean ones.

#include "tests/catch.hpp"
#include "tests/reference/dirty_layers.hpp"
#include "tests/reference/dirty_parts.hpp"
#include "tests/reference/scan_lines.hpp"

TEST_CASE("Masks of dirty models equal those of the clean ones", "[long]") {
  constexpr double kHeights[] = {0.37};
  for (const reference::Part& part : reference::clean_parts()) {
    for (const reference::Dirt& dirt : reference::all_dirt()) {
      if (part.joined && dirt.heavy) continue;
      models::Dice dice(1);
      models::Facets dirty = part.facets;
      dirt.add(dirty, dice);
      const auto worst = reference::worst_layer(part.facets, dirty, dirt.wanted, kHeights);
      CAPTURE(part.name, std::string(dirt.name), worst.overlap);
      CHECK(worst.layers == 1);
      CHECK((worst.overlap >= dirt.wanted || (dirt.may_be_told && worst.told)));
    }
  }
}

TEST_CASE("The reference covers a box's pixels by their parts, and an overlap once") {
  // 2 x 2 mm at 1 pixel a mm, half a pixel off the grid to the right.
  models::Facets facets = models::box({-0.5, -1, 0}, {1.5, 1, 1});
  const models::Facets again = facets;
  facets.insert(facets.end(), again.begin(), again.end());
  const std::vector<double> row{0, 0.5, 1, 0.5}, dark(4);
  std::vector<double> expected;
  for (const auto* const each : {&dark, &row, &row, &dark})
    expected.insert(expected.end(), each->begin(), each->end());
  CHECK(reference::coverage_at(facets, 0.5, {4, 4, 1, 0, 0}) == expected);
  CHECK(reference::overlap_of(std::vector<double>{1, 0}, std::vector<std::uint8_t>{255, 255}) == 0.5);
}
