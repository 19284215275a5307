// The content of one model file in a 3MF package, as it is written there. Thread-safe (no shared state).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/model/length_unit.hpp"
#include "daemon/formats/byte_stream.hpp"
#include "daemon/formats/threemf_transform.hpp"

namespace contourd {

// A component of an object, or an item of the build.
struct ThreeMfReference {
  std::string path;  // the model file, as a name in the archive; empty: the same file
  std::uint32_t object = 0;
  ThreeMfTransform transform;
};

struct ThreeMfObject {
  std::uint32_t id = 0;
  std::string kind;  // as people call it: "modifier", if Cura says that the object is no part of the model
  std::string type;  // "model", "solidsupport", "support", "surface" or "other"
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // numbers of vertices, all of them valid
  std::vector<ThreeMfReference> components;
  bool has_geometry = false;  // a mesh or components, even if a side file leaves all of it out
};

struct ThreeMfPart {
  LengthUnit unit = LengthUnit::Millimeter;
  std::vector<ThreeMfObject> objects;  // in the file's order: a component of the same file comes before
  std::vector<ThreeMfReference> items;
  std::size_t not_printable = 0;                           // items that the program's user excluded
  std::unordered_map<std::uint32_t, std::size_t> numbers;  // indices of the objects, by their ids
};

enum class ThreeMfRoot { Yes, No };  // only the root model may name other model files

// Reads a model file; blocks. `name` begins messages. Throws ModelError, and what the stream throws.
[[nodiscard]] ThreeMfPart read_threemf_part(ByteStream& stream, const std::string& name, ThreeMfRoot root);

}  // namespace contourd
