#include "core/calibration/lamp_photo.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibration/refuse.hpp"
#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::size_t kSamples = 65536;
constexpr double kWhite = kSamples - 1;
constexpr std::uint16_t kNearlyWhite = 65'000;  // 253 of 255
constexpr double kMostWhite = 0.001;            // share of a cell's pixels
constexpr double kLeastLight = 0.05;            // share of white, in the brightest cell
constexpr std::int64_t kFewestPixels = 100;     // in a cell's middle
constexpr double kMiddle = 0.5;                 // share of a cell's width and height

double light_of(double sample, PhotoEncoding encoding) {
  if (encoding == PhotoEncoding::Linear) return sample;
  return sample <= 0.04045 ? sample / 12.92 : std::pow((sample + 0.055) / 1.055, 2.4);
}

void check_corners(const std::array<PhotoPoint, 4>& corners) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const PhotoPoint &before = corners[i], &here = corners[(i + 1) % 4], &after = corners[(i + 2) % 4];
    const double turn = (here.x - before.x) * (after.y - here.y) - (here.y - before.y) * (after.x - here.x);
    left += turn < 0 ? 1 : 0;
    right += turn > 0 ? 1 : 0;
  }
  if (std::max(left, right) == 4) return;
  refuse(
      "the corners %g,%g %g,%g %g,%g %g,%g do not go around a picture: give the corner with one dot, then "
      "those "
      "with two, three and four",
      corners[0].x, corners[0].y, corners[1].x, corners[1].y, corners[2].x, corners[2].y, corners[3].x,
      corners[3].y);
}

// Returns the projective map from a quadrangle to the unit square, row by row.
std::array<double, 9> map_from(const std::array<PhotoPoint, 4>& p) {
  const double x1 = p[1].x - p[2].x, x2 = p[3].x - p[2].x, x3 = p[0].x - p[1].x + p[2].x - p[3].x;
  const double y1 = p[1].y - p[2].y, y2 = p[3].y - p[2].y, y3 = p[0].y - p[1].y + p[2].y - p[3].y;
  const double area = x1 * y2 - x2 * y1;
  const double g = (x3 * y2 - x2 * y3) / area, h = (x1 * y3 - x3 * y1) / area;
  const double a = p[1].x - p[0].x + g * p[1].x, b = p[3].x - p[0].x + h * p[3].x, c = p[0].x;
  const double d = p[1].y - p[0].y + g * p[1].y, e = p[3].y - p[0].y + h * p[3].y, f = p[0].y;
  // The adjugate of the map from the unit square.
  return {e - f * h,     c * h - b,     b * f - c * e, f * g - d,    a - c * g,
          c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d};
}

// Returns the index of the cell in whose middle a place from 0 to 1 lies, or -1.
int index_at(double place, int cells) {
  if (!(place >= 0 && place < 1)) return -1;
  const double scaled = place * cells, index = std::floor(scaled);
  return std::abs(scaled - index - 0.5) <= kMiddle / 2 ? static_cast<int>(index) : -1;
}

}  // namespace

LampPhoto::LampPhoto(const std::array<PhotoPoint, 4>& corners, const LampGrid& grid, PhotoEncoding encoding)
    : grid_(grid) {
  expects(std::min(grid.columns, grid.rows) >= LampGrid::kLeast, "a grid of at least three columns and rows");
  expects(std::max(grid.columns, grid.rows) <= LampGrid::kMost, "a grid of at most nine columns and rows");
  cells_.resize(static_cast<std::size_t>(grid.cells()));
  check_corners(corners);
  to_display_ = map_from(corners);
  for (std::size_t sample = 0; sample < kSamples; ++sample)
    light_of_.push_back(static_cast<float>(light_of(static_cast<double>(sample) / kWhite, encoding)));
}

LampPhoto::Cell* LampPhoto::cell_at(double x, double y) {
  const std::array<double, 9>& m = to_display_;
  const double scale = m[6] * x + m[7] * y + m[8];
  const int column = index_at((m[0] * x + m[1] * y + m[2]) / scale, grid_.columns);
  const int row = index_at((m[3] * x + m[4] * y + m[5]) / scale, grid_.rows);
  if (column < 0 || row < 0) return nullptr;
  const int cell = row * grid_.columns + column;
  return &cells_[static_cast<std::size_t>(cell)];
}

void LampPhoto::add_row(std::int32_t y, std::span<const std::uint16_t> samples, std::size_t channels) {
  expects(channels > 0, "a pixel has a channel");
  for (std::size_t x = 0; x < samples.size() / channels; ++x) {
    Cell* const cell = cell_at(static_cast<double>(x) + 0.5, y + 0.5);
    if (cell == nullptr) continue;
    const auto pixel = samples.subspan(x * channels, channels);
    double light = 0;
    for (const std::uint16_t sample : pixel)
      light += light_of_[sample];
    cell->light += light / static_cast<double>(channels);
    ++cell->pixels;
    cell->white += std::ranges::max(pixel) >= kNearlyWhite ? 1 : 0;
  }
}

std::vector<LampReading> LampPhoto::readings() const {
  std::vector<LampReading> readings;
  double brightest = 0;
  for (int i = 0; i < grid_.cells(); ++i) {
    const Cell& cell = cells_[static_cast<std::size_t>(i)];
    if (cell.pixels < kFewestPixels)
      refuse(
          "cell %d of %d has %lld pixels in the photo, fewer than %lld: give the picture's corners, or a "
          "finer photo",
          i + 1, grid_.cells(), static_cast<long long>(cell.pixels), static_cast<long long>(kFewestPixels));
    const auto pixels = static_cast<double>(cell.pixels);
    if (const double white = static_cast<double>(cell.white) / pixels; white > kMostWhite)
      refuse("the photo is overexposed: %.3g %% of the pixels of cell %d of %d are white; expose it less",
             100 * white, i + 1, grid_.cells());
    readings.push_back({grid_.middle(i), cell.light / pixels});
    brightest = std::max(brightest, readings.back().light);
  }
  if (!(brightest >= kLeastLight))
    refuse(
        "the photo is too dark: its brightest cell has %.2g %% of white's light, %g %% are needed; expose it "
        "more",
        100 * brightest, 100 * kLeastLight);
  return readings;
}

}  // namespace contourd
