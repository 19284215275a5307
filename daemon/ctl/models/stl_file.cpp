#include "daemon/ctl/models/stl_file.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace contourd::ctl {
namespace {

void append_word(std::string& bytes, std::uint32_t word) {
  for (unsigned shift = 0; shift < 32; shift += 8)
    bytes += static_cast<char>((word >> shift) & 0xFFU);
}

}  // namespace

std::string binary_stl(std::span<const Facet> facets, const std::string& what) {
  constexpr std::size_t kHeaderBytes = 80, kFacetBytes = 50;
  std::string bytes = what + " by contourctl";
  bytes.reserve(kHeaderBytes + 4 + kFacetBytes * facets.size());
  bytes.resize(kHeaderBytes, ' ');
  append_word(bytes, static_cast<std::uint32_t>(facets.size()));
  for (const Facet& facet : facets) {
    for (int zero = 0; zero < 3; ++zero)
      append_word(bytes, 0);
    for (const Vertex& vertex : facet.vertices) {
      for (const float coordinate : {vertex.x, vertex.y, vertex.z})
        append_word(bytes, std::bit_cast<std::uint32_t>(coordinate));
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace contourd::ctl
