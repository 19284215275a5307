// An index of facets by height: finds those that a horizontal plane crosses. This is step 1 of the thesis's
// algorithm 1, "L <- Facet intersected by z_slice", without its scan of all facets.
//
// The model's height H is cut into 2^k cells on each level k. A facet lies on the deepest level whose cells
// are at least as high as the facet, in the cell that holds its lowest vertex. A plane in cell c of a level
// can then only cross facets of cells c-1 and c of that level: on average 2.7 candidates for each facet that
// it crosses, and two short contiguous runs a level. The runs hold the facets' numbers and heights; the
// facets themselves keep their order.
//
// Immutable once built: any number of threads may query it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/geometry/facet.hpp"
#include "core/model/uneven_faces.hpp"
#include "core/repair/mesh_repair.hpp"

namespace contourd {

// The warning for an inside-out model.
inline constexpr std::string_view kTurnedOutwardsWarning =
    "the model is inside out: its facets were turned outwards";

class HeightIndex {
 public:
  HeightIndex() = default;

  // Indexes the facets. If they enclose a negative volume (an inside-out model), all are turned; where they
  // disagree with each other, they are repaired (see repair_mesh()). Extra memory: 12 bytes a facet, 16 while
  // building, 60 while repairing. REQUIRES: finite coordinates, fewer than 2^30 facets.
  explicit HeightIndex(std::vector<Facet> facets);

  // Returns all facets that were kept, including flat ones, in the order given.
  [[nodiscard]] std::span<const Facet> facets() const { return facets_; }
  [[nodiscard]] const Bounds& bounds() const { return bounds_; }
  // True if the model was inside out, so that its facets were turned: the volume that they enclose is
  // negative even when their gaps are taken into account.
  [[nodiscard]] bool turned_outwards() const { return turned_outwards_; }
  // Returns the repairs that were made where facets disagreed with each other.
  [[nodiscard]] const MeshRepairs& repairs() const { return repairs_; }
  // Returns the height at which to cut instead of z (millimetres, model coordinates), so that no uneven flat
  // face is cut into scraps: z itself, or at most a micrometre above it.
  [[nodiscard]] double cut_at(double z) const { return uneven_faces_.cut_at(z); }
  // Returns the lowest height from which on all sections are empty.
  [[nodiscard]] double end_z() const { return uneven_faces_.below(bounds_.max_z); }

  // A facet's number in facets(), and the heights of its lowest and highest vertex.
  struct Candidate {
    float low, high;
    std::uint32_t facet;
  };

  // Calls visit(span of candidates) for runs that hold every facet crossed by the plane at z (millimetres,
  // model coordinates), and some that are not crossed. Allocates nothing.
  template <typename Visit>
  void for_each_candidate_run(double z, Visit&& visit) const {
    if (!(z >= bounds_.min_z && z < bounds_.max_z)) return;
    for (const Level& level : levels_) {
      const std::size_t cell = cell_of(z, level);
      const std::size_t first = level.first_cell + (cell > 0 ? cell - 1 : 0);
      const std::uint32_t begin = cell_starts_[first];
      const std::uint32_t end = cell_starts_[level.first_cell + cell + 1];
      if (begin != end) visit(std::span<const Candidate>(candidates_).subspan(begin, end - begin));
    }
  }

  // Calls visit(span of candidates) for runs that hold every facet with a point from `low` to `high`,
  // including flat ones, and some without such a point. REQUIRES: low <= high.
  template <typename Visit>
  void for_each_candidate_run(double low, double high, Visit&& visit) const {
    expects(low <= high, "the range begins at or below its end");
    if (!(high >= bounds_.min_z && low <= bounds_.max_z)) return;
    if (levels_.empty() && !candidates_.empty()) visit(std::span<const Candidate>(candidates_));
    for (const Level& level : levels_) {
      // The lowest vertices of these facets lie less than a cell below the range, or in it.
      const std::size_t lowest = cell_of(std::max(low, bounds_.min_z), level);
      const std::size_t first = level.first_cell + (lowest > 0 ? lowest - 1 : 0);
      const std::size_t last = level.first_cell + cell_of(std::min(high, bounds_.max_z), level);
      const std::uint32_t begin = cell_starts_[first];
      const std::uint32_t end = cell_starts_[last + 1];
      if (begin != end) visit(std::span<const Candidate>(candidates_).subspan(begin, end - begin));
    }
  }

 private:
  struct Level {
    std::size_t first_cell;  // in cell_starts_
    std::size_t cells;
    double cells_per_mm;
  };

  [[nodiscard]] std::size_t cell_of(double z, const Level& level) const {
    const auto cell = static_cast<std::size_t>((z - bounds_.min_z) * level.cells_per_mm);
    return cell < level.cells ? cell : level.cells - 1;
  }
  [[nodiscard]] std::size_t cell_of(float low, float high) const;
  // Returns the deepest level whose cells are higher than a facet that reaches so far.
  [[nodiscard]] const Level& level_of(double reach) const;
  void turn_outwards();
  void make_levels();
  void sort_into_cells();
  void find_uneven_faces();

  std::vector<Facet> facets_;
  Bounds bounds_;
  bool turned_outwards_ = false;
  MeshRepairs repairs_;
  UnevenFaces uneven_faces_;
  std::vector<Level> levels_;               // none for a model without height
  std::vector<Candidate> candidates_;       // cell by cell; all in one run for a model without height
  std::vector<std::uint32_t> cell_starts_;  // candidates_ offsets, one more than there are cells
};

}  // namespace contourd
