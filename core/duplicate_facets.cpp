#include "core/duplicate_facets.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/point_hash.hpp"

namespace contourd {
namespace {

// So many facets' places in the table are fetched into the cache together.
constexpr std::size_t kBatch = 16;

std::uint64_t hash_of(const Vertex& vertex) {
  const auto bits = [](float coordinate) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(coordinate + 0.0F)};  // -0 + 0 is 0
  };
  return mixed(bits(vertex.x) << 32U | bits(vertex.y), bits(vertex.z));
}

// The same wherever the facet begins, another for the same vertices turned the other way round.
std::uint64_t hash_of(const Facet& facet) {
  const std::uint64_t a = hash_of(facet.vertices[0]), b = hash_of(facet.vertices[1]),
                      c = hash_of(facet.vertices[2]);
  return mixed(a, b) + mixed(b, c) + mixed(c, a);
}

void unite(std::vector<HeightRange>& ranges) {
  std::sort(ranges.begin(), ranges.end(),
            [](const HeightRange& a, const HeightRange& b) { return a.low < b.low; });
  std::size_t left = 0;
  for (const HeightRange& range : ranges) {
    if (left > 0 && range.low <= ranges[left - 1].high)
      ranges[left - 1].high = std::max(ranges[left - 1].high, range.high);
    else
      ranges[left++] = range;
  }
  ranges.resize(left);
}

}  // namespace

std::vector<HeightRange> heights_of_duplicates(std::span<const Facet> facets) {
  std::vector<HeightRange> ranges;
  // A table of hashes' lower halves, found by their upper ones. A place that holds 0 is free.
  std::vector<std::uint32_t> table(std::bit_ceil(facets.size() + facets.size() / 2 + 1));
  const std::size_t last = table.size() - 1;
  std::array<std::uint64_t, kBatch> hashes;
  for (; !facets.empty(); facets = facets.subspan(std::min(facets.size(), kBatch))) {
    const std::size_t count = std::min(facets.size(), kBatch);
    for (std::size_t i = 0; i < count; ++i) {
      hashes[i] = hash_of(facets[i]);
      __builtin_prefetch(&table[hashes[i] >> 32U & last], 1);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t tag = static_cast<std::uint32_t>(hashes[i]) | 1U;
      std::size_t place = hashes[i] >> 32U & last;
      while (table[place] != 0 && table[place] != tag)
        place = (place + 1) & last;
      if (table[place] == tag) ranges.push_back(heights_of(facets[i]));
      table[place] = tag;
    }
  }
  unite(ranges);
  return ranges;
}

}  // namespace contourd
