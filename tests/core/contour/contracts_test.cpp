// Checks that each header of core/contour checks what it requires.
#include "core/contour/contour_offset.hpp"
#include "core/contour/contour_union.hpp"
#include "core/contour/open_chain_joiner.hpp"
#include "core/contour/slicer.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("ContourOffset and ContourUnion require a result other than their input") {
  Contours contours;
  CHECK(contract_broken_by([&] { ContourOffset().offset(contours, Millimeters{0.1}, contours); }) ==
        "the moved contours are another object than the contours");
  CHECK(contract_broken_by([&] {
          ContourUnion().unite(contours, FillRule::NonZero, ContourUnion::kDoubleRounding, contours);
        }) == "the outline is another object than the contours");
}

TEST_CASE("PointGrid requires a positive reach") {
  CHECK(contract_broken_by([] { PointGrid().sort({}, {}, 1e-3); }).empty());
  for (const double reach : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    CHECK(contract_broken_by([&] { PointGrid().sort({}, {}, reach); }) == "the reach is positive");
}

TEST_CASE("Intersecting a side requires that it crosses the plane") {
  if (testing::costly_checks_are_off()) return;
  const Vertex lower{0, 0, 1}, upper{1, 1, 2};
  CHECK(contract_broken_by([&] { (void)intersect_side(lower, upper, 1); }).empty());
  for (const double z : {0.5, 2.0})
    CHECK(contract_broken_by([&] { (void)intersect_side(lower, upper, z); }) == "the side crosses the plane");
  CHECK(contract_broken_by([&] { (void)intersect_side(upper, lower, 1.5); }) == "the side crosses the plane");
}
