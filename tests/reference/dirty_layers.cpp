#include "tests/reference/dirty_layers.hpp"

#include <algorithm>
#include <numeric>

#include "core/engine/contour_engine.hpp"
#include "tests/reference/scan_lines.hpp"

namespace contourd::reference {
namespace {

// Layers with fewer pixels are not compared: rounding to 255 greys shows in them.
constexpr double kMinPixels = 1000;

constexpr int kSide = 640;
constexpr double kPixelsPerMm = 20;

}  // namespace

WorstLayer worst_layer(const models::Facets& clean, const models::Facets& dirty, double wanted,
                       std::span<const double> heights) {
  WorstLayer worst;
  const Bounds bounds = bounds_of(clean);
  const Point center = bounds.center();
  const DisplayGeometry display{Pixels{kSide}, Pixels{kSide}, Micrometers{1000 / kPixelsPerMm}};
  ContourEngine engine(HeightIndex(dirty), {display}, {PixelMap::true_scale(display, center)});
  for (const double part : heights) {
    const double z = bounds.min_z + part * bounds.size_z();
    const auto coverage = coverage_at(clean, z, {kSide, kSide, kPixelsPerMm, center.x, center.y});
    if (std::accumulate(coverage.begin(), coverage.end(), 0.0) < kMinPixels) continue;
    const double overlap = overlap_of(coverage, engine.mask_at_z(Millimeters{z}).pixels());
    worst.overlap = std::min(worst.overlap, overlap);
    worst.told = worst.told && (overlap >= wanted || engine.cracks().has_guesses());
    ++worst.layers;
  }
  return worst;
}

}  // namespace contourd::reference
