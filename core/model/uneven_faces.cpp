#include "core/model/uneven_faces.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace contourd {
namespace {

// Each coordinate is rounded by half a step of a float in the file, and again by a turn. All three roundings
// in the file add to a turned height, so that the heights of a face spread over three steps at most; one more
// is for what the exporting program has lost.
constexpr double kSteps = 4;
constexpr double kStep = 0x1p-23;
// Half the thinnest layer: where the numbers are coarser, far from the origin, a level facet may be meant.
constexpr double kMostRoundingMm = 0.0005;
// A facet is level if its slope is below this one; a wall may be as low as the rounding, too.
constexpr double kLevelSlope = 0.01;

// True if a facet slopes so little that it belongs to a flat face.
bool is_level(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
  const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
  const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  return nx * nx + ny * ny < kLevelSlope * kLevelSlope * nz * nz;
}

double farthest(double min, double max) {
  return std::max(std::fabs(min), std::fabs(max));
}

}  // namespace

UnevenFaces::Collector::Collector(const Bounds& bounds)
    : rounding_mm_(static_cast<float>(
          std::min(kMostRoundingMm,
                   kSteps * kStep *
                       std::hypot(farthest(bounds.min_x, bounds.max_x), farthest(bounds.min_y, bounds.max_y),
                                  farthest(bounds.min_z, bounds.max_z))))),
      last_{std::numeric_limits<float>::quiet_NaN(), 0} {}

void UnevenFaces::Collector::add_level(const Facet& facet, HeightRange heights) {
  if (heights.low != heights.high && !is_level(facet)) return;
  levels_.push_back(heights);
  last_ = heights;
}

UnevenFaces UnevenFaces::Collector::take() {
  std::ranges::sort(levels_, {}, [](const HeightRange& level) { return std::pair(level.low, level.high); });
  UnevenFaces uneven;
  for (std::size_t i = 0; i < levels_.size();) {
    HeightRange face = levels_[i];
    for (++i; i < levels_.size() && levels_[i].low - face.low <= rounding_mm_; ++i)
      face.high = std::max(face.high, levels_[i].high);
    if (face.low < face.high) uneven.faces_.push_back(face);
  }
  levels_ = {};
  return uneven;
}

double UnevenFaces::moved(double z) const {
  // The last face that begins at z or below.
  const auto above = std::ranges::upper_bound(faces_, z, {}, &HeightRange::low);
  return above == faces_.begin() ? z : std::max(z, double{std::prev(above)->high});
}

}  // namespace contourd
