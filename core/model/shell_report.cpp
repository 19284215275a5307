#include "core/model/shell_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/repair/facet_patches.hpp"
#include "core/repair/winding_probe.hpp"

namespace contourd {
namespace {

// Limits on the faces of a shell that are sampled: at first, and to confirm that a shell is within a solid,
// because a part of the shell that sticks out may have few of its faces.
constexpr std::uint32_t kSamples = 16, kConfirmingSamples = 512;

// Limit on the faces that rays look at in all: about a tenth of a second.
constexpr std::size_t kMaxRayLooks = 10'000'000;

// The distance of a sample from its face, as a part of the model's diagonal: far more than the rounding of
// floats, far less than a wall.
constexpr double kOffset = 1e-5;

// The distance at which the space in front of a face is looked at again, as a part of the model's diagonal: a
// shell that reaches so far into another one does not just touch it.
constexpr double kWellInside = 1e-3;

// A shell faces inwards outside of solids, or is a cavity that a solid fills, if this part of its samples
// says so: surfaces may touch, and a pillar may stand in a cavity.
constexpr double kFewSamples = 0.2;

// Counts of a shell's samples by the winding number in front of the face, on the side it faces.
struct SampleCounts {
  int all = 0, negative = 0, zero = 0, positive = 0;
  int well_negative = 0;  // well inside of another shell that faces inwards
};

// True if the number of a shell's face is one of the about `most` that are sampled: spread evenly, but in no
// step with the order in which a shell's faces repeat.
bool is_sampled(std::uint32_t number, std::uint32_t faces, std::uint32_t most) {
  constexpr double kGoldenRatio = 0.6180339887498949;
  return faces <= most || std::fmod(number * kGoldenRatio, 1.0) * faces < most;
}

class ShellInspector {
 public:
  ShellInspector(std::span<const Facet> facets, const FacetPatches& mesh)
      : facets_(facets), mesh_(mesh), probe_(facets, mesh.faces), counts_(mesh.patches.size()) {
    const Bounds bounds = bounds_of(facets);
    diagonal_mm_ = std::hypot(bounds.size_x(), bounds.size_y(), bounds.size_z());
  }

  ShellReport inspect() {
    count_samples(kSamples, [](std::uint32_t) { return true; });
    count_samples(kConfirmingSamples, [this](std::uint32_t p) { return may_be_within(p); });
    bool overlap = false;
    for (std::uint32_t p = 0; p < counts_.size(); ++p) {
      const SampleCounts& counts = counts_[p];
      if (counts.all == 0) continue;
      if (is_inside_out(p)) {
        note(p, report_.inside_out, report_.inside_out_at);
      } else if (volume_sign(p) < 0 && counts.positive > kFewSamples * counts.all) {
        note(p, report_.filled, report_.filled_at);
      } else if (may_be_within(p)) {
        note(p, report_.within, report_.within_at);
      } else {
        overlap = overlap || (counts.positive > 0 && counts.zero > 0);
      }
    }
    if (overlap) report_.within = 0, report_.within_at = {};
    return report_;
  }

 private:
  // Samples about `most` faces of each shell for which wanted(its number) is true.
  template <typename Wanted>
  void count_samples(std::uint32_t most, Wanted&& wanted) {
    std::vector<std::uint32_t> seen(mesh_.patches.size(), 0);
    for (std::uint32_t f = 0; f < mesh_.faces.size() && probe_.looks() < kMaxRayLooks; ++f) {
      const std::uint32_t patch = mesh_.places[f].patch;
      const bool sampled = is_sampled(seen[patch]++, mesh_.patches[patch].faces, most);
      if (!sampled || !mesh_.patches[patch].orientable || mesh_.faces[f].net == 0 || !wanted(patch)) continue;
      sample(f, counts_[patch]);
    }
  }

