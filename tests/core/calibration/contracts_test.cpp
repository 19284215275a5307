// Tests that the functions of core/calibration check their requirements.
#include <array>
#include <cstdint>
#include <vector>

#include "core/calibration/calibration_models.hpp"
#include "core/calibration/calibration_windows.hpp"
#include "core/calibration/joined_blocks.hpp"
#include "core/calibration/lamp_photo.hpp"
#include "core/calibration/lamp_pictures.hpp"
#include "core/calibration/line_fit.hpp"
#include "core/calibration/linear_fit.hpp"
#include "core/calibration/peel_memory_fit.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace contourd {
namespace {

TEST_CASE("A line requires three points with different x") {
  const std::array two{MeasuredPoint{0, 1}, MeasuredPoint{1, 2}};
  CHECK(contract_broken_by([&] { (void)fit_line(two); }) == "fit_line: at least three points");
  const std::array same{MeasuredPoint{1, 1}, MeasuredPoint{1, 2}, MeasuredPoint{1, 3}};
  CHECK(contract_broken_by([&] { (void)fit_line(same); }) == "fit_line: points with different x");
}

TEST_CASE("Pictures of windows require up to nine windows and a display that can be") {
  const auto draw = [](std::size_t count, int side, double pitch_um) {
    const std::array<std::uint8_t, 10> greys{};
    return contract_broken_by([&] {
      (void)draw_calibration_windows({greys.data(), count}, Pixels{side}, Pixels{200}, Micrometers{pitch_um});
    });
  };
  CHECK(draw(9, 200, 50).empty());
  CHECK(draw(0, 200, 50) == "one to nine windows");
  CHECK(draw(10, 200, 50) == "one to nine windows");
  CHECK(draw(9, 99, 50) == "a display of at least 100 pixels on each side");
  CHECK(draw(9, 200, 0) == "a pitch above 0");
}

TEST_CASE("Calibration models require heights and steps that can be printed") {
  CHECK(contract_broken_by([] { (void)bridge_model(Millimeters{0}, Millimeters{4}); }) ==
        "a layer has a height");
  CHECK(contract_broken_by([] { (void)bridge_model(Millimeters{0.05}, Millimeters{0.9}); }) ==
        "bridges have a clearance");
  CHECK(contract_broken_by([] {
          (void)tower_model({kMostTowerSteps + 1, Millimeters{1}, Millimeters{1}});
        }) == "a tower has some steps");
  CHECK(contract_broken_by([] {
          (void)tower_model({1, Millimeters{1}, Millimeters{0}});
        }) == "a tower's steps have a height");
  CHECK(contract_broken_by([] {
          const std::array flat{Block{{0, 0, 0}, {1, 1, 0}}};
          (void)joined(flat);
        }) == "a block has a volume");
}

TEST_CASE("A linear fit requires more points than terms, all with as many terms") {
  const auto broken = [](const std::vector<LinearPoint>& points) {
    return contract_broken_by([&] { (void)fit_linear(points); });
  };
  CHECK(broken({}) == "fit_linear: more points than terms");
  CHECK(broken({{{1, 2}, 1}, {{1, 3}, 2}}) == "fit_linear: more points than terms");
  CHECK(broken({{{1, 2}, 1}, {{1, 3}, 2}, {{1}, 2}}) == "fit_linear: points with the same number of terms");
  const LinearFit fit{.factors = {1, 2}, .covariance = {1, 0, 0, 1}};
  const std::vector<double> one{1};
  CHECK(contract_broken_by([&] { (void)fit.at(one); }) == "a fit has a factor for each term");
  CHECK(contract_broken_by([&] { (void)fit.leverage(one); }) == "a fit has a factor for each term");
  CHECK(contract_broken_by([&] { (void)fit.factor(2); }) == "a fit has this factor");
}

TEST_CASE("Pictures for a lamp require a grid and a display that can be") {
  const auto draw = [](LampGrid grid, int cell, int side) {
    return contract_broken_by([&] { (void)draw_lamp_field(grid, cell, Pixels{side}, Pixels{200}); });
  };
  CHECK(draw({5, 3}, 14, 200).empty());
  CHECK(draw({2, 3}, 0, 200) == "a grid of at least three columns and rows");
  CHECK(draw({5, 10}, 0, 200) == "a grid of at most nine columns and rows");
  CHECK(draw({5, 3}, 15, 200) == "a cell of the grid");
  CHECK(draw({5, 3}, -1, 200) == "a cell of the grid");
  CHECK(draw({5, 3}, 0, 99) == "a display of at least 100 pixels on each side");
  CHECK(contract_broken_by([] { (void)draw_lamp_photo(Pixels{200}, Pixels{99}); }) ==
        "a display of at least 100 pixels on each side");
  const std::array<PhotoPoint, 4> corners{PhotoPoint{0, 0}, {9, 0}, {9, 9}, {0, 9}};
  CHECK(contract_broken_by([&] {
          (void)LampPhoto(corners, {2, 3}, PhotoEncoding::Linear);
        }) == "a grid of at least three columns and rows");
  CHECK(contract_broken_by([&] {
          (void)LampPhoto(corners, {3, 10}, PhotoEncoding::Linear);
        }) == "a grid of at most nine columns and rows");
  LampPhoto photo(corners, {3, 3}, PhotoEncoding::Linear);
  CHECK(contract_broken_by([&] { photo.add_row(0, {}, 0); }) == "a pixel has a channel");
}

TEST_CASE("A bridge requires layers") {
  const BridgePrint print{.resin = {.curve = {Micrometers{150}, MillijoulesPerCm2{8}}},
                          .layer_height = Nanometers{50'000},
                          .dose = MillijoulesPerCm2{16}};
  CHECK(contract_broken_by([&] { (void)bridge_thickness(print, 1, 0); }) == "a bridge has some layers");
  CHECK(contract_broken_by([&] { (void)bridge_thickness({.resin = print.resin}, 1, 1); }) ==
        "layers have a height");
  CHECK(contract_broken_by([&] { (void)fit_peel_memory({.resin = print.resin}, {}); }) ==
        "bridges have layers");
}

}  // namespace
}  // namespace contourd
