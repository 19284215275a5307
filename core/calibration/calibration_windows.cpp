#include "core/calibration/calibration_windows.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Lengths over a window's side.
constexpr double kWindowPitch = 1.6;  // from window to window
constexpr double kDotPitch = 0.1;     // nine dots are as wide as a window
constexpr double kDotSide = 0.06;
constexpr double kDotsBelow = 0.15;  // from the window's lower edge to its dots

constexpr double kSideMm = 6;
constexpr double kSidesOfDisplay = 5;  // a window and its two neighbours, with the space around them

struct Canvas {
  Mask& mask;
  double side;  // of a window, in pixels

  // Fills a rectangle; corners and lengths over a window's side, from the display's middle.
  void fill(double left, double top, double width, double height, std::uint8_t grey) {
    const auto pixel = [this](int across, double length) {
      return static_cast<int>(std::lround(across / 2.0 + length * side));
    };
    const int columns = mask.width().count(), rows = mask.height().count();
    for (int y = pixel(rows, top); y < pixel(rows, top + height); ++y) {
      const auto row = mask.row(y).begin();
      std::fill(row + pixel(columns, left), row + pixel(columns, left + width), grey);
    }
  }
};

}  // namespace

Mask draw_calibration_windows(std::span<const std::uint8_t> greys, Pixels width, Pixels height,
                              Micrometers pitch) {
  expects(!greys.empty() && greys.size() <= kMostWindows, "one to nine windows");
  expects(std::min(width, height) >= Pixels{100}, "a display of at least 100 pixels on each side");
  expects(pitch.count() > 0, "a pitch above 0");
  Mask mask(width, height);
  Canvas canvas{mask,
                std::min(kSideMm * 1000 / pitch.count(), std::min(width, height).count() / kSidesOfDisplay)};
  constexpr std::size_t kColumns = 3;
  for (std::size_t i = 0; i < greys.size(); ++i) {
    const std::size_t column = i % kColumns, row = i / kColumns;
    const double left = (static_cast<double>(column) - 1) * kWindowPitch - 0.5;
    const double top = (static_cast<double>(row) - 1) * kWindowPitch - 0.5;
    canvas.fill(left, top, 1, 1, greys[i]);
    for (std::size_t dot = 0; dot <= i; ++dot)
      canvas.fill(left + kDotPitch * static_cast<double>(dot), top + 1 + kDotsBelow, kDotSide, kDotSide,
                  greys[i]);
  }
  return mask;
}

}  // namespace contourd
