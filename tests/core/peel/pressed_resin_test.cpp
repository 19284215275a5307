#include "core/peel/pressed_resin.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/catch.hpp"

namespace {

using contourd::testing::Approx;

constexpr Micrometers kPitch{50.0};

// Returns the mask of the area in which a function of millimetres from the mask's middle is true.
Mask lit_where(const std::function<bool(double x, double y)>& is_lit) {
  Mask mask(Pixels{1000}, Pixels{900});
  for (std::int32_t row = 0; row < 900; ++row)
    for (std::int32_t column = 0; column < 1000; ++column)
      mask.row(row)[static_cast<std::size_t>(column)] =
          is_lit((column - 499.5) * 0.05, (row - 449.5) * 0.05) ? 255 : 0;
  return mask;
}

double shape_of(const std::function<bool(double x, double y)>& is_lit) {
  return press_shape_mm4(lit_where(is_lit), kPitch);
}

constexpr PressedResin kResin{.viscosity_pa_s = 0.2, .stiffness_n_mm = 460};
constexpr Nanometers kGap{50'000};

}  // namespace

TEST_CASE("The time for which discs press out resin grows with the square of their area") {
  // Three times 0.16, 2.6, 13 and 42 s.
  struct Row {
    double radius_mm, time_constant_s, tolerance_s;
  };
  for (const Row& row : {Row{10, 0.16, 0.005}, Row{20, 2.6, 0.05}, Row{30, 13, 0.5}, Row{40, 42, 0.5}}) {
    const double shape = 1.5 * std::numbers::pi * std::pow(row.radius_mm, 4);
    CHECK(press_time(kResin, shape, kGap).count() / 3 == Approx(row.time_constant_s).margin(row.tolerance_s));
  }
}

TEST_CASE("A disc's shape is exact to the roughness of a circle of cells") {
  for (const double radius : {3.0, 10.0, 20.0}) {
    CAPTURE(radius);
    // A cell of 0.2 mm, and 6 percent of the chamfer's radius, squared.
    CHECK(shape_of([&](double x, double y) { return std::hypot(x, y) < radius; }) ==
          Approx(1.5 * std::numbers::pi * std::pow(radius, 4)).epsilon(2 * (0.06 + 0.2 / radius)));
  }
}

TEST_CASE("A long strip presses out resin as two parallel plates do") {
  const double width = 4, length = 48;
  CHECK(shape_of([&](double x, double y) { return std::abs(x) < length / 2 && std::abs(y) < width / 2; }) ==
        Approx(4 * width * length * std::pow(width / 2, 2)).epsilon(0.15));  // its ends, and half a cell
}

TEST_CASE("Narrow strips count by their width, whether it is an even or an odd number of cells") {
  const double length = 40;
  for (int cells = 2; cells <= 10; ++cells) {
    CAPTURE(cells);
    // The middle of the mask is that of a cell.
    const double width = 0.2 * cells, middle = cells % 2 == 0 ? 0.1 : 0;
    CHECK(shape_of([&](double x, double y) {
            return std::abs(x) < length / 2 && std::abs(y - middle) < width / 2;
          }) == Approx(4 * width * length * std::pow(width / 2, 2)).epsilon(0.05));
  }
}

TEST_CASE("The rims of enclosed areas count by their length in all directions") {
  // Walls of 2 mm; in the corners of those around squares, a circle of a radius of 1.17 mm has room.
  const auto within_walls = [&](const std::function<double(double x, double y)>& distance) {
    return shape_of([&](double x, double y) { return 18 < distance(x, y) && distance(x, y) < 20; });
  };
  const double circle = within_walls([](double x, double y) { return std::hypot(x, y); });
  const double rim = 36 * std::numbers::pi;
  CHECK(circle == Approx(24 * 1 * std::pow(rim * 18 / 2, 2) / rim).epsilon(0.1));
  const double square = within_walls([](double x, double y) { return std::max(std::abs(x), std::abs(y)); });
  CHECK(square == Approx(24 * 1.17 * std::pow(36, 4) / (4 * 36)).epsilon(0.1));
  const double turned =
      within_walls([](double x, double y) { return 4 + (std::abs(x) + std::abs(y)) / std::numbers::sqrt2; });
  CHECK(turned == Approx(24 * 1.17 * std::pow(28, 4) / (4 * 28)).epsilon(0.1));
}

TEST_CASE("Walls count by their width, and the area that they enclose by the gap below them") {
  const auto is_in_box = [](double x, double y, double half) {
    return std::max(std::abs(x), std::abs(y)) < half;
  };
  const double solid = shape_of([&](double x, double y) { return is_in_box(x, y, 20); });
  const double walls =
      shape_of([&](double x, double y) { return is_in_box(x, y, 20) && !is_in_box(x, y, 18); });
  const double slit = shape_of([&](double x, double y) {
    return is_in_box(x, y, 20) && !is_in_box(x, y, 18) && !(x > 0 && std::abs(y) < 0.4);
  });
  // 36 mm square, below walls of 2 mm, in whose corners a circle of a radius of 1.17 mm has room.
  CHECK(walls - slit == Approx(24 * 1.17 * std::pow(36 * 36, 2) / (4 * 36)).epsilon(0.1));
  CHECK(slit < solid / 100);
  CHECK(walls > solid / 10);
  CHECK(walls < solid);
}

TEST_CASE("A dark mask presses out nothing, and a full one as much as a rectangle") {
  CHECK(press_shape_mm4(Mask(Pixels{64}, Pixels{48}), kPitch) == 0);
  CHECK(shape_of([](double, double) { return true; }) ==
        Approx(press_shape_mm4(Millimeters{50}, Millimeters{45})).epsilon(0.03));
}
