// Reads models of all known formats; refuses files that cannot be trusted, with one sentence. Thread-safe (no
// shared state).
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

// Returns the extension that makes a file of this name a model, in lower case with its dot; empty if the file
// is no model. The name may be in either case.
[[nodiscard]] std::string_view model_extension(std::string_view file_name);
// Returns the extensions of all formats, each once.
[[nodiscard]] std::vector<std::string_view> model_extensions();

// Reads only the beginning of a file; blocks. Throws like read_model_file() if the beginning shows what is
// wrong.
[[nodiscard]] ModelOutline outline_of_model(const std::filesystem::path& path);
// Outlines a regular file of `bytes` bytes that is open for reading, and leaves it at its beginning; `path`
// is its name in messages.
[[nodiscard]] ModelOutline outline_of_model(std::FILE* file, std::uint64_t bytes,
                                            const std::filesystem::path& path);

// Reads a whole file; blocks. The format is recognised by the file's size and its first bytes, never by its
// name. Throws ModelError for bad data, std::system_error if the file cannot be read or is not a regular
// file.
[[nodiscard]] Model read_model_file(const std::filesystem::path& path);

// Reads a regular file of `bytes` bytes that is open for reading; `path` is its name in messages.
[[nodiscard]] Model read_model_file(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path);

// Reads a model from bytes in memory. Throws ModelError.
[[nodiscard]] Model read_model(std::span<const std::byte> bytes);

}  // namespace contourd
