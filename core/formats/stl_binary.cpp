#include "core/formats/stl_binary.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace contourd {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian, and copied as it is");

constexpr std::uint64_t kHeaderBytes = 84;  // 80 bytes of anything, then the facet count
constexpr std::size_t kCountOffset = 80;
constexpr std::uint64_t kFacetBytes = 50;  // normal, three vertices (12 floats), attribute byte count
// Facets are read in chunks of this many: few enough to stay in the cache, many enough that the calls cost
// next to nothing.
constexpr std::size_t kChunkFacets = 4096;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kAttributeOffset = 48;

// True if each facet is followed by as many bytes as its attribute byte count says: some writers take the
// count literally. Such facets do not lie 50 bytes apart and would be read as garbage.
bool attributes_follow_facets(std::span<const std::byte> data, std::uint64_t facets) {
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < facets; ++i) {
    if (offset + kFacetBytes > data.size()) return false;
    std::uint16_t attribute_bytes = 0;
    std::memcpy(&attribute_bytes, data.data() + offset + kAttributeOffset, sizeof attribute_bytes);
    offset += kFacetBytes + attribute_bytes;
  }
  return offset == data.size();
}

Facet facet_at(const std::byte* record) {
  Facet facet;
  std::memcpy(&facet, record + kNormalBytes, sizeof(Facet));
  return facet;
}

[[noreturn]] void refuse_not_finite(std::uint64_t facet) {
  throw ModelError("facet " + std::to_string(facet + 1) + " (byte " +
                   std::to_string(kHeaderBytes + facet * kFacetBytes) +
                   ") has a vertex that is not a finite number");
}

// True if all bytes of a facet's record are zero.
bool is_zero(const std::byte* record) {
  // The first two coordinates decide for most facets.
  std::uint64_t first_coordinates = 0;
  std::memcpy(&first_coordinates, record + kNormalBytes, sizeof first_coordinates);
  constexpr std::array<std::byte, kFacetBytes> kZeros{};
  return first_coordinates == 0 && std::memcmp(record, kZeros.data(), kFacetBytes) == 0;
}

// Detects an interrupted copy: its missing part reads as zeros where the file's space had been reserved, or
// where pages were lost.
class InterruptedCopy {
 public:
  void add_zero_facet(std::uint64_t facet) {
    if (facet != end_) begin_ = facet;
    end_ = facet + 1;
    if (end_ - begin_ == kZeroFacets) refuse();
  }
  void end_file(std::uint64_t facets) const {
    if (end_ > begin_ && end_ == facets) refuse();
  }

 private:
  // The number of consecutive zero facets that refuses the file. Fewer of them, unless they end it, are read
  // as facets without area at the origin.
  static constexpr std::uint64_t kZeroFacets = 4;

  [[noreturn]] void refuse() const {
    throw ModelError("the file is not whole: from facet " + std::to_string(begin_ + 1) + " (byte " +
                     std::to_string(kHeaderBytes + begin_ * kFacetBytes) +
                     ") on it consists of zeros, as after an interrupted copy; copy it again");
  }

  std::uint64_t begin_ = 0, end_ = 0;  // numbers of the last run of zero facets
};

void read_facets(const ReadBytes& read, std::uint64_t count, std::vector<Facet>& facets) {
  InterruptedCopy interrupted;
  facets.reserve(count);
  std::vector<std::byte> chunk(std::min<std::uint64_t>(count, kChunkFacets) * kFacetBytes);
  while (facets.size() < count) {
    const std::size_t n = std::min<std::uint64_t>(count - facets.size(), kChunkFacets);
    read(std::span(chunk).first(n * kFacetBytes));
    for (std::size_t i = 0; i < n; ++i) {
      const std::byte* const record = chunk.data() + i * kFacetBytes;
      if (is_zero(record)) [[unlikely]]
        interrupted.add_zero_facet(facets.size());
      const Facet facet = facet_at(record);
      if (!is_finite(facet)) refuse_not_finite(facets.size());
      facets.push_back(facet);
    }
  }
  interrupted.end_file(count);
}

