// Where a picture goes that a command shows: a PNG file, standard output, or the terminal that it is drawn
// in. Not thread-safe. Blocks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/mask/mask.hpp"

namespace contourd::ctl {

struct NotedPicture {
  Mask mask;
  std::string note;      // what it shows; printable
  bool is_mask = false;  // whose every pixel counts; else a picture for people
};

// `output`: a file, or "-" for standard output; without it the terminal. Throws OutputError and UsageError
// for what shows before there is a picture.
void check_picture_output(const std::optional<std::filesystem::path>& output);

// The file is there whole or not at all. Throws OutputError, and what find_picture_terminal() throws.
void put_out(const NotedPicture& picture, const std::optional<std::filesystem::path>& output);

}  // namespace contourd::ctl
