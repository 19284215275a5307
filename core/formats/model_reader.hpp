// Reads models of every format that is known; refuses what cannot be trusted, in one sentence. Thread-safe
// (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"

namespace contourd {

// The extension by which a file of that name is taken for a model, in lower case, with its dot; empty when it
// is not. It may be spelled in either case.
[[nodiscard]] std::string_view model_extension(std::string_view file_name);
// All formats', each once.
[[nodiscard]] std::vector<std::string_view> model_extensions();

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
