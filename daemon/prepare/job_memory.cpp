#include "daemon/prepare/job_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/contract/expects.hpp"
#include "daemon/config/display_memory.hpp"

namespace contourd {
namespace {

// Bytes per facet while a file is read. If the number of facets is unknown, the buffer doubles whenever it is
// full.
constexpr std::uint64_t kRead = sizeof(Facet), kReadGrowing = 2 * sizeof(Facet);
// Bytes per facet with its entry in the height index.
constexpr std::uint64_t kIndexed = sizeof(Facet) + sizeof(HeightIndex::Candidate);
// Additional bytes per facet while a closed mesh is inspected: 12 for the numbers of its corners and 36 for
// its edges (measured: 96 in total, with 3 to 4 million facets).
constexpr std::uint64_t kInspected = 60;
// Additional bytes per facet, beside both, while a mesh is repaired. Worst case: no two facets share a vertex
// (measured: 313 in total, with a million facets).
constexpr std::uint64_t kRepaired = 222;

// Bytes per facet crossed by a height, in two engines, the print's and its analysis', whose buffers double
// whenever they are full. (Measured in total: 200 if contours close, 1,000 if none does, and 2,400 if
// contours are moved.)
constexpr std::uint64_t kCrossed = 1000, kMoved = 1500;
// Additional bytes per crossed facet for each copy.
constexpr std::uint64_t kPainted = 200;
// Additional bytes per crossed facet if there are several models: the segments of each model's cut are kept
// until the next mask.
constexpr std::uint64_t kKept = 4 * sizeof(Segment);

// Bytes per pixel while a plate is searched for places to support.
constexpr std::uint64_t kSupported = 16;

// Number of parts into which a model's height is divided to count crossed facets.
constexpr std::size_t kParts = 1024;

// Returns the largest number of facets with a point in the same part of the model's height.
std::uint64_t most_crossed(const HeightIndex& model) {
  const Bounds& bounds = model.bounds();
  if (!(bounds.size_z() > 0)) return 0;
  const auto part_of = [&](float z) {
    const double part = (z - bounds.min_z) / bounds.size_z() * kParts;
    return static_cast<std::size_t>(std::clamp(part, 0.0, kParts - 1.0));
  };
  std::array<std::int64_t, kParts + 1> changes{};
  for (const Facet& facet : model.facets()) {
    const auto [low, high] = heights_of(facet);
    ++changes[part_of(low)];
    --changes[part_of(high) + 1];
  }
  std::int64_t crossed = 0, most = 0;
  for (const std::int64_t change : changes)
    most = std::max(most, crossed += change);
  return static_cast<std::uint64_t>(most);
}

// `crossed` returns the number of facets of a model that a height crosses. Models are cut one after another,
// but painted together.
template <typename Crossed>
std::uint64_t memory_for(std::span<const PlateModel> models, bool moved, Crossed crossed) {
  const std::uint64_t kept = models.size() > 1 ? kKept : 0;
  std::uint64_t cut = 0, painted = 0;
  for (const PlateModel& model : models) {
    const std::uint64_t facets = model.outlines ? model.outlines->most_points() : crossed(*model.model);
    cut = std::max(cut, facets * (kCrossed + (moved ? kMoved : 0)));
    painted += facets * (model.copies.size() * kPainted + kept);
  }
  return cut + painted;
}

std::string facets_text(std::span<const FileToRead> files) {
  std::uint64_t facets = 0;
  bool known = true;
  for (const FileToRead& file : files) {
    facets += file.outline.most_facets;
    known = known && file.outline.exact;
  }
  return fmt::format("{} {}{} facets", files.size() > 1 ? "the models hold" : "the model holds",
                     known ? "" : "up to ", facets);
}

}  // namespace

std::uint64_t memory_to_prepare(std::span<const FileToRead> files, const DisplayGeometry& display) {
  std::uint64_t read = 0, most_while_reading = 0, indexed = 0, most_inspected = 0;
  for (const FileToRead& file : files) {
    const std::uint64_t facets = file.outline.most_facets;
    most_while_reading =
        std::max(most_while_reading,
                 read + file.outline.buffered_bytes + facets * (file.outline.exact ? kRead : kReadGrowing));
    read += facets * kRead;
    // The last model of a file takes the facets over; each model before has a copy.
    indexed += facets * kIndexed * file.models;
    most_inspected = std::max(most_inspected, facets * kInspected);
  }
  return memory_for_display(display) + std::max(most_while_reading, indexed + most_inspected);
}

std::uint64_t most_facets_to_read(std::span<const FileToRead> files, std::size_t file,
                                  const DisplayGeometry& display, const MemoryRoom& room) {
  const std::uint64_t needed = memory_to_prepare(files, display);
  expects(needed <= room.bytes, "the files' outlines fit");
  const std::uint64_t bytes_per_facet = kReadGrowing + kIndexed * files[file].models + kInspected;
  return files[file].outline.most_facets + (room.bytes - needed) / bytes_per_facet;
}

std::uint64_t memory_for_display(const DisplayGeometry& display) {
  return memory_for_display(display.width, display.height);
}

std::uint64_t memory_to_repair(std::size_t facets) {
  return facets * kRepaired;
}

std::uint64_t memory_for_supports(const DisplayGeometry& display) {
  return kSupported * static_cast<std::uint64_t>(display.width.count()) *
         static_cast<std::uint64_t>(display.height.count());
}

std::uint64_t memory_for_sections(std::span<const PlateModel> models, bool moved) {
  std::map<const HeightIndex*, std::uint64_t> crossed;  // a plate may hold a model many times
  return memory_for(models, moved, [&](const HeightIndex& model) {
    const auto [at, is_new] = crossed.try_emplace(&model, 0);
    if (is_new) at->second = most_crossed(model);
    return at->second;
  });
}

std::uint64_t most_memory_for_sections(std::span<const PlateModel> models, bool moved) {
  return memory_for(models, moved, [](const HeightIndex& model) { return model.facets().size(); });
}

JobTooLarge::JobTooLarge(std::span<const FileToRead> files, std::string_view addition, std::uint64_t bytes,
                         const MemoryRoom& room)
    : JobRefused(fmt::format("{}{}, for which {} of memory are needed, and there is room for {}: {}",
                             facets_text(files), addition, megabytes(bytes), megabytes(room.bytes),
                             room.reason)),
      fits_alone_(bytes <= room.bytes + room.held) {}

}  // namespace contourd
