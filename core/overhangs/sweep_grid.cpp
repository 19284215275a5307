#include "core/overhangs/sweep_grid.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr double kPixelMm = 0.05;
constexpr double kMostPixels = 2048;

}  // namespace

SweepGrid sweep_grid(const DisplayGeometry& build_area, Nanometers step) {
  expects(
      build_area.pixel_pitch > Micrometers{} && build_area.width > Pixels{} && build_area.height > Pixels{},
      "the build area has a size");
  const double longest = std::max(build_area.width_mm(), build_area.height_mm());
  const double pixel_mm = std::max(kPixelMm, longest / (kMostPixels - 2));
  const auto pixels = [pixel_mm](double length_mm) {
    return Pixels{static_cast<std::int32_t>(std::ceil(length_mm / pixel_mm)) + 2};
  };
  SweepGrid grid;
  grid.display.width = pixels(build_area.width_mm());
  grid.display.height = pixels(build_area.height_mm());
  grid.display.pixel_pitch = Micrometers{pixel_mm * 1000};
  grid.step = step;
  return grid;
}

}  // namespace contourd
