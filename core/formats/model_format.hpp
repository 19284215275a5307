// What the reader of models asks of a file format. Each format is one value of this type, in a header of its
// own, and one line of the table in model_reader.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/model/model.hpp"

namespace contourd {

// Of this much of a file's beginning the format is told, or of the whole file if it is shorter.
inline constexpr std::size_t kSniffBytes = 1024;

struct FileStart {
  std::uint64_t file_bytes;          // of the whole file
  std::span<const std::byte> bytes;  // the first kSniffBytes
};

// How sure it is that a file is of a format. The format that is surest reads it.
enum class Likeness { None, Possible, Likely, Certain };

// What a file holds at most, by its size and its first bytes.
struct ModelOutline {
  std::string_view format{};         // its name
  std::uint64_t most_facets = 0;     // just as many, if it is exact
  bool exact = false;                // else the facets are collected in memory that grows
  std::uint64_t buffered_bytes = 0;  // of the file, in memory beside the facets while it is read
};

// Fills the span from the file, in order from its first byte on, completely; throws std::system_error when it
// cannot.
using ReadBytes = std::function<void(std::span<std::byte>)>;

struct ModelFormat {
  std::string_view name;       // as an owner is told
  std::string_view extension;  // of its files' names, in lower case
  Likeness (*likeness)(const FileStart& start);
  // Throw ModelError when it is not such a file after all. Memory is in proportion to the file, never to a
  // count that the file claims.
  ModelOutline (*outline)(const FileStart& start);
  Model (*read)(const FileStart& start, const ReadBytes& read);
};

}  // namespace contourd
