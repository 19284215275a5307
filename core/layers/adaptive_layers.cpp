#include "core/layers/adaptive_layers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();
// Half a micrometre, as in kLayerStep.
constexpr double kNegligibleMm = 0.0005;

// Returns |n_z| of the facet's unit normal; 0 for a facet without area, which limits nothing.
double steepness(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const double ux = static_cast<double>(b.x) - a.x, uy = static_cast<double>(b.y) - a.y;
  const double uz = static_cast<double>(b.z) - a.z, vx = static_cast<double>(c.x) - a.x;
  const double vy = static_cast<double>(c.y) - a.y, vz = static_cast<double>(c.z) - a.z;
  const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
  return length > 0 ? std::fabs(nz) / length : 0.0;
}

// Returns a length in whole micrometres, limited to what a print can have: a facet may be 1e38 mm away.
std::int64_t nearest_um(double length_mm) {
  constexpr auto kFarthestUm = static_cast<double>(kThickestLayer / kLayerStep * kMaxLayers);
  return std::llround(std::clamp(length_mm * 1e3, -kFarthestUm, kFarthestUm));
}

std::int64_t thinnest_um(const AdaptiveLayers& layers) {
  return (layers.thinnest.count() + 999) / 1000;
}
std::int64_t thickest_um(const AdaptiveLayers& layers) {
  return std::max(layers.thickest.count() / 1000, thinnest_um(layers));
}

// The limits that the facets ahead of a layer's bottom set, in whole micrometres above it.
class Lookahead {
 public:
  Lookahead(const HeightIndex& model, double bottom_z, const AdaptiveLayers& layers)
      : bottom_z_(bottom_z),
        cusp_um_(static_cast<double>(layers.cusp.count()) / 1e3),
        thinnest_(thinnest_um(layers)),
        thickest_(thickest_um(layers)),
        top_(nearest_um(model.bounds().max_z - bottom_z)) {
    // As far as this layer, with the thinnest one on top of it, could reach.
    const double reach_mm = static_cast<double>(thickest_ + thinnest_) / 1e3;
    const auto for_each_facet_ahead = [&](auto&& look_at) {
      model.for_each_candidate_run(bottom_z, bottom_z + reach_mm,
                                   [&](std::span<const HeightIndex::Candidate> run) {
                                     for (const HeightIndex::Candidate& candidate : run)
                                       look_at(model.facets()[candidate.facet]);
                                   });
    };
    for_each_facet_ahead([&](const Facet& facet) { see(facet); });
    // Only once the layer is known can a face just above it be found.
    const std::int64_t layer = chosen();
    next_face_ = top_ > layer ? top_ : kNoLimit;
    for_each_facet_ahead([&](const Facet& facet) { see_face_above(facet, layer); });
  }

  [[nodiscard]] std::int64_t thickness() const {
    const std::int64_t layer = chosen();
    const bool leaves_too_little = next_face_ < kNoLimit && next_face_ - layer < thinnest_;
    const bool can_leave_enough = leaves_too_little && next_face_ - thinnest_ >= thinnest_;
    return can_leave_enough ? next_face_ - thinnest_ : layer;
  }

 private:
  struct Range {
    double low, high;  // above the layer's bottom
  };

  [[nodiscard]] Range range_of(const Facet& facet) const {
    const auto [low, high] = heights_of(facet);
    return {low - bottom_z_, high - bottom_z_};
  }

  [[nodiscard]] std::int64_t chosen() const {
    return std::max(std::min({limit_, thickest_, std::max(top_, std::int64_t{0})}), thinnest_);
  }

  void see(const Facet& facet) {
    if (limit_ <= thinnest_) return;  // no facet can lower the limit further
    const auto [low, high] = range_of(facet);
    const std::int64_t begins = nearest_um(low);
    if (high <= kNegligibleMm || begins >= limit_) return;
    const double allowed = cusp_um_ / steepness(facet);
    if (allowed >= static_cast<double>(std::min(limit_, thickest_))) return;
    limit_ = std::min(limit_, std::max(begins, static_cast<std::int64_t>(allowed)));
  }

  void see_face_above(const Facet& facet, std::int64_t layer) {
    const auto [low, high] = range_of(facet);
    if (high - low > kNegligibleMm) return;
    const std::int64_t height = nearest_um(low);
    if (height > layer) next_face_ = std::min(next_face_, height);
  }

  double bottom_z_, cusp_um_;
  std::int64_t thinnest_, thickest_, top_;
  std::int64_t limit_ = kNoLimit;
  std::int64_t next_face_ = kNoLimit;
};

}  // namespace

Nanometers next_thickness(const StandingModel& standing, Nanometers bottom, const AdaptiveLayers& layers) {
  expects(layers.are_printable(), "1 um <= thinnest <= thickest <= kThickestLayer, and the cusp is positive");
  const HeightIndex& model = *standing.model;
  const double bottom_z = standing.z_at(bottom).count();
  // This model has ended: the models beside it decide.
  if (!(model.bounds().max_z - bottom_z > kNegligibleMm)) return thickest_um(layers) * kLayerStep;
  return Lookahead(model, bottom_z, layers).thickness() * kLayerStep;
}

}  // namespace contourd
