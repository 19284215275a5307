#include "daemon/ctl/calibration/lamp_readings.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "core/calibration/lamp_photo.hpp"
#include "core/calibration/line_fit.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

constexpr std::size_t kLargestTable = std::size_t{64} << 10U;
constexpr std::size_t kShownOfLine = 80;  // bytes

// Returns the numbers between the separators; empty if a part is not a number.
std::vector<double> numbers_of(const std::string& text, char separator) {
  std::vector<double> numbers;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, separator);) {
    part.erase(0, part.find_first_not_of(" \t"));
    part.erase(part.find_last_not_of(" \t\r") + 1);
    const std::optional<double> number = number_of(part);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::string read_table(const std::filesystem::path& path) {
  FileDescriptor file;
  try {
    file = open_regular_file(path, Links::Follow);
  } catch (const UnreadableFile& error) {
    throw UsageError(fmt::format("--table {}: {}", printable(path.string()), error.what()));
  }
  std::string text(kLargestTable + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t count = ::read(file.get(), text.data() + size, text.size() - size);
    if (count < 0) throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
  }
  if (size > kLargestTable)
    throw UsageError(fmt::format("{}: the table has more than {} KiB, the limit for readings",
                                 printable(path.string()), kLargestTable >> 10U));
  text.resize(size);
  return text;
}

// Returns where a length lies between the display's edges.
double place_of(double mm, Millimeters side) {
  return 2 * mm / side.count() - 1;
}

}  // namespace

LampGrid parse_lamp_grid(const std::string& word) {
  const std::vector<double> sides = numbers_of(word, 'x');
  const auto is_side = [](double side) {
    return side == std::round(side) && side >= LampGrid::kLeast && side <= LampGrid::kMost;
  };
  if (sides.size() != 2 || !std::ranges::all_of(sides, is_side))
    throw UsageError(fmt::format("--grid {}: give columns and rows, each {} to {}, as in 5x3",
                                 printable(word), LampGrid::kLeast, LampGrid::kMost));
  return {static_cast<int>(sides[0]), static_cast<int>(sides[1])};
}

std::vector<LampReading> parse_lamp_readings(const std::vector<std::string>& words, const LampGrid& grid,
                                             Pixels width, Pixels height) {
  if (words.size() != static_cast<std::size_t>(grid.cells()))
    throw UsageError(
        fmt::format("there are {} readings, and a grid of {}x{} has {} fields; give {} for a field "
                    "that was not measured",
                    words.size(), grid.columns, grid.rows, grid.cells(), kNotMeasured));
  std::vector<LampReading> readings;
  for (int cell = 0; cell < grid.cells(); ++cell) {
    const std::string& word = words[static_cast<std::size_t>(cell)];
    if (word == kNotMeasured) continue;
    const std::optional<double> light = number_of(word);
    if (!light)
      throw UsageError(fmt::format("\"{}\" is not a number, nor {} for a field that was not measured",
                                   printable(word), kNotMeasured));
    readings.push_back({lamp_field(grid, cell, width, height).middle, *light});
  }
  return readings;
}

std::vector<LampReading> read_lamp_table(const std::filesystem::path& file, Millimeters width,
                                         Millimeters height) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  std::string text = read_table(file);
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  std::istringstream lines(text);
  std::vector<LampReading> readings;
  bool is_first = true;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with('#')) continue;
    const std::vector<double> numbers = numbers_of(line, ',');
    const bool is_heading = is_first && line.find_first_of("0123456789") == std::string::npos;
    is_first = false;
    if (is_heading) continue;
    const auto refuse_line = [&](const std::string& why) {
      throw UsageError(fmt::format("{}, line {}: \"{}\" {}", printable(file.string()), number,
                                   printable(shortened(line, kShownOfLine)), why));
    };
    if (numbers.size() != 3) refuse_line("is not x, y and reading, three numbers as in 12.5,40,31.2");
    const LampPlace place{place_of(numbers[0], width), place_of(numbers[1], height)};
    if (std::abs(place.x) > 1 || std::abs(place.y) > 1)
      refuse_line(fmt::format("is beside the picture of {:.5g} x {:.5g} mm", width.count(), height.count()));
    readings.push_back({place, numbers[2]});
  }
  return readings;
}

std::vector<LampReading> read_lamp_photo(const LampPhotoArgs& args, const LampGrid& grid) {
  const std::vector<double> numbers = numbers_of(args.corners, ',');
  std::array<PhotoPoint, 4> corners{};
  if (numbers.size() != 2 * corners.size())
    throw UsageError(
        fmt::format("--corners {}: give x,y of the picture's 4 corners in the photo, 8 numbers in pixels, by "
                    "the number of "
                    "their dots",
                    printable(shortened(args.corners, kShownOfLine))));
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = {numbers[2 * i], numbers[2 * i + 1]};
  LampPhoto photo(corners, grid, args.encoding == "linear" ? PhotoEncoding::Linear : PhotoEncoding::Srgb);
  try {
    read_png_rows(*args.file,
                  [&photo](const PngRow& row) { photo.add_row(row.y, row.samples, row.channels); });
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw CalibrationRefused(fmt::format("{}: {}", printable(args.file->string()), error.what()));
  }
  return photo.readings();
}

}  // namespace contourd::ctl
