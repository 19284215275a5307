#include "core/mask/conic_rows.hpp"

#include <cstddef>

#include "core/mask/pixel_centers.hpp"

namespace contourd {

ConicRows::ConicRows(Pixels width, Pixels height)
    : width_(width.count()),
      height_(height.count()),
      first_(static_cast<std::size_t>(height.count())),
      end_(first_),
      polygons_(width, height) {}

EllipseRows ConicRows::ellipse(const ConicCut& cut, const PixelMap& map) {
  const PixelEllipse ellipse = pixel_ellipse(cut, map);
  if (!(ellipse.flat > 0 && ellipse.bend > 0)) return {};
  const auto [x, y] = ellipse.middle;
  const std::int32_t top = centers_before(y - ellipse.reach_y, height_);
  const auto rows = static_cast<std::size_t>(centers_before(y + ellipse.reach_y, height_) - top);
  const RowEnds ends{std::span(first_).first(rows), std::span(end_).first(rows)};
  find_row_ends(ellipse, top, width_, ends);
  // One more pixel, since the reach is rounded.
  return {top, ends.first, ends.end, centers_before(x - ellipse.reach_x - 1, width_),
          centers_before(x + ellipse.reach_x + 1, width_)};
}

}  // namespace contourd
