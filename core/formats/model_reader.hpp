// Reads models of every format that is known; refuses what cannot be trusted, in one sentence. Thread-safe
// (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string_view>

#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"

namespace contourd {

// Whether a file of that name is taken for a model: by its extension, in either case.
[[nodiscard]] bool has_model_extension(std::string_view file_name);

// Looks at the beginning alone; blocks. Throws as read_model_file() does, as far as it shows there what is
// wrong.
[[nodiscard]] ModelOutline outline_of_model(const std::filesystem::path& path);
// The same for a regular file of that many bytes that is open for reading, which is at its beginning again
// then; `path` is its name in messages.
[[nodiscard]] ModelOutline outline_of_model(std::FILE* file, std::uint64_t bytes,
                                            const std::filesystem::path& path);

// Reads a whole file; blocks. The format is told by the file's size and its first bytes, never by its name.
// Throws ModelError for bad data, std::system_error when the file cannot be read or is not a regular file.
[[nodiscard]] Model read_model_file(const std::filesystem::path& path);

// The same for a regular file of that many bytes that is open for reading; `path` is its name in messages.
[[nodiscard]] Model read_model_file(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path);

// The same for bytes already in memory. Throws ModelError.
[[nodiscard]] Model read_model(std::span<const std::byte> bytes);

}  // namespace contourd