std::uint32_t claimed_facets(std::span<const std::byte> start) {
  std::uint32_t count = 0;
  std::memcpy(&count, start.data() + kCountOffset, sizeof count);
  return count;
}

// The part of a file that is used.
struct Extent {
  std::uint64_t facets;
  std::vector<std::string> warnings;
  bool fills_file;  // if not, the file's other data is looked at too, in memory
  bool lacks_facets = false;
};

// The number of facets that a program writes before it knows it.
constexpr std::uint32_t kUnknownCount = 0xFFFFFFFF;

// Finds the part of a file that is used. Throws ModelError if the file is cut short.
Extent extent_of(const FileStart& start) {
  if (start.bytes.size() < kHeaderBytes) {
    throw ModelError(
        "not an STL file: " + std::to_string(start.file_bytes) +
        " bytes are too few for a binary one (84 at least), and it does not begin with \"solid\"");
  }
  const std::uint64_t claimed = claimed_facets(start.bytes), data_bytes = start.file_bytes - kHeaderBytes;
  const std::uint64_t whole = data_bytes / kFacetBytes;
  const std::uint64_t rest = data_bytes % kFacetBytes;
  if (claimed == whole && rest == 0) return {claimed, {}, true};
  const std::string claim = "the header says " + std::to_string(claimed) + " facets";
  if (claimed > whole || (claimed == 0 && whole > 0)) {
    if (rest != 0 || whole == 0) {
      throw ModelError("the file is cut short: " + claim + ", but it ends after " + std::to_string(whole) +
                       " whole facets and " + std::to_string(rest) + " bytes");
    }
    return {whole,
            {claim + ", but the file holds " + std::to_string(whole) + "; all of them are used"},
            true,
            claimed != 0 && claimed != kUnknownCount};
  }
  const std::uint64_t surplus = data_bytes - claimed * kFacetBytes;
  return {
      claimed, {claim + ", " + std::to_string(surplus) + " more bytes follow them and are ignored"}, false};
}

Likeness binary_likeness(const FileStart& start) {
  const bool exact_size = start.bytes.size() >= kHeaderBytes &&
                          kHeaderBytes + kFacetBytes * claimed_facets(start.bytes) == start.file_bytes;
  return exact_size ? Likeness::Certain : Likeness::Possible;
}

ModelOutline binary_outline(const FileStart& start) {
  const Extent extent = extent_of(start);
  return {.most_facets = extent.facets,
          .exact = true,
          .buffered_bytes = extent.fills_file ? 0 : start.file_bytes - kHeaderBytes};
}

Model read_binary(const FileStart& start, const ReadBytes& read) {
  Extent extent = extent_of(start);
  Model model{{}, std::move(extent.warnings)};
  model.lacks_facets = extent.lacks_facets;
  std::array<std::byte, kHeaderBytes> header{};
  read(header);
  if (extent.fills_file) {
    read_facets(read, extent.facets, model.facets);
    return model;
  }
  std::vector<std::byte> data(start.file_bytes - kHeaderBytes);
  read(data);
  if (extent.facets > 0 && attributes_follow_facets(data, extent.facets)) {
    throw ModelError("each facet is followed by as many bytes as its attribute byte count says (byte " +
                     std::to_string(kHeaderBytes + kAttributeOffset) +
                     "); such STL files are not supported: export the model without attributes");
  }
  std::span<const std::byte> rest = data;
  const ReadBytes from_memory = [&rest](std::span<std::byte> into) {
    std::memcpy(into.data(), rest.data(), into.size());
    rest = rest.subspan(into.size());
  };
  read_facets(from_memory, extent.facets, model.facets);
  return model;
}

}  // namespace

constinit const ModelFormat kBinaryStl{"binary", binary_likeness, binary_outline, read_binary};

}  // namespace contourd
