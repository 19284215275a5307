#include "core/mask/conic_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace contourd {
namespace {

// Returns the same as centers_before(), for a whole limit. Counts the centres from the number on, which takes
// no comparison, so that several rows are done at once.
[[gnu::always_inline]] inline std::int32_t centers_left_of(double number, double limit) {
  double beyond = limit - number;
  beyond = beyond > 0 ? beyond : 0;
  beyond = beyond < limit ? beyond : limit;
  return static_cast<std::int32_t>(limit) - static_cast<std::int32_t>(beyond + 0.5);
}

// Finds the row ends. The compiler vectorizes this with the instructions of the function that it is inlined
// into.
[[gnu::always_inline]] inline void find_ends(const PixelEllipse& ellipse, std::int32_t top,
                                             std::int32_t width, RowEnds ends) {
  const double limit = width, middle = ellipse.middle.x, down = 0.5 - ellipse.middle.y + top;
  const double lean = ellipse.lean, flat = ellipse.flat, bend = ellipse.bend;
  std::int32_t* __restrict first = ends.first.data();
  std::int32_t* __restrict end = ends.end.data();
  const auto rows = static_cast<std::int32_t>(ends.first.size());
  for (std::int32_t i = 0; i < rows; ++i) {
    const double y = i + down, center = middle + lean * y;
    // At the ellipse's ends rounding may make the value negative.
    const double half = std::sqrt(std::fabs(flat - bend * (y * y)));
    first[i] = centers_left_of(center - half, limit);
    end[i] = centers_left_of(center + half, limit);
  }
}

#if defined(__x86_64__)
// FMA is left out: it rounds once where all others round twice.
[[gnu::target("avx2")]] void find_row_ends_avx2(const PixelEllipse& ellipse, std::int32_t top,
                                                std::int32_t width, RowEnds ends) {
  find_ends(ellipse, top, width, ends);
}
#endif

}  // namespace

ConvexRows::ConvexRows(Pixels width, Pixels height)
    : width_(width.count()), height_(height.count()), ends_(static_cast<std::size_t>(height.count())) {}

ConvexRows::RowRange ConvexRows::find_ends(std::span<const Point> corners, const PixelMap& map) {
  double top = std::numeric_limits<double>::infinity(), bottom = -top;
  for (const Point& corner : corners) {
    const double y = map.to_pixels(corner).y;
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  const RowRange rows{centers_before(top, height_), centers_before(bottom, height_)};
  std::fill(ends_.begin() + rows.first, ends_.begin() + rows.end, Ends{});
  PixelPoint last = map.to_pixels(corners.back());
  for (const Point& corner : corners) {
    const PixelPoint next = map.to_pixels(corner);
    add_side(last, next);
    last = next;
  }
  return rows;
}

// Widens the rows that the side crosses. If rounding makes the polygon slightly non-convex, the outermost
// sides count.
void ConvexRows::add_side(PixelPoint from, PixelPoint to) {
  if (to.y < from.y) std::swap(from, to);
  const std::int32_t end = centers_before(to.y, height_);
  std::int32_t row = centers_before(from.y, height_);
  if (row == end) return;
  const double slope = (to.x - from.x) / (to.y - from.y);
  for (; row < end; ++row) {
    Ends& ends = ends_[static_cast<std::size_t>(row)];
    const double x = from.x + (row + 0.5 - from.y) * slope;
    ends.left = std::min(ends.left, x);
    ends.right = std::max(ends.right, x);
  }
}

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

// Half of the ellipse along its axis is (x, y), S its square, and k S the square of the half across. A place
// (X, Y) from the middle is inside if k (X x + Y y)^2 + (X y - Y x)^2 <= k S^2: with n = k x^2 + y^2 this is
// a quadratic inequality in X, solved for X. No quotient waits for another, since most ellipses have few
// rows.
PixelEllipse pixel_ellipse(const ConicCut& cut, const PixelMap& map) {
  expects(cut.whole, "the cut is a whole ellipse");
  const double u = (cut.low + cut.high) / 2, scale = map.pixels_per_mm();
  const PixelPoint middle = map.to_pixels({cut.origin.x + u * cut.along.x, cut.origin.y + u * cut.along.y});
  const PixelPoint end =
      map.to_pixels({cut.origin.x + cut.high * cut.along.x, cut.origin.y + cut.high * cut.along.y});
  const double x = end.x - middle.x, y = end.y - middle.y, x2 = x * x, y2 = y * y;
  const double squared = x2 + y2, across2 = cut.first.at(u) * cut.second.at(u) * (scale * scale);
  const double sn = across2 * x2 + squared * y2;  // S n
  const double per_s = 1 / squared, per_sn = 1 / sn;
  const double flat = squared * squared * across2 * per_sn;
  return {middle,
          (squared - across2) * (x * y) * per_sn,
          flat,
          flat * squared * per_sn,
          std::sqrt((squared * x2 + across2 * y2) * per_s),
          std::sqrt(sn * per_s)};
}

void find_row_ends_baseline(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends) {
  find_ends(ellipse, top, width, ends);
}

void find_row_ends(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends) {
  expects(ends.first.size() == ends.end.size(), "both ends have the same number of rows");
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  if (has_avx2) return find_row_ends_avx2(ellipse, top, width, ends);
#endif
  find_row_ends_baseline(ellipse, top, width, ends);
}

}  // namespace contourd
