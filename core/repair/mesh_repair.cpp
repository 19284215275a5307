#include "core/repair/mesh_repair.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/repair/facet_patches.hpp"
#include "core/repair/patch_balance.hpp"
#include "core/repair/patch_sides.hpp"

namespace contourd {
namespace {

// The decision about the facets of a face.
struct Fate {
  int wanted = 0;  // number of facets to keep; negative: turned against the first
  bool as_filed = false;
  bool inner_wall = false;
};

class Repair {
 public:
  Repair(std::vector<Facet>& facets, const FacetPatches& mesh, const PatchSides& sides)
      : facets_(facets), mesh_(mesh), sides_(sides) {}

  MeshRepairs run() {
    keep_wanted();
    turn_missing();
    drop();
    return repairs_;
  }

 private:
  [[nodiscard]] Fate fate_of(std::uint32_t face) const {
    const FacePlace place = mesh_.places[face];
    const std::int32_t winding = sides_.windings[place.patch];
    // The two sides of a wall between two solids cancel each other.
    const bool cancels = winding == 0 && mesh_.faces[face].net == 0;
    return {place.reversed != 0 ? -winding : winding, sides_.as_filed[place.patch] || cancels,
            sides_.inner_walls[place.patch]};
  }

  // Returns 1 if the facet is turned like its face's first one, otherwise -1.
  [[nodiscard]] int direction_of(std::size_t facet, const Face& face) const {
    const auto& first = facets_[face.facet].vertices;
    const auto& other = facets_[facet].vertices;
    const auto at = static_cast<std::size_t>(std::find(other.begin(), other.end(), first[0]) - other.begin());
    return other[(at + 1) % 3] == first[1] ? 1 : -1;
  }

  void keep_wanted() {
    kept_.assign(facets_.size(), true);
    lacking_.assign(mesh_.faces.size(), 0);
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f)
      lacking_[f] = std::abs(fate_of(f).wanted);
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      const std::uint32_t f = mesh_.face_of[i];
      if (f == FacetPatches::kNone) continue;
      const Fate fate = fate_of(f);
      if (fate.inner_wall) {
        kept_[i] = false;
        ++repairs_.inner_walls;
      } else if (!fate.as_filed) {
        kept_[i] = lacking_[f] > 0 && direction_of(i, mesh_.faces[f]) * fate.wanted > 0;
        lacking_[f] -= kept_[i] ? 1 : 0;
      }
    }
  }

  // Turns facets round where too few of a face are turned as wanted, and counts the facets that are dropped.
  void turn_missing() {
    to_turn_.assign(facets_.size(), false);
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      const std::uint32_t f = mesh_.face_of[i];
      if (kept_[i] || f == FacetPatches::kNone) continue;
      const Fate fate = fate_of(f);
      if (fate.inner_wall) continue;
      const int agrees = direction_of(i, mesh_.faces[f]) * fate.wanted;
      if (lacking_[f] > 0) {
        --lacking_[f];
        kept_[i] = to_turn_[i] = true;
        ++repairs_.turned;
      } else {
        ++(agrees > 0 ? repairs_.doubled : agrees < 0 ? repairs_.reversed : repairs_.inner_walls);
      }
    }
  }

  void drop() {
    std::size_t left = 0;
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      if (!kept_[i]) continue;
      facets_[left] = facets_[i];
      if (to_turn_[i]) std::swap(facets_[left].vertices[1], facets_[left].vertices[2]);
      ++left;
    }
    facets_.resize(left);
  }

  std::vector<Facet>& facets_;
  const FacetPatches& mesh_;
  const PatchSides& sides_;
  MeshRepairs repairs_;
  std::vector<std::int32_t> lacking_;  // by face: number of facets still wanted
  std::vector<bool> kept_, to_turn_;   // by facet
};

}  // namespace

MeshRepairs repair_mesh(std::vector<Facet>& facets) {
  expects(facets.size() < kMaxFacets, "there are fewer than 2^30 facets");
  expects_costly([&] { return std::ranges::all_of(facets, is_finite); }, "all coordinates are finite");
  const FacetPatches mesh = patches_of(facets);
  const PatchGroups groups = balance_patches(mesh);
  const PatchSides sides = find_sides(facets, mesh, groups);
  return Repair(facets, mesh, sides).run();
}

}  // namespace contourd
