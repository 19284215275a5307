#include "core/mask/conic_rows.hpp"

#include "tests/catch.hpp"
#include "tests/core/mask/conic_fixture.hpp"

namespace {

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
    const DisplayGeometry display = draw_mirrored_display();
    ConicCut cut = draw_ellipse();
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
      RC_ASSERT(mask == painted_by_centers(outline, display));
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
