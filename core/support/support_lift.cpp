#include "core/support/support_lift.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/filled_area.hpp"
#include "core/contour/slicer.hpp"
#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr int kCuts = 32;
constexpr double kLeastFlatPart = 0.5;
constexpr double kPlateHolds = 10;
// The ends of a section's segments are joined if they are closer than this.
constexpr Millimeters kTolerance{0.05};

class Sections {
 public:
  explicit Sections(const HeightIndex& model) : model_(model) {}

  // Valid until the next call.
  const Contours& at(Millimeters z) {
    slice_at(model_, z, section_);
    linker_.link(section_.segments, kTolerance, contours_);
    return contours_;
  }

 private:
  const HeightIndex& model_;
  Section section_;
  ContourLinker linker_;
  Contours contours_;
};

// Returns twice the area of the triangle, positive if it runs counter-clockwise.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Returns the convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Point> convex_hull(std::vector<Point> points) {
  std::ranges::sort(points,
                    [](const Point& a, const Point& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<Point> hull;
  const auto walk = [&hull](auto from, auto to) {
    const std::size_t start = hull.size();
    for (; from != to; ++from) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), *from) <= 0)
        hull.pop_back();
      hull.push_back(*from);
    }
    if (!hull.empty()) hull.pop_back();
  };
  walk(points.begin(), points.end());
  walk(points.rbegin(), points.rend());
  return hull;
}

bool holds(const std::vector<Point>& hull, const Point& point) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (turn(hull[i], hull[(i + 1) % hull.size()], point) < 0) return false;
  }
  return hull.size() > 2;
}

// Sums over evenly spaced sections; the spacing is left out, since it cancels in center().
struct Mass {
  double area_mm2 = 0, x = 0, y = 0;

  void add(const Contours& contours, const Point& origin) {
    for (const ContourLoop& loop : contours.loops) {
      Point last = contours.points_of(loop).back();
      for (const Point& point : contours.points_of(loop)) {
        const double twice = turn(origin, last, point);
        area_mm2 += twice / 2;
        x += twice / 6 * (last.x + point.x + origin.x);
        y += twice / 6 * (last.y + point.y + origin.y);
        last = point;
      }
    }
  }
  [[nodiscard]] Point center() const { return {x / area_mm2, y / area_mm2}; }
};

bool stands(const HeightIndex& model, Nanometers layer) {
  const Bounds& bounds = model.bounds();
  const double layer_mm = std::min(to_millimeters(layer).count(), bounds.size_z() / 4);
  Sections sections(model);
  const double second_mm2 = filled_area_mm2(sections.at(Millimeters{bounds.min_z + 1.5 * layer_mm}));
  const Contours& face = sections.at(Millimeters{bounds.min_z + 0.5 * layer_mm});
  const double face_mm2 = filled_area_mm2(face);
  if (!(face_mm2 > 0) || face_mm2 < kLeastFlatPart * second_mm2) return false;
  const std::vector<Point> hull = convex_hull(face.points);
  Mass mass;
  double widest_mm2 = 0;
  for (int cut = 0; cut < kCuts; ++cut) {
    const Contours& contours = sections.at(Millimeters{bounds.min_z + (cut + 0.5) / kCuts * bounds.size_z()});
    widest_mm2 = std::max(widest_mm2, filled_area_mm2(contours));
    mass.add(contours, bounds.center());
  }
  if (!(mass.area_mm2 > 0)) return false;
  return kPlateHolds * face_mm2 >= widest_mm2 && holds(hull, mass.center());
}

}  // namespace

Nanometers support_lift(const HeightIndex& model, const SupportSettings& settings, Nanometers layer) {
  expects(layer > Nanometers{}, "a layer has a thickness");
  if (model.bounds().empty() || stands(model, layer)) return Nanometers{};
  const Nanometers lift = to_nanometers(settings.lift).value_or(Nanometers{});
  return layer * ((lift + layer - Nanometers{1}) / layer);
}

}  // namespace contourd
