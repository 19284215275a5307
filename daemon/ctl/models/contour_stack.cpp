#include "daemon/ctl/models/contour_stack.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace contourd::ctl {
namespace {

constexpr double kWordMax = 65535;
// Tolerance relative to the size: finer than a screen can show.
constexpr double kFinest = 1.0 / 2500;

double distance_to_line(const Point& p, const Point& a, const Point& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double length = std::hypot(dx, dy);
  if (length == 0) return std::hypot(p.x - a.x, p.y - a.y);
  return std::fabs((p.x - a.x) * dy - (p.y - a.y) * dx) / length;
}

// Returns the bounds of all copies on the plate.
Bounds plate_bounds(const ContourEngine& engine, const DisplayGeometry& display) {
  Bounds all;
  for (const PlateModel& each : engine.models()) {
    const Bounds& b = each.model->bounds();
    for (const PixelMap& copy : each.copies) {
      for (const Point corner : {Point{b.min_x, b.min_y}, Point{b.max_x, b.max_y}}) {
        const Point p = on_plate(display, copy.to_pixels(corner));
        all.min_x = std::min(all.min_x, p.x);
        all.max_x = std::max(all.max_x, p.x);
        all.min_y = std::min(all.min_y, p.y);
        all.max_y = std::max(all.max_y, p.y);
      }
    }
  }
  return all;
}

class Stacker {
 public:
  Stacker(const StackedPrint& print, const DisplayGeometry& display, std::span<const Nanometers> middles)
      : engine_(print.engine), supports_(print.supports), display_(display) {
    Bounds bounds = plate_bounds(engine_, display);
    // Only the layers of the feet are examined: feet are the widest part of supports.
    for (std::size_t i = 0; supports_ != nullptr && i < middles.size(); i += kFeetSteps)
      include_supports(middles[i], bounds);
    if (bounds.empty()) return;
    stack_.min_x_mm = bounds.min_x;
    stack_.min_y_mm = bounds.min_y;
    stack_.size_mm = std::max(bounds.size_x(), bounds.size_y());
  }

  void add_layer(std::int32_t layer, Nanometers height) {
    stack_.layers.push_back(layer);
    for (const PlateModel& each : engine_.models()) {
      slice_at(*each.model, each.z_at(height), section_);
      linker_.link(section_.segments, engine_.join_tolerance(), contours_);
      for (const ContourLoop& loop : contours_.loops) {
        const std::vector<Point> points = simplified(contours_.points_of(loop), stack_.size_mm * kFinest);
        if (points.size() < 3) continue;
        for (const PixelMap& copy : each.copies)
          add_loop(points, copy, stack_.words);
      }
    }
    if (supports_ != nullptr) add_supports(height);
  }

  [[nodiscard]] std::size_t points() const { return points_; }
  [[nodiscard]] ContourStack take() { return std::move(stack_); }

 private:
  // Every n-th layer is examined for the bounds of supports.
  static constexpr std::size_t kFeetSteps = 8;

  void include_supports(Nanometers height, Bounds& bounds) {
    supports_->section_at(height, contours_);
    for (const Point& p : contours_.points) {
      bounds.min_x = std::min(bounds.min_x, p.x);
      bounds.max_x = std::max(bounds.max_x, p.x);
      bounds.min_y = std::min(bounds.min_y, p.y);
      bounds.max_y = std::max(bounds.max_y, p.y);
    }
  }

  void add_supports(Nanometers height) {
    supports_->section_at(height, contours_);
    const PixelMap plate = PixelMap::true_scale(display_, {0, 0});
    for (const ContourLoop& loop : contours_.loops) {
      const std::vector<Point> points = simplified(contours_.points_of(loop), stack_.size_mm * kFinest);
      if (points.size() >= 3) add_loop(points, plate, stack_.support_words);
    }
  }

  void add_loop(std::span<const Point> points, const PixelMap& copy, std::vector<std::uint8_t>& words) {
    add_word(static_cast<std::uint32_t>(stack_.layers.size() - 1), words);
    add_word(static_cast<std::uint32_t>(points.size()) & 0xFFFFU, words);
    add_word(static_cast<std::uint32_t>(points.size()) >> 16U, words);
    for (const Point& point : points) {
      const Point p = on_plate(display_, copy.to_pixels(point));
      add_word(quantized(p.x - stack_.min_x_mm), words);
      add_word(quantized(p.y - stack_.min_y_mm), words);
    }
    points_ += points.size();
  }

  [[nodiscard]] std::uint32_t quantized(double mm) const {
    const double part = stack_.size_mm > 0 ? mm / stack_.size_mm : 0;
    return static_cast<std::uint32_t>(std::lround(std::clamp(part, 0.0, 1.0) * kWordMax));
  }

  static void add_word(std::uint32_t word, std::vector<std::uint8_t>& words) {
    words.push_back(static_cast<std::uint8_t>(word & 0xFFU));
    words.push_back(static_cast<std::uint8_t>(word >> 8U));
  }

  const ContourEngine& engine_;
  const SectionSource* supports_;
  const DisplayGeometry& display_;
  Section section_;
  ContourLinker linker_;
  Contours contours_;
  ContourStack stack_;
  std::size_t points_ = 0;
};

}  // namespace

std::vector<Point> simplified(std::span<const Point> polygon, double tolerance) {
  if (polygon.size() < 4) return {polygon.begin(), polygon.end()};
  // The closed polygon starts and ends at the same point: the leftmost (and lowest) point, which is a corner
  // and always remains.
  const std::size_t n = polygon.size();
  const auto corner = std::ranges::min_element(
      polygon, [](const Point& a, const Point& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  const auto start = static_cast<std::size_t>(corner - polygon.begin());
  const auto at = [&](std::size_t i) { return polygon[(start + i) % n]; };
  std::vector<bool> kept(n + 1, false);
  kept[0] = kept[n] = true;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, n}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    std::size_t farthest = first;
    double distance = tolerance;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double d = distance_to_line(at(i), at(first), at(last));
      if (d <= distance) continue;
      distance = d;
      farthest = i;
    }
    if (farthest == first) continue;
    kept[farthest] = true;
    open.emplace_back(first, farthest);
    open.emplace_back(farthest, last);
  }
  std::vector<Point> points;
  for (std::size_t i = 0; i < n; ++i) {
    if (kept[i]) points.push_back(at(i));
  }
  return points;
}

ContourStack stack_contours(const StackedPrint& print, const DisplayGeometry& display,
                            std::span<const Nanometers> middles, const StackLimits& limits) {
  const auto count = static_cast<std::int32_t>(middles.size());
  std::int32_t step = std::max(1, (count + limits.most_layers - 1) / limits.most_layers);
  while (true) {
    Stacker stacker(print, display, middles);
    for (std::int32_t layer = 0; layer < count && stacker.points() <= limits.most_points; layer += step)
      stacker.add_layer(layer, middles[static_cast<std::size_t>(layer)]);
    // Too many points: halve the number of layers, down to a single layer.
    if (stacker.points() <= limits.most_points || step >= count) return stacker.take();
    step *= 2;
  }
}

}  // namespace contourd::ctl
