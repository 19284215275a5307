// The side files in which slicers say that a mesh of a 3MF model is no part of it: a modifier, a negative
// volume, or a mesh that enforces or blocks supports. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "daemon/formats/byte_stream.hpp"

namespace contourd {

// A range of an object's triangles, whose last one belongs to it.
struct ThreeMfVolume {
  std::uint32_t first = 0, last = 0;
  std::string kind;  // as people call it: "modifier"
};

struct ThreeMfSideFile {
  // By the object's id.
  std::map<std::uint32_t, std::vector<ThreeMfVolume>> volumes;
  // The kind of a component, by the id of its object and its own object's.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string> components;
};

// Names of the side files in a package, of PrusaSlicer and of Bambu Studio and OrcaSlicer.
inline constexpr const char* kPrusaSideFile = "Metadata/Slic3r_PE_model.config";
inline constexpr const char* kBambuSideFile = "Metadata/model_settings.config";

// Reads one of them; blocks. `name` begins messages. Throws ModelError, and what the stream throws.
[[nodiscard]] ThreeMfSideFile read_threemf_side_file(ByteStream& stream, const std::string& name);

}  // namespace contourd
