#include "core/contour/outline_stack.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr double kNanometersPerMm = 1e6;

std::int32_t stored(double mm) {
  return static_cast<std::int32_t>(std::lround(mm * kNanometersPerMm));
}

double mm_of(std::int32_t nm) {
  return nm / kNanometersPerMm;
}

}  // namespace

OutlineStack::OutlineStack(Nanometers thickness) : thickness_(thickness) {
  expects(thickness > Nanometers{}, "a layer has a thickness");
}

void OutlineStack::add(const Contours& outlines) {
  expects(std::ranges::all_of(outlines.points,
                              [](const Point& point) {
                                return std::fabs(point.x) <= kFarthest.count() &&
                                       std::fabs(point.y) <= kFarthest.count();
                              }),
          "outlines are near the plate");
  const std::size_t first_point = points_.size(), first_loop = loop_sizes_.size();
  for (const ContourLoop& loop : outlines.loops) {
    for (const Point& point : outlines.points_of(loop))
      points_.push_back({stored(point.x), stored(point.y)});
    loop_sizes_.push_back(loop.point_count);
  }
  const Layer added{first_point, points_.size(), first_loop, loop_sizes_.size()};
  if (repeats_last(added)) {
    points_.resize(first_point);
    loop_sizes_.resize(first_loop);
    layers_.push_back(Layer(layers_.back()));
    return;
  }
  layers_.push_back(added);
  most_points_ = std::max(most_points_, added.end_point - added.first_point);
  for (std::size_t at = added.first_point; at < added.end_point; ++at)
    widen(points_[at]);
}

bool OutlineStack::repeats_last(const Layer& added) const {
  if (layers_.empty()) return false;
  const auto part = [](const auto& all, std::size_t first, std::size_t end) {
    return std::span(all).subspan(first, end - first);
  };
  const Layer& last = layers_.back();
  return std::ranges::equal(part(loop_sizes_, last.first_loop, last.end_loop),
                            part(loop_sizes_, added.first_loop, added.end_loop)) &&
         std::ranges::equal(part(points_, last.first_point, last.end_point),
                            part(points_, added.first_point, added.end_point));
}

void OutlineStack::widen(const StoredPoint& point) {
  const Point at{mm_of(point.x_nm), mm_of(point.y_nm)};
  if (!box_) box_ = Box{at, at};
  box_->low = {std::min(box_->low.x, at.x), std::min(box_->low.y, at.y)};
  box_->high = {std::max(box_->high.x, at.x), std::max(box_->high.y, at.y)};
}

std::size_t OutlineStack::bytes() const {
  return points_.capacity() * sizeof points_[0] + loop_sizes_.capacity() * sizeof loop_sizes_[0] +
         layers_.capacity() * sizeof layers_[0];
}

const OutlineStack::Layer* OutlineStack::layer_at(Nanometers height) const {
  if (height < Nanometers{}) return nullptr;
  const auto number = static_cast<std::size_t>(height / thickness_);
  return number < layers_.size() ? &layers_[number] : nullptr;
}

std::size_t OutlineStack::points_at(Nanometers height) const {
  const Layer* const layer = layer_at(height);
  return layer == nullptr ? 0 : layer->end_point - layer->first_point;
}

void OutlineStack::section_at(Nanometers height, Contours& contours) const {
  contours.points.clear();
  contours.loops.clear();
  contours.cracks = {};
  contours.repaired_loops = 0;
  const Layer* const layer = layer_at(height);
  if (layer == nullptr) return;
  for (std::size_t at = layer->first_point; at < layer->end_point; ++at)
    contours.points.push_back({mm_of(points_[at].x_nm), mm_of(points_[at].y_nm)});
  std::uint32_t first = 0;
  for (std::size_t loop = layer->first_loop; loop < layer->end_loop; ++loop) {
    contours.loops.push_back({first, loop_sizes_[loop]});
    first += loop_sizes_[loop];
  }
}

}  // namespace contourd
