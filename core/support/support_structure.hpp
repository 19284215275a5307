// Supports as a source of sections: primitives indexed by height, each cut exactly (see cut_at()).
// No mesh, no file; about 40 bytes of memory for each primitive besides the primitive itself.
//
// Immutable once built; thread-safe. Deterministic: the same primitives give the same bytes on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/engine/section_source.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

class SupportStructure final : public SectionSource {
 public:
  // REQUIRES: accepts() each primitive.
  explicit SupportStructure(std::vector<SupportPrimitive> primitives);
  // True if places and radii are within kFarthestMm, radii >= 0, and for a frustum one radius > 0, lower.z <=
  // upper.z, and its ends distinct.
  [[nodiscard]] static bool accepts(const SupportPrimitive& primitive);
  static constexpr double kFarthestMm = 1e6;

  // Appends a loop for each primitive that the plane cuts. The order of the loops is fixed, but not the order
  // of primitives().
  void section_at(Nanometers height, Contours& contours) const override;
  [[nodiscard]] bool conics_at(Nanometers height, std::vector<ConicCut>& conics) const override;

  [[nodiscard]] std::span<const SupportPrimitive> primitives() const { return primitives_; }

 private:
  // The nodes are sorted by their bottom. The middle of each range is the root of a tree whose branches are
  // the halves to its left and right.
  struct Node {
    HeightReach reach;
    double highest_top;  // highest top within the range of which this node is the middle
    std::uint32_t primitive;
  };

  double find_tops(std::span<Node> range);
  template <typename Visit>
  void visit_cuts(std::span<const Node> range, double z_mm, Visit& visit) const;

  std::vector<SupportPrimitive> primitives_;
  std::vector<Node> nodes_;
};

}  // namespace contourd
