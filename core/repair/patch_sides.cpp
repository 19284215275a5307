#include "core/repair/patch_sides.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/repair/boundary_loops.hpp"
#include "core/repair/wall_ends.hpp"
#include "core/repair/winding_probe.hpp"

namespace contourd {
namespace {

// Limit on the faces of a patch that are tested for their position.
constexpr std::uint32_t kSamples = 8;

// A point lies within a solid if this many of its six rays say so. From a point on the solid's surface half
// of the rays leave the solid, and some of the others may miss it by running along the surface.
constexpr std::size_t kMaxRays = 5;

// A wall is one within a solid if this many of ten of its faces are: rays leave through holes, too.
constexpr std::size_t kWithinOfTen = 8;

// A patch that lacks more than this part of its own area is a wall; one that lacks less is a cavity with a
// hole in its side.
constexpr double kOpenPart = 0.25;

// An open patch of at least this part of the total area is a solid that others can lie within.
constexpr double kSolidPart = 0.01;

// Limit on the faces that rays look at in all: a soup of facets must not take seconds. After that, groups
// count as lying within nothing, and no more walls are found.
constexpr std::size_t kMaxRayLooks = 30'000'000;

// Among n facets turned at random, a majority larger than this many times the root of n is hardly chance: a
// box with one of its twelve facets turned has such a majority.
constexpr double kHardlyChance = 2.5;

// If fewer than this part of all facets are known to be turned, a majority of this part of a group's facets
// decides.
constexpr double kFewTurned = 0.25;

constexpr int kMaxWindings = 1000;

class SideFinder {
 public:
  SideFinder(std::span<const Facet> facets, const FacetPatches& mesh, const PatchGroups& groups)
      : facets_(facets), mesh_(mesh), groups_(groups), counted_(mesh.patches.size(), false) {
    sides_.windings = groups.windings;
    sides_.as_filed.assign(mesh.patches.size(), false);
    sides_.inner_walls.assign(mesh.patches.size(), false);
    const Bounds bounds = bounds_of(facets);
    diagonal_mm_ = std::sqrt(bounds.size_x() * bounds.size_x() + bounds.size_y() * bounds.size_y() +
                             bounds.size_z() * bounds.size_z());
  }

  PatchSides find() {
    choose_samples();
    sort_rims();
    std::vector<Outcome> open;
    for (const Group& group : groups_.groups) {
      Outcome outcome = measure(group);
      all_double_sided_ = all_double_sided_ && group.double_sided;
      if (outcome.times > 1 || !outcome.as_filed) {
        open.push_back(outcome);
      } else {
        settle(group, 1, 1, true);
        sure_faces_ += static_cast<double>(outcome.faces);
      }
    }
    std::sort(open.begin(), open.end(), [](const Outcome& a, const Outcome& b) {
      const double volume_a = std::fabs(a.six_volumes), volume_b = std::fabs(b.six_volumes);
      return volume_a != volume_b ? volume_a > volume_b : a.group->first_patch < b.group->first_patch;
    });
    for (const Outcome& outcome : open)
      decide(outcome);
    find_inner_walls();
    return std::move(sides_);
  }

 private:
  using Group = PatchGroups::Group;

  struct Outcome {
    const Group* group;
    int times = 0;  // greatest common divisor of its patches' windings
    double six_volumes = 0;
    bool closed = true;      // six_volumes says which side is outside
    std::int64_t agree = 0;  // facets turned as the windings are, minus those turned the other way
    std::int64_t faces = 0;
    bool sheets = false;
    bool as_filed = true;
  };

  struct Sample {
    std::uint32_t patch, face;
  };

  [[nodiscard]] std::span<const std::uint32_t> members(const Group& group) const {
    return std::span(groups_.members).subspan(group.first_patch, group.patches);
  }

  void choose_samples() {
    std::vector<std::uint32_t> seen(mesh_.patches.size(), 0);
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) {
      const std::uint32_t patch = mesh_.places[f].patch;
      const std::uint32_t apart = (mesh_.patches[patch].faces + kSamples - 1) / kSamples;
      if (seen[patch]++ % apart == 0) samples_.push_back({patch, f});
    }
    std::stable_sort(samples_.begin(), samples_.end(),
                     [](const Sample& a, const Sample& b) { return a.patch < b.patch; });
    first_sample_.assign(mesh_.patches.size() + 1, 0);
    for (const Sample& sample : samples_)
      ++first_sample_[sample.patch + 1];
    std::partial_sum(first_sample_.begin(), first_sample_.end(), first_sample_.begin());
  }

