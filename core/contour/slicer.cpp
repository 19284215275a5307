#include "core/contour/slicer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/geometry/double_pair.hpp"
#include "core/geometry/point_hash.hpp"

namespace contourd {
namespace {

// The vertices that a crossed facet's segment comes from: it runs from the side (from_lower, from_upper) to
// the side (to_lower, to_upper).
struct CrossedSides {
  std::uint8_t from_lower, from_upper, to_lower, to_upper;
};

// Crossed sides by the vertices above the plane: bit i for vertex i. Wound counter-clockwise seen from
// outside, a facet is entered where its outline comes down through the plane and left where it goes up, so
// that the inside is on the left.
constexpr std::array<CrossedSides, 8> kCrossedSides{{
    {},            // none above
    {1, 0, 2, 0},  // 0
    {2, 1, 0, 1},  // 1
    {2, 1, 2, 0},  // 0 and 1
    {0, 2, 1, 2},  // 2
    {1, 0, 1, 2},  // 0 and 2
    {0, 2, 0, 1},  // 1 and 2
    {},            // all
}};

// Facets are processed this many at a time: first the crossed ones are found, then their segments.
constexpr std::size_t kBatch = 256;

// Facets are fetched into the cache this many turns ahead.
constexpr std::size_t kAhead = 12;

// Returns the largest float that is not above z: a float is above this one exactly if it is above z.
float rounded_down(double z) {
  const auto nearest = static_cast<float>(z);
  return nearest > z ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}

// Returns the number of crossed candidates and fills in their facets. Without branches: which are crossed
// cannot be predicted, and a wrong guess costs more than the whole test.
std::size_t find_crossed(std::span<const HeightIndex::Candidate> candidates, float z,
                         std::span<std::uint32_t, kBatch> crossed) {
  std::size_t count = 0;
  for (const HeightIndex::Candidate& candidate : candidates) {
    crossed[count] = candidate.facet;
    count += static_cast<std::size_t>(candidate.low <= z) & static_cast<std::size_t>(candidate.high > z);
  }
  return count;
}

// Fetches a facet into the cache; it may lie on two cache lines.
void fetch(const Facet& facet) {
  const auto* const bytes = reinterpret_cast<const char*>(&facet);
  __builtin_prefetch(bytes);
  __builtin_prefetch(bytes + sizeof facet - 1);
}

// Returns a facet's segment. Both ends are as by intersect_side(), bit for bit, except that a coordinate of
// -0 becomes 0: points that are equal have equal bits. `float_z` is z rounded down. REQUIRES: the facet is
// crossed.
Segment segment_of(const Facet& facet, double z, float float_z) {
  expects_costly([&] { return heights_of(facet).low <= float_z && float_z < heights_of(facet).high; },
                 "the plane crosses the facet");
  const auto& v = facet.vertices;
  const unsigned above =
      unsigned{v[0].z > float_z} | unsigned{v[1].z > float_z} << 1U | unsigned{v[2].z > float_z} << 2U;
  const CrossedSides sides = kCrossedSides[above];
  const Vertex& from_lower = v[sides.from_lower];
  const Vertex& from_upper = v[sides.from_upper];
  const Vertex& to_lower = v[sides.to_lower];
  const Vertex& to_upper = v[sides.to_upper];
  const DoublePair lower_z = pair_of(from_lower.z, to_lower.z);
  const DoublePair s = (z - lower_z) / (pair_of(from_upper.z, to_upper.z) - lower_z);
  const auto at = [](const Vertex& lower, const Vertex& upper, double part) {
    const DoublePair lower_xy = xy_of(lower);
    return point_of(lower_xy + part * (xy_of(upper) - lower_xy) + 0.0);
  };
  return {at(from_lower, from_upper, s[0]), at(to_lower, to_upper, s[1])};
}

}  // namespace

void slice_at(const HeightIndex& model, Millimeters z, Section& section) {
  const double z_mm = model.cut_at(z.count());
  section.segments.clear();
  section.intersecting_facets = 0;
  // Sum over all segments of hash(from) - hash(to): zero when starts and ends are the same multiset of
  // points. A chance zero of an unbalanced section has odds of 2^-64.
  std::uint64_t imbalance = 0;
  std::array<std::uint32_t, kBatch> crossed;
  const float float_z = rounded_down(z_mm);
  const std::span<const Facet> facets = model.facets();
  model.for_each_candidate_run(z_mm, [&](std::span<const HeightIndex::Candidate> run) {
    for (; !run.empty(); run = run.subspan(std::min(run.size(), kBatch))) {
      const std::size_t count = find_crossed(run.first(std::min(run.size(), kBatch)), float_z, crossed);
      section.intersecting_facets += static_cast<std::uint32_t>(count);
      for (std::size_t i = 0; i < count; ++i) {
        // Facets are in the file's order, far from each other.
        if (i + kAhead < count) fetch(facets[crossed[i + kAhead]]);
        const Segment segment = segment_of(facets[crossed[i]], z_mm, float_z);
        const std::uint64_t from = hash_of_bits(segment.from), to = hash_of_bits(segment.to);
        if (from == to) [[unlikely]] {
          if (segment.from == segment.to) continue;
        }
        imbalance += from - to;
        section.segments.push_back(segment);
      }
    }
  });
  section.balanced = imbalance == 0;
}

}  // namespace contourd
