// How much memory a job takes, estimated before any of it is taken. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/engine/contour_engine.hpp"
#include "core/formats/model_reader.hpp"
#include "daemon/prepare/plate_arrangement.hpp"
#include "daemon/system/memory_room.hpp"

namespace contourd {

struct FileToRead {
  ModelOutline outline;
  std::size_t models = 1;  // that are made of it: turned or scaled in so many ways
};

// To read these, index and inspect them and to have masks of an ordinary model, at the most: one whose facets
// agree with each other, few of them at one height.
[[nodiscard]] std::uint64_t memory_to_prepare(std::span<const FileToRead> files,
                                              const DisplayGeometry& display);

// The same for a model without facets.
[[nodiscard]] std::uint64_t memory_for_display(const DisplayGeometry& display);

// What a model adds whose mesh is to be repaired.
[[nodiscard]] std::uint64_t memory_to_repair(std::size_t facets);

// What finding the supports of a plate adds to the sections of its models.
[[nodiscard]] std::uint64_t memory_for_supports(const DisplayGeometry& display);

// What the sections of these add: masks and their analysis, at the height that crosses most facets; `moved`
// where their contours are (see Compensation).
[[nodiscard]] std::uint64_t memory_for_sections(std::span<const PlateModel> models, bool moved);
// The same if a height crossed all of them; nothing is looked at for that.
[[nodiscard]] std::uint64_t most_memory_for_sections(std::span<const PlateModel> models, bool moved);

// There is not that much room.
class JobTooLarge : public JobRefused {
 public:
  // `addition` is said of the models beside how many facets they hold.
  JobTooLarge(std::span<const FileToRead> files, std::string_view addition, std::uint64_t bytes,
              const MemoryRoom& room);

  // Whether there would be room if this process held nothing else.
  [[nodiscard]] bool fits_alone() const { return fits_alone_; }

 private:
  bool fits_alone_;
};

}  // namespace contourd