  [[nodiscard]] std::span<const Sample> samples_of(std::uint32_t patch) const {
    return std::span(samples_).subspan(first_sample_[patch], first_sample_[patch + 1] - first_sample_[patch]);
  }

  void sort_rims() {
    boundary_edges_ = mesh_.boundary_edges;
    std::stable_sort(boundary_edges_.begin(), boundary_edges_.end(),
                     [this](const BoundaryEdge& a, const BoundaryEdge& b) {
                       return mesh_.places[a.face].patch < mesh_.places[b.face].patch;
                     });
  }

  struct PatchOrder {
    const std::vector<FacePlace>& places;
    bool operator()(const BoundaryEdge& edge, std::uint32_t patch) const {
      return places[edge.face].patch < patch;
    }
    bool operator()(std::uint32_t patch, const BoundaryEdge& edge) const {
      return patch < places[edge.face].patch;
    }
  };

  // True if a patch is a sheet rather than a shell with holes.
  [[nodiscard]] bool lacks_much(std::uint32_t patch) const {
    if (mesh_.patches[patch].boundary_edges == 0) return false;
    const auto [begin, end] =
        std::equal_range(boundary_edges_.begin(), boundary_edges_.end(), patch, PatchOrder{mesh_.places});
    return area_to_close(facets_, mesh_.faces, {begin, end}) > kOpenPart * mesh_.patches[patch].area;
  }

  [[nodiscard]] Outcome measure(const Group& group) const {
    Outcome outcome{&group};
    double x = 0, y = 0, z = 0;
    for (const std::uint32_t p : members(group)) {
      const Patch& patch = mesh_.patches[p];
      const std::int32_t winding = sides_.windings[p];
      outcome.times = std::gcd(outcome.times, patch.orientable ? winding : 1);
      outcome.six_volumes += winding * patch.six_volumes;
      x += winding * patch.area_x;
      y += winding * patch.area_y;
      z += winding * patch.area_z;
      outcome.agree += winding < 0 ? -patch.net : winding > 0 ? patch.net : 0;
      outcome.faces += patch.faces;
      outcome.sheets = outcome.sheets || lacks_much(p);
      outcome.as_filed =
          outcome.as_filed && (!patch.orientable || (patch.is_even() && patch.least_net == winding));
    }
    outcome.times = std::max(outcome.times, 1);
    outcome.closed = std::fabs(outcome.six_volumes) > std::sqrt(x * x + y * y + z * z) * diagonal_mm_;
    return outcome;
  }

  void settle(const Group& group, std::int32_t factor, std::int32_t divisor, bool as_filed) {
    for (const std::uint32_t p : members(group)) {
      sides_.as_filed[p] = as_filed || !mesh_.patches[p].orientable;
      sides_.windings[p] = sides_.windings[p] / divisor * factor;
      counted_[p] = true;
    }
  }

  void decide(const Outcome& outcome) {
    const Group& group = *outcome.group;
    const bool alone = group.patches == mesh_.patches.size();
    const int around = alone ? 0 : winding_around(group);
    // The two sides of a sheet cancel each other, and so do those of a shell within a solid.
    if (group.double_sided && (outcome.sheets || (around > 0 && !all_double_sided_))) {
      settle(group, 0, 1, true);
      return;
    }
    const int direction = group.inconsistent ? direction_of(outcome, around) : 1;
    // A hole that the file has more than once is a hole in as many solids as there are around it.
    const bool hole = outcome.closed && direction * outcome.six_volumes < 0;
    settle(group, direction * (hole ? std::clamp(around, 1, outcome.times) : 1), outcome.times, false);
  }

  [[nodiscard]] int direction_of(const Outcome& outcome, int around) {
    const int outwards = outcome.six_volumes < 0 ? -1 : 1;
    const int majority = outcome.agree < 0 ? -1 : 1;
    if (!outcome.closed) return majority;
    if (around > 0) return majority_tells(outcome) ? majority : -outwards;
    const auto turned =
        (static_cast<double>(outcome.faces) - outwards * static_cast<double>(outcome.agree)) / 2;
    sure_faces_ += static_cast<double>(outcome.faces);
    turned_faces_ += std::max(turned, 0.0);
    return outwards;
  }

