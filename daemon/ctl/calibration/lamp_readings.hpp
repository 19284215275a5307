// The readings of a lamp's light, as a user gives them. Not thread-safe; blocks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration/lamp_fit.hpp"
#include "core/calibration/lamp_pictures.hpp"
#include "core/geometry/units.hpp"

namespace contourd::ctl {

// The answer or word for a place that was not measured.
inline constexpr const char* kNotMeasured = "?";

// Parses "5x3", columns and rows. Throws UsageError unless both are LampGrid::kLeast to LampGrid::kMost.
[[nodiscard]] LampGrid parse_lamp_grid(const std::string& word);

// Parses one reading for each field of a grid over a display, row by row; `?` for a field that was not
// measured. Throws UsageError.
[[nodiscard]] std::vector<LampReading> parse_lamp_readings(const std::vector<std::string>& words,
                                                           const LampGrid& grid, Pixels width, Pixels height);

// Reads lines of "x,y,reading", with x and y in mm from the picture's upper left corner, from a regular file
// of at most 64 KiB; a first line without digits, empty lines and those that begin with # are skipped. Throws
// UsageError, with the line.
[[nodiscard]] std::vector<LampReading> read_lamp_table(const std::filesystem::path& file, Millimeters width,
                                                       Millimeters height);

// A photo of the white picture.
struct LampPhotoArgs {
  std::optional<std::filesystem::path> file;
  std::string corners;   // x and y of each in pixels, with commas between them
  std::string encoding;  // "linear" or "srgb"
};
// Reads the photo's light in the cells of a grid. Throws UsageError and CalibrationRefused.
[[nodiscard]] std::vector<LampReading> read_lamp_photo(const LampPhotoArgs& args, const LampGrid& grid);

}  // namespace contourd::ctl
