// The two STL formats' readers, behind stl_reader.hpp. Not for use outside core.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/stl_reader.hpp"

namespace contourd {

inline constexpr std::uint64_t kBinaryHeaderBytes = 84;  // 80 bytes of anything, then the facet count
inline constexpr std::uint64_t kBinaryFacetBytes =
    50;  // normal, three vertices (12 floats), attribute byte count

// Fills the span from the file, in order, completely; throws std::system_error when it cannot.
using ReadBytes = std::function<void(std::span<std::byte>)>;

// The part of a binary file that is used. Throws StlError when it is cut short.
struct BinaryExtent {
  std::uint64_t facets;
  std::vector<std::string> warnings;
  bool fills_file;  // else what surrounds the facets is looked at too, in memory
};
// REQUIRES: header.size() == kBinaryHeaderBytes.
[[nodiscard]] BinaryExtent binary_extent(std::span<const std::byte> header, std::uint64_t file_bytes);

// Reads a binary file of `file_bytes` bytes, of which `header` has been read already.
// REQUIRES: header.size() == kBinaryHeaderBytes.
[[nodiscard]] StlModel read_binary_stl(std::span<const std::byte> header, std::uint64_t file_bytes,
                                       const ReadBytes& read);

[[nodiscard]] StlModel read_ascii_stl(std::string_view text);

// Words that a facet cannot do without, and white space behind each.
inline constexpr std::string_view kShortestAsciiFacet =
    "facet outer loop vertex 0 0 0 vertex 0 0 0 vertex 0 0 0 endloop endfacet ";

// The facet count a binary header claims.
[[nodiscard]] std::uint32_t claimed_facets(std::span<const std::byte> header);

}  // namespace contourd
