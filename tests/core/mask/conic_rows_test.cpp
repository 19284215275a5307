#include "core/mask/conic_rows.hpp"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <span>

#include "core/mask/rasterizer.hpp"
#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

using namespace contourd;
using namespace contourd::testing;

namespace {

constexpr DisplayGeometry kDisplay{Pixels{64}, Pixels{48}, Micrometers{1000.0}};

ConicCut ellipse(Point middle, double degrees, double half_length, double half_width) {
  const double turn = degrees * std::numbers::pi / 180, narrow = half_width / half_length;
  return {middle,
          {std::cos(turn), std::sin(turn)},
          -half_length,
          half_length,
          {half_width, narrow},
          {half_width, -narrow},
          true};
}

Mask lit_by(const ConicCut& cut, const DisplayGeometry& display = kDisplay) {
  Rasterizer rasterizer(display.width, display.height, AntiAliasing::On);
  (void)rasterizer.paint();
  rasterizer.light(std::span(&cut, 1), PixelMap::true_scale(display, {0, 0}));
  return rasterizer.mask();
}

// Decides by the ellipse's equation at each centre. Returns nullopt if a centre is too near to the outline to
// decide.
std::optional<bool> holds(const ConicCut& cut, const Point& p) {
  const double x = p.x - cut.origin.x, y = p.y - cut.origin.y;
  const double u = x * cut.along.x + y * cut.along.y, v = y * cut.along.x - x * cut.along.y;
  const double off = v * v - cut.first.at(u) * cut.second.at(u);
  if (std::fabs(off) < 1e-6) return std::nullopt;
  return cut.low < u && u < cut.high && off < 0;
}

}  // namespace

TEST_CASE("A whole cut and one with ends cut off light the pixels whose centres they contain") {
  CHECK(rc::check([] {
    DisplayGeometry display = kDisplay;
    display.mirror_x = draw(0, 1) == 1;
    display.mirror_y = draw(0, 1) == 1;
    ConicCut cut = ellipse({draw_real(-40, 40), draw_real(-30, 30)}, draw_real(0, 360), draw_real(0.3, 30),
                           draw_real(0.3, 30));
    const bool cut_off = draw(0, 2) == 0;
    if (cut_off) {
      cut.low = draw_real(-30, 0);
      cut.low = std::max(cut.low, -cut.high);
      cut.high = std::min(cut.high, draw_real(0.1, 30));
      cut.whole = false;
    }
    const Mask mask = lit_by(cut, display);
    for (std::int32_t y = 0; y < 48; ++y) {
      for (std::int32_t x = 0; x < 64; ++x) {
        const Point center = on_plate(display, {x + 0.5, y + 0.5});
        const auto held = holds(cut, center);
        if (held && !cut_off) RC_ASSERT((mask.row(y)[static_cast<std::size_t>(x)] == 255) == *held);
      }
    }
    if (cut_off) {
      Contours outline;
      append_outline(cut, outline);
      Rasterizer painter(display.width, display.height, AntiAliasing::Off);
      painter.add_loops(outline, PixelMap::true_scale(display, {0, 0}));
      RC_ASSERT(mask == painter.paint());
    }
  }));
}

TEST_CASE("A row ends where its last centre is, and an ellipse beside the display lights nothing") {
  CHECK(lit_by(ellipse({0, 0}, 0, 0.7, 0.4)).lit_pixels() == 0);
  CHECK(lit_by(ellipse({0.5, 0.5}, 0, 0.7, 0.4)).lit_pixels() == 1);
  CHECK(lit_by(ellipse({0.5, 0.5}, 0, 1.1, 0.4)).lit_pixels() == 3);
  CHECK(lit_by(ellipse({0.5, 0.5}, 90, 1.1, 0.4)).lit_pixels() == 3);
  CHECK(lit_by(ellipse({50, 0}, 0, 10, 10)).lit_pixels() == 0);
  CHECK(lit_by(ellipse({0, 40}, 0, 10, 10)).lit_pixels() == 0);
  CHECK(lit_by(ellipse({0, 0}, 0, 1e6, 1e6)).lit_pixels() == 64 * 48);
}
