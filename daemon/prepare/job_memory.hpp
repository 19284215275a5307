// Estimates of the memory that a job takes, made before it takes any. All in bytes. Thread-safe (no shared
// state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/engine/contour_engine.hpp"
#include "core/formats/model_format.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/system/memory_room.hpp"

namespace contourd {

// A model file and the number of models made from it.
struct FileToRead {
  ModelOutline outline;
  std::size_t models = 1;  // made from the file: each way to turn or scale it is one
};

// Returns an upper bound for reading, indexing and inspecting these files and computing masks of ordinary
// models: their facets agree with each other, and few of them are at any one height.
[[nodiscard]] std::uint64_t memory_to_prepare(std::span<const FileToRead> files,
                                              const DisplayGeometry& display);

// Returns how many facets one of the files may hold, so that memory_to_prepare() fits into the room.
// REQUIRES: it fits with the files' outlines.
[[nodiscard]] std::uint64_t most_facets_to_read(std::span<const FileToRead> files, std::size_t file,
                                                const DisplayGeometry& display, const MemoryRoom& room);

// Returns the part of memory_to_prepare() that does not depend on the facets.
[[nodiscard]] std::uint64_t memory_for_display(const DisplayGeometry& display);

// Returns the additional memory to repair the mesh of a model.
[[nodiscard]] std::uint64_t memory_to_repair(std::size_t facets);

// Returns the additional memory, beside that for sections, to find the places to support on a plate.
[[nodiscard]] std::uint64_t memory_for_supports(const DisplayGeometry& display);

// Returns the additional memory for sections of these models, for the print and its analysis, at the height
// that crosses the most facets. `moved`: the contours are moved (see Compensation).
[[nodiscard]] std::uint64_t memory_for_sections(std::span<const PlateModel> models, bool moved);
// Returns an upper bound of memory_for_sections(), as if one height crossed all facets. Does not read the
// facets.
[[nodiscard]] std::uint64_t most_memory_for_sections(std::span<const PlateModel> models, bool moved);

// Thrown if a job needs more memory than is available.
class JobTooLarge : public JobRefused {
 public:
  // `addition` follows the number of facets in the message: ", many of them at one height".
  JobTooLarge(std::span<const FileToRead> files, std::string_view addition, std::uint64_t bytes,
              const MemoryRoom& room);

  // True if the job would fit if this process held nothing else.
  [[nodiscard]] bool fits_alone() const { return fits_alone_; }

 private:
  bool fits_alone_;
};

}  // namespace contourd
