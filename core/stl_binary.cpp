#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/stl_formats.hpp"

namespace contourd {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian, and read as it lies");

// Facets are read in chunks of this many: few enough to stay in the cache, many enough to cost no calls.
constexpr std::size_t kChunkFacets = 4096;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kAttributeOffset = 48;

// Some writers take the attribute byte count literally and let that many bytes follow each facet. The facets
// then do not lie 50 bytes apart and would be read as garbage.
bool attributes_follow_facets(std::span<const std::byte> data, std::uint64_t facets) {
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < facets; ++i) {
    if (offset + kBinaryFacetBytes > data.size()) return false;
    std::uint16_t attribute_bytes = 0;
    std::memcpy(&attribute_bytes, data.data() + offset + kAttributeOffset, sizeof attribute_bytes);
    offset += kBinaryFacetBytes + attribute_bytes;
  }
  return offset == data.size();
}

Facet facet_at(const std::byte* record) {
  Facet facet;
  std::memcpy(&facet, record + kNormalBytes, sizeof(Facet));
  return facet;
}

bool is_finite(const Facet& facet) {
  // A sum of finite floats in double stays finite; one NaN or infinity makes it not.
  double sum = 0;
  for (const Vertex& v : facet.vertices) {
    sum += static_cast<double>(v.x) + static_cast<double>(v.y) + static_cast<double>(v.z);
  }
  return std::isfinite(sum);
}

[[noreturn]] void refuse_not_finite(std::uint64_t facet) {
  throw StlError("facet " + std::to_string(facet + 1) + " (byte " +
                 std::to_string(kBinaryHeaderBytes + facet * kBinaryFacetBytes) +
                 ") has a vertex that is not a finite number");
}

void read_facets(const ReadBytes& read, std::uint64_t count, std::vector<Facet>& facets) {
  facets.reserve(count);
  std::vector<std::byte> chunk(std::min<std::uint64_t>(count, kChunkFacets) * kBinaryFacetBytes);
  while (facets.size() < count) {
    const std::size_t n = std::min<std::uint64_t>(count - facets.size(), kChunkFacets);
    read(std::span(chunk).first(n * kBinaryFacetBytes));
    for (std::size_t i = 0; i < n; ++i) {
      const Facet facet = facet_at(chunk.data() + i * kBinaryFacetBytes);
      if (!is_finite(facet)) refuse_not_finite(facets.size());
      facets.push_back(facet);
    }
  }
}

}  // namespace

std::uint32_t claimed_facets(std::span<const std::byte> header) {
  std::uint32_t count = 0;
  std::memcpy(&count, header.data() + 80, sizeof count);
  return count;
}

BinaryExtent binary_extent(std::span<const std::byte> header, std::uint64_t file_bytes) {
  const std::uint64_t claimed = claimed_facets(header), data_bytes = file_bytes - kBinaryHeaderBytes;
  const std::uint64_t whole = data_bytes / kBinaryFacetBytes;
  const std::uint64_t rest = data_bytes % kBinaryFacetBytes;
  if (claimed == whole && rest == 0) return {claimed, {}, true};
  const std::string claim = "the header says " + std::to_string(claimed) + " facets";
  if (claimed > whole || (claimed == 0 && whole > 0)) {
    if (rest != 0 || whole == 0) {
      throw StlError("the file is cut short: " + claim + ", but it ends after " + std::to_string(whole) +
                     " whole facets and " + std::to_string(rest) + " bytes");
    }
    return {whole, {claim + ", the file holds " + std::to_string(whole) + "; all of those are used"}, true};
  }
  const std::uint64_t surplus = data_bytes - claimed * kBinaryFacetBytes;
  return {
      claimed, {claim + ", " + std::to_string(surplus) + " more bytes follow them and are ignored"}, false};
}

StlModel read_binary_stl(std::span<const std::byte> header, std::uint64_t file_bytes, const ReadBytes& read) {
  const std::uint64_t data_bytes = file_bytes - kBinaryHeaderBytes;
  BinaryExtent extent = binary_extent(header, file_bytes);
  StlModel model{StlFormat::Binary, {}, std::move(extent.warnings)};
  if (extent.fills_file) {
    read_facets(read, extent.facets, model.facets);
    return model;
  }
  std::vector<std::byte> data(data_bytes);
  read(data);
  if (extent.facets > 0 && attributes_follow_facets(data, extent.facets)) {
    throw StlError("each facet is followed by as many bytes as its attribute byte count says (byte " +
                   std::to_string(kBinaryHeaderBytes + kAttributeOffset) +
                   "); no such STL is supported, export it without attributes");
  }
  std::span<const std::byte> rest = data;
  const ReadBytes from_memory = [&rest](std::span<std::byte> into) {
    std::memcpy(into.data(), rest.data(), into.size());
    rest = rest.subspan(into.size());
  };
  read_facets(from_memory, extent.facets, model.facets);
  return model;
}

}  // namespace contourd
