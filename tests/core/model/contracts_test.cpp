// Checks that each header of core/model, and the mesh repair, checks what it requires.

#include "core/model/height_index.hpp"
#include "core/model/placement.hpp"
#include "core/model/shell_report.hpp"
#include "core/model/sine_cosine.hpp"
#include "core/repair/mesh_repair.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("sine_cosine() requires a finite angle") {
  for (const double degrees : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()})
    CHECK(contract_broken_by([&] { (void)sine_cosine(degrees); }) == "the angle is finite");
}

TEST_CASE("A model is turned only by a direction that is finite and not zero") {
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  const auto turned = [&](const Direction& up) {
    return contract_broken_by([&] { orient(facets, {.up = up}); });
  };
  CHECK(turned({0, 1e-300, 0}).empty());
  CHECK(turned({0, 0, 0}) == "the upward direction is finite and not zero");
  CHECK(turned({0, kInfinity, 1}) == "the upward direction is finite and not zero");
}

TEST_CASE("HeightIndex requires a range that begins at or below its end") {
  const HeightIndex box(models::box({0, 0, 0}, {1, 1, 1}));
  const auto ask = [&](double low, double high) {
    return contract_broken_by([&] { box.for_each_candidate_run(low, high, [](const auto&) {}); });
  };
  CHECK(ask(0.5, 0.5).empty());
  CHECK(ask(0.5, 0.4) == "the range begins at or below its end");
}

TEST_CASE("Meshes with coordinates that are not finite are neither indexed nor repaired") {
  if (testing::costly_checks_are_off()) return;
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  facets[3].vertices[1].y = std::numeric_limits<float>::infinity();
  CHECK(contract_broken_by([&] { HeightIndex{facets}; }) == "all coordinates are finite");
  CHECK(contract_broken_by([&] { (void)repair_mesh(facets); }) == "all coordinates are finite");
  CHECK(contract_broken_by([&] { (void)inspect_shells(facets); }) == "all coordinates are finite");
}
