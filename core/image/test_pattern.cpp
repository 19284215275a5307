#include "core/image/test_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::uint8_t kLit = 255;
constexpr double kCellMm = 5;

// A mask that is drawn on by columns and rows, which may lie outside it.
class PatternCanvas {
 public:
  PatternCanvas(Pixels width, Pixels height, Micrometers pitch)
      : mask(width, height),
        columns(width.count()),
        rows(height.count()),
        pixels_per_mm(1000 / pitch.count()) {}

  // Fills the columns [left, right) of the rows [top, bottom).
  void fill(int left, int top, int right, int bottom) {
    left = std::clamp(left, 0, columns), right = std::clamp(right, left, columns);
    for (int y = std::max(top, 0); y < std::min(bottom, rows); ++y)
      std::fill(mask.row(y).begin() + left, mask.row(y).begin() + right, kLit);
  }
  template <typename IsLit>
  void fill_where(const IsLit& is_lit) {
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x)
        mask.row(y)[static_cast<std::size_t>(x)] = is_lit(x, y) ? kLit : 0;
    }
  }
  // Returns the pixel at a distance from the centre along a side, in millimetres.
  [[nodiscard]] int column(double mm) const { return pixel(columns, mm); }
  [[nodiscard]] int row(double mm) const { return pixel(rows, mm); }
  void upright(int column, int width) { fill(column, 0, column + width, rows); }
  void lying(int row, int width) { fill(0, row, columns, row + width); }

  Mask mask;
  const int columns, rows;

 private:
  [[nodiscard]] int pixel(int side, double mm) const {
    return static_cast<int>(std::lround(side / 2.0 + mm * pixels_per_mm));
  }

  const double pixels_per_mm;
};

void draw_grid(PatternCanvas& canvas, Micrometers pitch) {
  const double reach = std::max(canvas.columns, canvas.rows) * pitch.count() / 1000 / 2;
  for (int i = 0; i * kCellMm <= reach; ++i) {
    const int width = i == 0 ? 3 : 1;
    for (const double mm : {i * kCellMm, -i * kCellMm}) {
      canvas.upright(canvas.column(mm) - width / 2, width);
      canvas.lying(canvas.row(mm) - width / 2, width);
    }
  }
}

void draw_checker(PatternCanvas& canvas, Micrometers pitch) {
  const double cell = kCellMm * 1000 / pitch.count();
  const auto cell_of = [cell](int pixel, int side) { return std::floor((pixel + 0.5 - side / 2.0) / cell); };
  canvas.fill_where([&](int x, int y) {
    return std::fmod(std::abs(cell_of(x, canvas.columns) + cell_of(y, canvas.rows)), 2) == 0;
  });
}

void draw_focus(PatternCanvas& canvas) {
  constexpr int kBlock = 64;
  canvas.fill_where([](int x, int y) {
    switch ((x / kBlock + y / kBlock) % 3) {
      case 0:
        return x % 2 == 0;
      case 1:
        return y % 2 == 0;
      default:
        return x % 4 == 0 && y % 4 == 0;
    }
  });
}

void draw_border(PatternCanvas& canvas) {
  canvas.upright(0, 1);
  canvas.upright(canvas.columns - 1, 1);
  canvas.lying(0, 1);
  canvas.lying(canvas.rows - 1, 1);
  canvas.upright(canvas.columns / 2, 1);
  canvas.lying(canvas.rows / 2, 1);
  const int square = std::max(std::min(canvas.columns, canvas.rows) / 8, 1);
  canvas.fill(square / 2, square / 2, square / 2 + square, square / 2 + square);
}

void draw_dimensions(PatternCanvas& canvas, Micrometers pitch) {
  const auto half = [&](int side) { return ruler_length(Pixels{side}, pitch).count() / 2; };
  const auto reach_of = [](int millimetre) {
    return millimetre % 10 == 0 ? 3.0 : millimetre % 5 == 0 ? 2.0 : 1.0;
  };
  const double across = half(canvas.columns), down = half(canvas.rows);
  canvas.fill(canvas.column(-across), canvas.row(0), canvas.column(across), canvas.row(0) + 1);
  canvas.fill(canvas.column(0), canvas.row(-down), canvas.column(0) + 1, canvas.row(down));
  // The tick at the end is the last pixel inside the length, not the first one beyond it.
  for (int mm = 0; mm <= 2 * across; ++mm) {
    const int x = canvas.column(mm - across) - (mm >= 2 * across ? 1 : 0);
    canvas.fill(x, canvas.row(-reach_of(mm)), x + 1, canvas.row(reach_of(mm)));
  }
  for (int mm = 0; mm <= 2 * down; ++mm) {
    const int y = canvas.row(mm - down) - (mm >= 2 * down ? 1 : 0);
    canvas.fill(canvas.column(-reach_of(mm)), y, canvas.column(reach_of(mm)), y + 1);
  }
}

}  // namespace

std::string_view name_of(TestPattern pattern) {
  switch (pattern) {
    case TestPattern::White:
      return "white";
    case TestPattern::Black:
      return "black";
    case TestPattern::Grid:
      return "grid";
    case TestPattern::Checker:
      return "checker";
    case TestPattern::Focus:
      return "focus";
    case TestPattern::Border:
      return "border";
    case TestPattern::Dimensions:
      return "dimensions";
  }
  return "?";
}

std::optional<TestPattern> find_test_pattern(std::string_view name) {
  const auto* const found =
      std::ranges::find_if(kTestPatterns, [name](TestPattern each) { return name_of(each) == name; });
  return found != kTestPatterns.end() ? std::optional(*found) : std::nullopt;
}

Mask draw_test_pattern(TestPattern pattern, Pixels width, Pixels height, Micrometers pitch) {
  expects(pitch.count() > 0, "a pixel has a size");
  PatternCanvas canvas(width, height, pitch);
  switch (pattern) {
    case TestPattern::White:
      canvas.fill(0, 0, canvas.columns, canvas.rows);
      break;
    case TestPattern::Black:
      break;
    case TestPattern::Grid:
      draw_grid(canvas, pitch);
      break;
    case TestPattern::Checker:
      draw_checker(canvas, pitch);
      break;
    case TestPattern::Focus:
      draw_focus(canvas);
      break;
    case TestPattern::Border:
      draw_border(canvas);
      break;
    case TestPattern::Dimensions:
      draw_dimensions(canvas, pitch);
      break;
  }
  return std::move(canvas.mask);
}

Millimeters ruler_length(Pixels side, Micrometers pitch) {
  const double most = side.count() * pitch.count() / 1000 * 0.9;
  const double unit = most < 10 ? 1 : 10;
  return Millimeters{std::floor(most / unit) * unit};
}

}  // namespace contourd
