// Recognition of files that a user may take for a model, and that are none that contourd reads.
#pragma once

#include <cstddef>
#include <span>

namespace contourd {

// Throws ModelError if the first bytes of a file are those of another known format, or any text: one sentence
// with the format's name and what the user can do. Returns if they are not. Call it only for
// a file that no reader is likely to read, since the header of a binary STL file may hold any bytes.
void refuse_other_format(std::span<const std::byte> start);

}  // namespace contourd
