#include "core/repair/mesh_soundness.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point_hash.hpp"

namespace contourd {
namespace {

// Facets whose places in the table are fetched into the cache together.
constexpr std::size_t kBatch = 16;

std::uint64_t hash_of(const Vertex& vertex) {
  const auto bits = [](float coordinate) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(coordinate + 0.0F)};  // -0 + 0 is 0
  };
  return mixed(bits(vertex.x) << 32U | bits(vertex.y), bits(vertex.z));
}

struct Marks {
  std::uint64_t key;  // equal for all orders of the facet's vertices
  // twice the signed area that the facet would have if its vertices' hashes were their coordinates in a plane
  std::uint64_t area;
};

// Returns a facet's marks. The sum of all areas is a sum over directed edges whose terms change sign with the
// edge's direction: 0 if the edges cancel, and only by chance otherwise.
Marks marks_of(const Facet& facet) {
  const std::uint64_t a = hash_of(facet.vertices[0]), b = hash_of(facet.vertices[1]),
                      c = hash_of(facet.vertices[2]);
  const auto x = [](std::uint64_t hash) { return hash >> 32U; };
  const auto y = [](std::uint64_t hash) { return hash & 0xFFFFFFFFU; };
  return {a + b + c, (x(b) - x(a)) * (y(c) - y(a)) - (x(c) - x(a)) * (y(b) - y(a))};
}

}  // namespace

bool is_sound(std::span<const Facet> facets) {
  // A hash table of the keys' lower halves, addressed by their upper halves. A place that holds 0 is free.
  std::vector<std::uint32_t> table(std::bit_ceil(facets.size() + facets.size() / 2 + 1));
  const std::size_t last = table.size() - 1;
  std::array<Marks, kBatch> marks;
  std::uint64_t area = 0;
  for (; !facets.empty(); facets = facets.subspan(std::min(facets.size(), kBatch))) {
    const std::size_t count = std::min(facets.size(), kBatch);
    for (std::size_t i = 0; i < count; ++i) {
      marks[i] = marks_of(facets[i]);
      area += marks[i].area;
      __builtin_prefetch(&table[marks[i].key >> 32U & last], 1);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t tag = static_cast<std::uint32_t>(marks[i].key) | 1U;
      std::size_t place = marks[i].key >> 32U & last;
      while (table[place] != 0 && table[place] != tag)
        place = (place + 1) & last;
      if (table[place] == tag) return false;
      table[place] = tag;
    }
  }
  return area == 0;
}

}  // namespace contourd
