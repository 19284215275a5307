#include "core/slicer.hpp"

#include <bit>

namespace contourd {
namespace {

// The finalizer of SplitMix64 (Steele, Lea, Flood 2014): every input bit moves about half of the output's.
std::uint64_t mix(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9U;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBU;
  return bits ^ (bits >> 31);
}

}  // namespace

std::uint64_t hash_of(const Point& point) {
  const std::uint64_t x = std::bit_cast<std::uint64_t>(point.x + 0.0);  // -0 + 0 is 0
  const std::uint64_t y = std::bit_cast<std::uint64_t>(point.y + 0.0);
  return mix(x ^ mix(y + 0x9E3779B97F4A7C15U));
}

void slice_at(const HeightIndex& model, double z, Section& section) {
  section.segments.clear();
  section.intersecting_facets = 0;
  // Sum over all segments of hash(from) - hash(to): zero when starts and ends are the same multiset of
  // points. A chance zero of an unbalanced section has odds of 2^-64.
  std::uint64_t imbalance = 0;
  model.for_each_candidate_run(z, [&](std::span<const Facet> run) {
    for (const Facet& facet : run) {
      const auto& v = facet.vertices;
      const bool above[3] = {v[0].z > z, v[1].z > z, v[2].z > z};
      const int count = above[0] + above[1] + above[2];
      if (count == 0 || count == 3) continue;
      ++section.intersecting_facets;
      // The vertex that is alone on its side of the plane, and the other two in the facet's winding.
      const bool lone_above = count == 1;
      const std::size_t lone = above[0] == lone_above ? 0U : above[1] == lone_above ? 1U : 2U;
      const Vertex& a = v[lone];
      const Vertex& b = v[(lone + 1) % 3];
      const Vertex& c = v[(lone + 2) % 3];
      const Segment segment = lone_above ? Segment{intersect_side(b, a, z), intersect_side(c, a, z)}
                                         : Segment{intersect_side(a, c, z), intersect_side(a, b, z)};
      if (segment.from == segment.to) continue;
      imbalance += hash_of(segment.from) - hash_of(segment.to);
      section.segments.push_back(segment);
    }
  });
  section.balanced = imbalance == 0;
}

}  // namespace contourd
