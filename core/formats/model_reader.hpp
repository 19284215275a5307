// Reads models of all known formats; refuses files that cannot be trusted, with one sentence. Thread-safe (no
// shared state).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"

namespace contourd {

// True if these are the first bytes of a file that one of the core's formats is at least likely to read.
[[nodiscard]] bool is_recognised(const FileStart& start);
// Outlines a model by its first bytes. Throws ModelError if they show what is wrong.
[[nodiscard]] ModelOutline outline_of_model(const FileStart& start);
// Reads a model; blocks as `read` does. The format is recognised by the size and the first bytes, never by a
// name. Throws ModelError for bad data, and what `read` throws.
[[nodiscard]] Model read_model(const FileStart& start, const ReadBytes& read);

// Reads a whole file; blocks. Throws ModelError for bad data, std::system_error if the file cannot be read or
// is not a regular file.
[[nodiscard]] Model read_model_file(const std::filesystem::path& path);

// Reads a model from bytes in memory. Throws ModelError.
[[nodiscard]] Model read_model(std::span<const std::byte> bytes);

}  // namespace contourd
