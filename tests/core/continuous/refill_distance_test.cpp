#include "core/continuous/refill_distance.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/catch.hpp"

namespace {

constexpr double kPixelMm = 0.05;
constexpr std::int32_t kSide = 400;  // pixels: 20 mm

// Returns the cells of the area in which a function of millimetres from the mask's middle is true.
LitCells area_where(const std::function<bool(double x, double y)>& is_lit) {
  Mask mask(Pixels{kSide}, Pixels{kSide});
  for (std::int32_t row = 0; row < kSide; ++row)
    for (std::int32_t column = 0; column < kSide; ++column)
      mask.row(row)[static_cast<std::size_t>(column)] =
          is_lit((column + 0.5 - kSide / 2) * kPixelMm, (row + 0.5 - kSide / 2) * kPixelMm) ? 255 : 0;
  return {mask, refill_cells(mask.width(), mask.height())};
}

LitCells ring(double inner_mm, double outer_mm) {
  return area_where(
      [=](double x, double y) { return std::hypot(x, y) < outer_mm && std::hypot(x, y) >= inner_mm; });
}

RefillDistance new_print() {
  return RefillDistance(Millimeters{4 * kPixelMm});
}

double distance_of(const LitCells& first_slab) {
  return new_print().add_slab(first_slab).count();
}

// True if a distance is at least the right one, and at most two cells and the chamfer's error more.
bool is_safe(double distance_mm, double right_mm) {
  return distance_mm >= right_mm && distance_mm <= right_mm * 1.13 + 0.4;
}

}  // namespace

TEST_CASE("Resin flows half the width of a strip, and the radius over sqrt(2) of a disc") {
  CHECK(distance_of(ring(30, 40)) == 0);
  CHECK(is_safe(distance_of(ring(0, 8)), 8 / std::numbers::sqrt2));
  CHECK(is_safe(
      distance_of(area_where([](double x, double y) { return std::fabs(x) < 9 && std::fabs(y) < 2; })), 2));
}

TEST_CASE("Of several areas, the one that is hardest to reach counts") {
  CHECK(is_safe(distance_of(area_where(
                    [](double x, double y) { return std::hypot(x + 6, y) < 3 || std::hypot(x - 6, y) < 1; })),
                3 / std::numbers::sqrt2));
}

TEST_CASE("A hole that begins on the plate is no rim until it leads outside") {
  RefillDistance print = new_print();
  const double closed = 8 / std::numbers::sqrt2;
  CHECK(is_safe(print.add_slab(ring(4, 8)).count(), closed));
  CHECK(is_safe(print.add_slab(ring(4, 8)).count(), closed));
  // A slot lets resin in; above it, the hole is open.
  CHECK(is_safe(print
                    .add_slab(area_where([](double x, double y) {
                      return std::hypot(x, y) < 8 && std::hypot(x, y) >= 4 && (x < 0 || std::fabs(y) > 0.5);
                    }))
                    .count(),
                2));
  CHECK(is_safe(print.add_slab(ring(4, 8)).count(), 2));
  // A floor closes it again.
  CHECK(is_safe(print.add_slab(ring(0, 8)).count(), closed));
  CHECK(is_safe(print.add_slab(ring(4, 8)).count(), closed));
}

TEST_CASE("A hole that begins above dark cells is open") {
  RefillDistance print = new_print();
  CHECK(print.add_slab(ring(30, 40)).count() == 0);
  CHECK(is_safe(print.add_slab(ring(4, 8)).count(), 2));
}

TEST_CASE("After a slab that is not known, holes are closed") {
  RefillDistance print = new_print();
  CHECK(print.add_slab(ring(30, 40)).count() == 0);
  print.forget();
  CHECK(is_safe(print.add_slab(ring(4, 8)).count(), 8 / std::numbers::sqrt2));
}

TEST_CASE("Cells of a mask are at most a quarter of a million") {
  CHECK(refill_cells(Pixels{1}, Pixels{1}).side == 4);
  CHECK(refill_cells(Pixels{1920}, Pixels{1080}).side == 4);
  CHECK(refill_cells(Pixels{16384}, Pixels{16384}).side == 33);
}
