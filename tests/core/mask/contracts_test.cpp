// Checks that each header of core/mask checks what it requires.
#include "core/mask/conic_rows.hpp"
#include "core/mask/coverage_band.hpp"
#include "core/mask/exact_side.hpp"
#include "core/mask/exposure_correction.hpp"
#include "core/mask/light_split.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("Mask has rows from 0 to its height") {
  Mask mask(Pixels{4}, Pixels{3});
  const Mask& same = mask;
  for (const std::int32_t row : {0, 2})
    CHECK(contract_broken_by([&] { (void)mask.row(row); }).empty());
  for (const std::int32_t row : {-1, 3}) {
    CHECK(contract_broken_by([&] { (void)mask.row(row); }) == "the row is in the mask");
    CHECK(contract_broken_by([&] { (void)same.row(row); }) == "the row is in the mask");
  }
}

TEST_CASE("MaskRuns has the rows of the mask that it was extracted from") {
  MaskRuns runs;
  CHECK(contract_broken_by([&] { (void)runs.in_row(0); }) == "the row is in the mask");
  runs.extract(Mask(Pixels{4}, Pixels{3}));
  CHECK(contract_broken_by([&] { (void)runs.in_row(2); }).empty());
  CHECK(contract_broken_by([&] { (void)runs.in_row(3); }) == "the row is in the mask");
  MaskRuns bright;
  CHECK(contract_broken_by([&] { bright.extract_bright(Mask(Pixels{4}, Pixels{2}), runs, 1); }) ==
        "the lit pixels are those of the same mask");
}

TEST_CASE("PixelMap requires a pixel size for true scale") {
  for (const double um : {0.0, -50.0}) {
    const DisplayGeometry display{Pixels{8}, Pixels{6}, Micrometers{um}};
    CHECK(contract_broken_by([&] { (void)PixelMap::true_scale(display, {0, 0}); }) == "a pixel has a size");
  }
}

TEST_CASE("ExposureCorrection takes a gamma from 0.1 to 10, and masks of one size") {
  for (const double gamma : {0.09, 10.1})
    CHECK(contract_broken_by([&] { (void)grey_for_light(gamma); }) == "gamma is 0.1 to 10");
  const ExposureCorrection plain({}, std::nullopt), uneven({}, Mask(Pixels{4}, Pixels{3}));
  Mask from(Pixels{5}, Pixels{3}), to(Pixels{5}, Pixels{3}), other(Pixels{5}, Pixels{4});
  CHECK(contract_broken_by([&] { plain.apply(from, to); }).empty());
  CHECK(contract_broken_by([&] { plain.apply(from, other); }) == "all masks have one size");
  CHECK(contract_broken_by([&] { uneven.apply(from, to); }) == "all masks have one size");
  CHECK(contract_broken_by([&] { plain.apply(from, from); }) ==
        "the corrected mask is another object than the mask");
}

TEST_CASE("CoverageBand has the rows that it reports, and their cells") {
  CoverageBand band(100);
  CHECK(contract_broken_by([&] { (void)band.row(band.rows() - 1); }).empty());
  for (const std::int32_t row : {-1, band.rows()})
    CHECK(contract_broken_by([&] { (void)band.row(row); }) == "the row is in the band");
  if (testing::costly_checks_are_off()) return;
  CHECK(contract_broken_by([&] { band.row(0).add(102, 1); }).empty());
  CHECK(contract_broken_by([&] { band.row(0).add(200, 1); }) == "the column is in the row");
  CHECK(contract_broken_by([&] { band.row(0).add(100, 1, 1, 1); }).empty());
  CHECK(contract_broken_by([&] { band.row(0).add(200, 1, 1, 1); }) == "the columns are in the row");
}

TEST_CASE("side_of() requires coordinates below 1e100") {
  if (testing::costly_checks_are_off()) return;
  CHECK(contract_broken_by([] { (void)side_of({0, 0}, {1, 9e99}, {2, 3}); }).empty());
  CHECK(contract_broken_by([] {
          (void)side_of({0, 0}, {1, 1e100}, {2, 3});
        }) == "coordinates are below 1e100");
}

TEST_CASE("ConvexRows requires a polygon with at least one corner") {
  ConvexRows rows(Pixels{4}, Pixels{3});
  const PixelMap map = PixelMap::true_scale({Pixels{4}, Pixels{3}, Micrometers{50.0}}, {0, 0});
  CHECK(contract_broken_by([&] { rows.visit({}, map, [](auto, auto, auto) {}); }) == "a polygon has corners");
}

TEST_CASE("LightSplit requires a panel with few greys, one of its pictures, and two masks of one size") {
  for (const int bits : {0, 8})
    CHECK(contract_broken_by([&] { LightSplit({bits, 1}); }) == "a panel has 1 to 7 grey bits");
  CHECK(contract_broken_by([] { LightSplit({1, 0}); }) == "gamma is 0.1 to 10");
  const LightSplit split({1, 1});
  Mask light(Pixels{4}, Pixels{3}), picture(Pixels{4}, Pixels{3}), other(Pixels{4}, Pixels{2});
  CHECK(contract_broken_by([&] { split.draw(0, light, {0, 3}, picture); }).empty());
  CHECK(contract_broken_by([&] {
          split.draw(1, light, {0, 3}, picture);
        }) == "the picture is one of the pictures");
  CHECK(contract_broken_by([&] { split.draw(0, light, {0, 3}, light); }) == "two masks have one size");
  CHECK(contract_broken_by([&] { split.draw(0, light, {0, 2}, other); }) == "two masks have one size");
  for (const LightSplit::Rows& rows : {LightSplit::Rows{-1, 3}, LightSplit::Rows{0, 4}})
    CHECK(contract_broken_by([&] { split.draw(0, light, rows, picture); }) == "the masks have these rows");
  CHECK(contract_broken_by([&] { split.sum(light, other); }) == "two masks have one size");
}

TEST_CASE("GivenLight requires a layer of the print") {
  GivenLight given({1, 1}, {0.1, 0.1});
  const Mask light(Pixels{4}, Pixels{3});
  CHECK(contract_broken_by([&] { (void)given.of(1, light); }).empty());
  CHECK(contract_broken_by([&] { (void)given.of(2, light); }) == "the layer is one of the print's");
}

TEST_CASE("A power of a share of the light requires a share, and an exponent above 0") {
  for (const double share : {0.0, 1.5})
    CHECK(contract_broken_by([&] { (void)power_of_share(share, 2); }) ==
          "a share of the light is raised to a power");
  CHECK(contract_broken_by([] { (void)power_of_share(0.5, 0); }) ==
        "a share of the light is raised to a power");
}