  // True if the majority of the facets is too large for chance, or if it is clear and few of the facets with
  // a known outside are turned.
  [[nodiscard]] bool majority_tells(const Outcome& outcome) const {
    const auto most = std::fabs(static_cast<double>(outcome.agree)),
               faces = static_cast<double>(outcome.faces);
    const bool few_turned = turned_faces_ < kFewTurned * sure_faces_;
    return most > kHardlyChance * std::sqrt(faces) || (few_turned && most > kFewTurned * faces);
  }

  [[nodiscard]] WindingProbe& probe() {
    if (!probe_) probe_.emplace(facets_, mesh_.faces);
    return *probe_;
  }

  [[nodiscard]] WindingProbe::Windings windings_at(std::uint32_t face) {
    const auto& [a, b, c] = facets_[mesh_.faces[face].facet].vertices;
    const SpacePoint middle{(double{a.x} + b.x + c.x) / 3, (double{a.y} + b.y + c.y) / 3,
                            (double{a.z} + b.z + c.z) / 3};
    return probe().windings_around(middle, [this](std::uint32_t f) {
      const FacePlace place = mesh_.places[f];
      if (!counted_[place.patch]) return 0;
      if (sides_.as_filed[place.patch]) return static_cast<int>(mesh_.faces[f].net);
      return place.reversed != 0 ? -sides_.windings[place.patch] : sides_.windings[place.patch];
    });
  }

  // Returns how often the settled patches wind around all of a group's samples, at least.
  [[nodiscard]] int winding_around(const Group& group) {
    int least = kMaxWindings;
    for (const std::uint32_t p : members(group)) {
      for (const Sample& sample : samples_of(p)) {
        if (least <= 0 || probe().looks() > kMaxRayLooks) return 0;
        WindingProbe::Windings windings = windings_at(sample.face);
        std::sort(windings.begin(), windings.end());
        least = std::min(least, windings[windings.size() - kMaxRays]);
      }
    }
    return std::max(least, 0);
  }

  // Finds the sheets that are walls within a solid. A closed patch is a solid, and so is a large one that is
  // nearly closed.
  void find_inner_walls() {
    std::vector<std::uint32_t> sheets;
    bool any_solid = false;
    double area = 0;
    for (const Patch& patch : mesh_.patches)
      area += patch.area;
    for (std::uint32_t p = 0; p < mesh_.patches.size(); ++p) {
      const Patch& patch = mesh_.patches[p];
      const bool sheet = lacks_much(p);
      counted_[p] = !sheet && (patch.boundary_edges == 0 || patch.area >= kSolidPart * area);
      const bool shows = sides_.as_filed[p] ? patch.net != 0 : sides_.windings[p] != 0;
      any_solid = any_solid || (shows && counted_[p]);
      if (shows && sheet) sheets.push_back(p);
    }
    if (!any_solid) return;
    for (const std::uint32_t p : sheets)
      sides_.inner_walls[p] = lies_within(p);
    keep_walls_that_end(facets_, mesh_, sides_.inner_walls);
  }

  // Returns how many rays from a face say that it lies within a solid.
  [[nodiscard]] std::size_t within_rays(std::uint32_t face) {
    const WindingProbe::Windings windings = windings_at(face);
    return static_cast<std::size_t>(std::ranges::count_if(windings, [](int winding) { return winding > 0; }));
  }

  [[nodiscard]] bool lies_within(std::uint32_t patch) {
    std::size_t within = 0;
    const std::span<const Sample> samples = samples_of(patch);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (probe().looks() > kMaxRayLooks) return false;
      within += within_rays(samples[i].face) >= kMaxRays ? 1U : 0U;
      // The remaining samples cannot be enough.
      if ((samples.size() - i - 1 + within) * 10 < samples.size() * kWithinOfTen) return false;
    }
    return true;
  }

  std::span<const Facet> facets_;
  const FacetPatches& mesh_;
  const PatchGroups& groups_;
  double diagonal_mm_ = 0;
  bool all_double_sided_ = true;
  // Faces of groups whose outside is known: all of them, and those that are turned.
  double sure_faces_ = 0, turned_faces_ = 0;
  PatchSides sides_;
  std::vector<bool> counted_;                 // by patch: rays take it into account
  std::vector<Sample> samples_;               // by patch
  std::vector<std::uint32_t> first_sample_;   // by patch
  std::vector<BoundaryEdge> boundary_edges_;  // by patch
  std::optional<WindingProbe> probe_;
};

}  // namespace

PatchSides find_sides(std::span<const Facet> facets, const FacetPatches& mesh, const PatchGroups& groups) {
  return SideFinder(facets, mesh, groups).find();
}

}  // namespace contourd
