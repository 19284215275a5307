#include "core/support/support_lift.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/filled_area.hpp"
#include "core/contour/slicer.hpp"
#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr int kCuts = 32;
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

// A model's lowest face, as a section shows it.
struct Face {
  double mm2;
  bool has_feet;  // at least three separate ones
  std::vector<Point> hull;
};

// True if at least three outlines, none of them a point, lie beside each other.
bool has_feet(const Contours& section) {
  constexpr std::size_t kFewestFeet = 3;
  constexpr double kSmallestFootMm = 0.25;
  std::vector<std::pair<Point, Point>> feet;  // corners of their bounds
  for (const ContourLoop& loop : section.loops) {
    const auto points = section.points_of(loop);
    const auto [left, right] = std::ranges::minmax(points, {}, &Point::x);
    const auto [front, back] = std::ranges::minmax(points, {}, &Point::y);
    const Point low{left.x, front.y}, high{right.x, back.y};
    if (std::max(high.x - low.x, high.y - low.y) < kSmallestFootMm) continue;
    if (std::ranges::all_of(feet, [&](const auto& foot) {
          return low.x > foot.second.x || high.x < foot.first.x || low.y > foot.second.y ||
                 high.y < foot.first.y;
        }))
      feet.emplace_back(low, high);
    if (feet.size() == kFewestFeet) return true;
  }
  return false;
}

// Returns the section `at_mm` above the model's lowest point if it covers at least `least` of the section
// three times as high.
std::optional<Face> face_at(double at_mm, double least, Sections& sections, const Bounds& bounds) {
  const double above_mm2 = filled_area_mm2(sections.at(Millimeters{bounds.min_z + 3 * at_mm}));
  const Contours& section = sections.at(Millimeters{bounds.min_z + at_mm});
  const double mm2 = filled_area_mm2(section);
  if (!(mm2 > 0) || mm2 < least * above_mm2) return std::nullopt;
  return Face{mm2, has_feet(section), convex_hull(section.points)};
}

// Returns the model's lowest face in its first layer, and at the height of the gap that bottom exposures
// close; each only if it is flat there.
std::vector<Face> faces_of(const SupportSettings& settings, Nanometers layer, Sections& sections,
                           const Bounds& bounds) {
  constexpr double kLeastOfFirstLayer = 0.5, kLeastInGap = 0.8;
  const double low_mm = std::min(to_millimeters(layer).count(), bounds.size_z() / 4) / 2;
  const double gap_mm = std::min(settings.closed_gap.count(), bounds.size_z() / 4);
  std::vector<Face> faces;
  if (auto face = face_at(low_mm, kLeastOfFirstLayer, sections, bounds)) faces.push_back(std::move(*face));
  if (auto face = face_at(gap_mm, kLeastInGap, sections, bounds)) faces.push_back(std::move(*face));
  return faces;
}

bool stands(const HeightIndex& model, const SupportSettings& settings, Nanometers layer) {
  const Bounds& bounds = model.bounds();
  Sections sections(model);
  const std::vector<Face> faces = faces_of(settings, layer, sections, bounds);
  if (faces.empty()) return false;
  Mass mass;
  double widest_mm2 = 0;
  for (int cut = 0; cut < kCuts; ++cut) {
    const Contours& contours = sections.at(Millimeters{bounds.min_z + (cut + 0.5) / kCuts * bounds.size_z()});
    widest_mm2 = std::max(widest_mm2, filled_area_mm2(contours));
    mass.add(contours, bounds.center());
  }
  return mass.area_mm2 > 0 && std::ranges::any_of(faces, [&](const Face& face) {
           return (face.has_feet || kPlateHolds * face.mm2 >= widest_mm2) && holds(face.hull, mass.center());
         });
}

}  // namespace

Nanometers support_lift(const HeightIndex& model, const SupportSettings& settings, Nanometers layer) {
  expects(layer > Nanometers{}, "a layer has a thickness");
  if (model.bounds().empty() || stands(model, settings, layer)) return Nanometers{};
  const Nanometers lift = to_nanometers(settings.lift).value_or(Nanometers{});
  return layer * ((lift + layer - Nanometers{1}) / layer);
}

}  // namespace contourd
