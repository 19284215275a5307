// Models in AMF, an XML format (ISO/ASTM 52915). Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <string>

#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/byte_stream.hpp"

namespace contourd {

// True if a file with these first bytes is an AMF model.
[[nodiscard]] bool is_amf(const FileStart& start);
// Returns upper limits for an AMF model of this size, without copies of its objects.
[[nodiscard]] ModelOutline amf_outline(std::uint64_t bytes);
// Reads a model in millimetres; blocks. Constellations place objects; an object that none places stands where
// it is drawn. Curved triangles are read as flat ones, with a warning. `name` begins messages. Throws
// ModelError, also if the model has more than `most_facets` facets with all its copies, and what the stream
// throws.
[[nodiscard]] Model read_amf(ByteStream& stream, const std::string& name, std::uint64_t most_facets);

}  // namespace contourd
