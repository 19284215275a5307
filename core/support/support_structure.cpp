#include "core/support/support_structure.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

bool is_near(double coordinate) {
  return std::fabs(coordinate) <= SupportStructure::kFarthestMm;
}

bool is_near(const PlatePoint& place) {
  return is_near(place.x) && is_near(place.y) && is_near(place.z);
}

bool is_radius(double radius_mm) {
  return 0 <= radius_mm && is_near(radius_mm);
}

bool is_sound(const Ball& ball) {
  return is_near(ball.center) && is_radius(ball.radius_mm);
}

bool is_sound(const Frustum& frustum) {
  const double x = frustum.upper.x - frustum.lower.x, y = frustum.upper.y - frustum.lower.y;
  const double z = frustum.upper.z - frustum.lower.z;
  return is_near(frustum.lower) && is_near(frustum.upper) && is_radius(frustum.lower_radius_mm) &&
         is_radius(frustum.upper_radius_mm) && frustum.lower_radius_mm + frustum.upper_radius_mm > 0 &&
         0 <= z && x * x + y * y + z * z > 0;
}

}  // namespace

bool SupportStructure::accepts(const SupportPrimitive& primitive) {
  return std::visit([](const auto& each) { return is_sound(each); }, primitive);
}

SupportStructure::SupportStructure(std::vector<SupportPrimitive> primitives)
    : primitives_(std::move(primitives)) {
  expects(std::ranges::all_of(primitives_, accepts), "every primitive has a place and a size");
  nodes_.reserve(primitives_.size());
  for (std::size_t i = 0; i < primitives_.size(); ++i)
    nodes_.push_back({reach_of(primitives_[i]), 0, static_cast<std::uint32_t>(i)});
  std::ranges::sort(nodes_, [](const Node& a, const Node& b) {
    return std::pair(a.reach.bottom, a.primitive) < std::pair(b.reach.bottom, b.primitive);
  });
  find_tops(nodes_);
}

double SupportStructure::find_tops(std::span<Node> range) {
  if (range.empty()) return -std::numeric_limits<double>::infinity();
  const std::size_t middle = range.size() / 2;
  Node& node = range[middle];
  node.highest_top =
      std::max({find_tops(range.first(middle)), node.reach.top, find_tops(range.subspan(middle + 1))});
  return node.highest_top;
}

template <typename Visit>
void SupportStructure::visit_cuts(std::span<const Node> range, double z_mm, Visit& visit) const {
  if (range.empty()) return;
  const std::size_t middle = range.size() / 2;
  const Node& node = range[middle];
  if (node.highest_top <= z_mm) return;
  visit_cuts(range.first(middle), z_mm, visit);
  if (node.reach.bottom > z_mm) return;
  if (z_mm < node.reach.top) {
    if (const auto cut = cut_at(primitives_[node.primitive], z_mm)) visit(*cut);
  }
  visit_cuts(range.subspan(middle + 1), z_mm, visit);
}

void SupportStructure::section_at(Nanometers height, Contours& contours) const {
  contours.points.clear();
  contours.loops.clear();
  contours.cracks = LayerCracks{};
  contours.repaired_loops = 0;
  const auto add = [&contours](const ConicCut& cut) { append_outline(cut, contours); };
  visit_cuts(nodes_, to_millimeters(height).count(), add);
}

bool SupportStructure::conics_at(Nanometers height, std::vector<ConicCut>& conics) const {
  conics.clear();
  const auto add = [&conics](const ConicCut& cut) { conics.push_back(cut); };
  visit_cuts(nodes_, to_millimeters(height).count(), add);
  return true;
}

}  // namespace contourd
