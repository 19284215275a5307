#include "core/mask/conic_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace contourd {
namespace {

// An ellipse in pixels: at the height Y below its middle a row's centre line is inside from
// lean Y - sqrt(flat - bend Y^2) to lean Y + the same, right of the middle.
struct PixelEllipse {
  PixelPoint middle;
  double lean, flat, bend;
};

// Of half axes a along (c, s) and b across: b^2 u^2 + a^2 v^2 <= a^2 b^2, solved for x, with n = b^2 c^2 +
// a^2 s^2 and by a^2 b^2 (n - Y^2) for what is under the root, divided by n^2.
PixelEllipse ellipse_of(const ConicCut& cut, const PixelMap& map) {
  const double u = (cut.low + cut.high) / 2;
  const PixelPoint middle = map.to_pixels({cut.origin.x + u * cut.along.x, cut.origin.y + u * cut.along.y});
  const PixelPoint end =
      map.to_pixels({cut.origin.x + cut.high * cut.along.x, cut.origin.y + cut.high * cut.along.y});
  const double x = end.x - middle.x, y = end.y - middle.y;  // a c and a s
  const double across = cut.half_width_at(u) * map.pixels_per_mm();
  const double squared = x * x + y * y, b2 = across * across;
  const double c2 = x * x / squared, s2 = y * y / squared;
  const double n = b2 * c2 + squared * s2;
  return {middle, (squared - b2) * (x * y / squared) / n, squared * b2 / n, squared * b2 / (n * n)};
}

// How many of 0.5, 1.5, 2.5... lie before a number, up to a whole limit: those from there on are counted,
// since that takes neither a branch nor a comparison, and so several rows at once.
inline std::int32_t centers_before(double number, double limit) {
  const double beyond = std::min(std::max(limit - number, 0.0), limit);
  return static_cast<std::int32_t>(limit) - static_cast<std::int32_t>(beyond + 0.5);
}

}  // namespace

ConicRows::ConicRows(Pixels width, Pixels height)
    : width_(width.count()),
      height_(height.count()),
      first_(static_cast<std::size_t>(height.count())),
      end_(first_),
      polygons_(width, height) {}

ConicRows::RowRange ConicRows::find_ends(const ConicCut& cut, const PixelMap& map) {
  const PixelEllipse ellipse = ellipse_of(cut, map);
  if (!(ellipse.flat > 0 && ellipse.bend > 0)) return {0, 0};
  const double reach = std::sqrt(ellipse.flat / ellipse.bend);
  const RowRange rows{centers_before(ellipse.middle.y - reach, height_),
                      centers_before(ellipse.middle.y + reach, height_)};
  const double width = width_, down = 0.5 - ellipse.middle.y + rows.first;
  std::int32_t *const first = first_.data(), *const end = end_.data();
  for (std::int32_t i = 0; i < rows.end - rows.first; ++i) {
    const double y = i + down, middle = ellipse.middle.x + ellipse.lean * y;
    const double half = std::sqrt(std::max(0.0, ellipse.flat - ellipse.bend * (y * y)));
    first[i] = centers_before(middle - half, width);
    end[i] = centers_before(middle + half, width);
  }
  return rows;
}

}  // namespace contourd