  // Samples the space in front of a face's middle and near its corners.
  void sample(std::uint32_t face, SampleCounts& counts) {
    for (const auto& weights : {std::array{1.0 / 3, 1.0 / 3, 1.0 / 3}, std::array{0.98, 0.01, 0.01},
                                std::array{0.01, 0.98, 0.01}, std::array{0.01, 0.01, 0.98}}) {
      const std::optional<int> winding = winding_before(face, weights, kOffset);
      if (!winding) continue;
      ++counts.all;
      ++(*winding < 0 ? counts.negative : *winding == 0 ? counts.zero : counts.positive);
      if (*winding < 0 && winding_before(face, weights, kWellInside).value_or(0) < 0) ++counts.well_negative;
    }
  }

  // Returns the winding number in front of a face, at an offset that is a part of the model's diagonal;
  // nullopt if it is not known.
  [[nodiscard]] std::optional<int> winding_before(std::uint32_t face, const std::array<double, 3>& weights,
                                                  double offset) {
    const std::optional<SpacePoint> point = point_before(face, weights, offset);
    return point ? winding_at(*point) : std::nullopt;
  }

  // Returns a point in front of the face, on the side that its facets face; nullopt if it has no area.
  [[nodiscard]] std::optional<SpacePoint> point_before(std::uint32_t face,
                                                       const std::array<double, 3>& weights,
                                                       double offset) const {
    const auto& [a, b, c] = facets_[mesh_.faces[face].facet].vertices;
    const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
    const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const double length = std::hypot(nx, ny, nz);
    if (!(length > 0)) return std::nullopt;
    const double step = (mesh_.faces[face].net > 0 ? offset : -offset) * diagonal_mm_ / length;
    const auto [wa, wb, wc] = weights;
    return SpacePoint{wa * a.x + wb * b.x + wc * c.x + step * nx, wa * a.y + wb * b.y + wc * c.y + step * ny,
                      wa * a.z + wb * b.z + wc * c.z + step * nz};
  }

  // Returns the winding number at a point; nullopt if rays disagree, because the mesh has gaps there.
  [[nodiscard]] std::optional<int> winding_at(const SpacePoint& point) {
    const WindingProbe::Windings windings =
        probe_.windings_around(point, [this](std::uint32_t f) { return int{mesh_.faces[f].net}; });
    const bool agree =
        std::ranges::all_of(windings, [&](int winding) { return winding == windings.front(); });
    return agree ? std::optional(windings.front()) : std::nullopt;
  }

  // Returns the sign of the volume that a shell's facets enclose; 0 if the shell does not tell.
  [[nodiscard]] int volume_sign(std::uint32_t p) const {
    const Patch& patch = mesh_.patches[p];
    const double uncertainty = std::hypot(patch.area_x, patch.area_y, patch.area_z) * diagonal_mm_;
    if (!(std::fabs(patch.six_volumes) > uncertainty) || patch.net == 0) return 0;
    return (patch.six_volumes > 0) == (patch.net > 0) ? 1 : -1;
  }

  // True if a shell faces outwards within a solid, as far as it has been sampled.
  [[nodiscard]] bool may_be_within(std::uint32_t p) const {
    return counts_[p].all > 0 && counts_[p].positive == counts_[p].all && volume_sign(p) > 0;
  }

  [[nodiscard]] bool is_inside_out(std::uint32_t p) const {
    const SampleCounts& counts = counts_[p];
    const int sign = volume_sign(p);
    if (sign == 0) return counts.negative == counts.all;
    return sign < 0 && (counts.negative > kFewSamples * counts.all || counts.well_negative > 0);
  }

  void note(std::uint32_t patch, std::uint64_t& count, Vertex& at) const {
    if (count++ == 0) at = facets_[mesh_.faces[mesh_.patches[patch].first_face].facet].vertices[0];
  }

  std::span<const Facet> facets_;
  const FacetPatches& mesh_;
  WindingProbe probe_;
  double diagonal_mm_ = 0;
  std::vector<SampleCounts> counts_;  // by patch
  ShellReport report_;
};

}  // namespace

ShellReport inspect_shells(std::span<const Facet> facets) {
  expects(facets.size() < kMaxFacets, "there are fewer than 2^30 facets");
  expects_costly([&] { return std::ranges::all_of(facets, is_finite); }, "all coordinates are finite");
  const FacetPatches mesh = patches_of(facets);
  if (mesh.patches.size() < 2) return {};
  return ShellInspector(facets, mesh).inspect();
}

}  // namespace contourd
