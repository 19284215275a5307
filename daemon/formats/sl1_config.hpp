// The settings in a sliced archive for printers of the type SL1: config.ini, and prusaslicer.ini, which tells
// of the display that the archive is for. Thread-safe (no shared state).
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/geometry/units.hpp"

namespace contourd {

// Lines "key = value", by key. A line without "=" does not count; of a key's lines, the last one counts.
using IniFile = std::map<std::string, std::string, std::less<>>;
[[nodiscard]] IniFile parse_ini(std::string_view text);

// The exposures of a sliced archive: the first layers have the first exposure, and `fading` layers after them
// lead to the normal one. Without another number the first layers are three, by the rule of PrusaSlicer's
// time estimate.
struct SlicedExposures {
  std::chrono::nanoseconds normal{}, first{};
  int fading = 0;
  int first_layers = 3;
};

// The display of a sliced archive. Its pictures are as sent to it: mirrored, and turned a quarter
// counter-clockwise if it stands on end.
struct SlicedDisplay {
  std::array<std::int64_t, 2> pixels{};  // along the plate's x and y, seen from above
  std::array<double, 2> pitch_um{};
  double pitch_error_um = 0;                         // by which the file may have rounded the pitch
  bool mirror_columns = false, mirror_rows = false;  // mirrors of the pictures
  bool on_end = false;
  bool mirrors_known = true;  // false: the file does not tell the mirrors and the turn
};

struct SlicedSettings {
  Nanometers layer_height{};
  Nanometers first_layer{};                    // thickness of the first layer
  std::optional<SlicedExposures> exposures{};  // nullopt: the file names none
  std::optional<SlicedDisplay> display{};      // nullopt: the file does not tell
  std::string name{};                          // with which the names of pictures begin; empty: not told
  std::int64_t layers = 0;                     // number that the file names; 0: none
  double gamma = 1;                            // gamma correction of its pictures
};

// Reads the settings. Throws ModelError, a sentence, for a setting that is missing or wrong.
[[nodiscard]] SlicedSettings read_sliced_settings(const IniFile& config, const IniFile& prusaslicer);

}  // namespace contourd
