// The interface of a file format to the model reader. Each format is one value of this type, in a header of
// its own, and one line of the table in model_reader.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "core/model/model.hpp"

namespace contourd {

// A format is recognised by this many bytes at the beginning of a file, or by the whole file if it is
// shorter. A licence and a history in comments, which may come before a model, have some ten thousand bytes.
inline constexpr std::size_t kSniffBytes = 65'536;

struct FileStart {
  std::uint64_t file_bytes;          // size of the whole file
  std::span<const std::byte> bytes;  // the first kSniffBytes
};

// How certain it is that a file has a format. The format with the greatest certainty reads the file.
enum class Likeness { None, Possible, Likely, Certain };

// Upper limits on what a file holds, by its size and its first bytes.
struct ModelOutline {
  std::string_view format{};         // the format's name
  std::uint64_t most_facets = 0;     // the exact number if `exact` is set
  bool exact = false;                // if not set, the facets are collected in memory that grows
  std::uint64_t buffered_bytes = 0;  // part of the file that is in memory beside the facets while it is read
};

// Fills the span completely with the next bytes of the file, beginning with its first byte; throws
// std::system_error if it cannot.
using ReadBytes = std::function<void(std::span<std::byte>)>;

struct ModelFormat {
  std::string_view name;  // the name in messages to users
  Likeness (*likeness)(const FileStart& start);
  // outline() and read() throw ModelError if the file does not have this format after all. They use memory in
  // proportion to the file, never to a count that the file claims.
  ModelOutline (*outline)(const FileStart& start);
  Model (*read)(const FileStart& start, const ReadBytes& read);
};

}  // namespace contourd
