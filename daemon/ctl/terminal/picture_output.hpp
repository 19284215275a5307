// Output of a command's picture: to a PNG file, to standard output, or drawn in the terminal. Not
// thread-safe. Blocks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/mask/mask.hpp"

namespace contourd::ctl {

struct NotedPicture {
  Mask mask;
  std::string note;      // description of the picture; printable
  bool is_mask = false;  // true: a mask, whose every pixel counts; false: a drawing
};

// Checks the output before the picture is made. `output`: a file, or "-" for standard output; nullopt: the
// terminal. Throws OutputError and UsageError.
void check_picture_output(const std::optional<std::filesystem::path>& output);

// Writes or draws the picture; a file appears completely or not at all. Throws OutputError.
void put_out(const NotedPicture& picture, const std::optional<std::filesystem::path>& output);

}  // namespace contourd::ctl
