// Supports as sections: primitives indexed by height, each cut exactly (see primitive_cut.hpp). No mesh, no
// file; memory in proportion to the primitives: some 40 bytes each beside the primitive itself.
//
// Immutable once built; thread-safe. Deterministic: the same primitives give the same bytes on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/engine/section_source.hpp"
#include "core/support/primitive_cut.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

class SupportStructure final : public SectionSource {
 public:
  // REQUIRES: places and radii within kFarthestMm, radii >= 0, of each frustum one > 0, lower.z <= upper.z,
  // and its ends not one point.
  explicit SupportStructure(std::vector<SupportPrimitive> primitives);
  static constexpr double kFarthestMm = 1e6;

  // A loop for each primitive that is there, at its place in primitives() or not: in an order of its own.
  void section_at(Nanometers height, Contours& contours) const override;
  [[nodiscard]] bool conics_at(Nanometers height, std::vector<ConicCut>& conics) const override;

  [[nodiscard]] std::span<const SupportPrimitive> primitives() const { return primitives_; }

 private:
  // By its bottom: the middle of a range of these is a tree's node, the halves beside it are its branches.
  struct Node {
    HeightReach reach;
    double highest_top;  // of the range whose middle it is
    std::uint32_t primitive;
  };

  double find_tops(std::span<Node> range);
  template <typename Visit>
  void visit_cuts(std::span<const Node> range, double z_mm, Visit& visit) const;

  std::vector<SupportPrimitive> primitives_;
  std::vector<Node> nodes_;
};

}  // namespace contourd
