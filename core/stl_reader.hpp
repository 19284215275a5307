// Reads STL models, binary and ASCII, whatever wrote them; refuses what cannot be trusted, in one sentence.
// Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/facet.hpp"

namespace contourd {

enum class StlFormat { Binary, Ascii };
[[nodiscard]] std::string_view name_of(StlFormat format);

struct StlModel {
  StlFormat format = StlFormat::Binary;
  std::vector<Facet> facets;          // all coordinates are finite
  std::vector<std::string> warnings;  // oddities that do not change the shape, one sentence each
};

// The data is not a usable STL file. what() is one sentence: what, where (byte or line), why.
class StlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What a file holds at most, by its size and its first bytes.
struct StlOutline {
  StlFormat format = StlFormat::Binary;
  std::uint64_t most_facets = 0;     // just as many, if it is binary
  std::uint64_t buffered_bytes = 0;  // of the file, in memory beside the facets while it is read
};

// Looks at the beginning alone; blocks. Throws as read_stl_file() does, as far as it shows there what is
// wrong.
[[nodiscard]] StlOutline outline_of_stl(const std::filesystem::path& path);
// The same for a regular file of that many bytes that is open for reading, which is at its beginning again
// then; `path` is its name in messages.
[[nodiscard]] StlOutline outline_of_stl(std::FILE* file, std::uint64_t bytes,
                                        const std::filesystem::path& path);

// Reads a whole file; blocks. It is binary when 84 + 50 n equals its size, whatever the header says, and
// otherwise what its first bytes look like. Memory is in proportion to the file, never to a count that the
// file claims. Throws StlError for bad data, std::system_error when the file cannot be read or is not a
// regular file.
[[nodiscard]] StlModel read_stl_file(const std::filesystem::path& path);

// The same for a regular file of that many bytes that is open for reading; `path` is its name in messages.
[[nodiscard]] StlModel read_stl_file(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path);

// The same for bytes already in memory. Throws StlError.
[[nodiscard]] StlModel read_stl(std::span<const std::byte> bytes);

}  // namespace contourd
