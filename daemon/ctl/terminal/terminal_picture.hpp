// Draws a mask or another grey picture in a terminal, as half blocks: two pixels per character. Greys are
// sRGB values: a smaller picture averages linear light. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/mask/mask.hpp"

namespace contourd::ctl {

enum class PictureInk {
  TrueColor,   // two pixels per character, in 256 greys
  Greys,       // two pixels per character, in the 26 greys of a terminal with 256 colours
  Characters,  // one pixel per character of matching density; no control sequences
};

// Properties of a terminal. Sizes are limited to plausible values, whatever the terminal reports.
struct PictureTerminal {
  PictureInk ink = PictureInk::Characters;
  int columns = 80, rows = 40;  // room for the picture
};

// Returns the ink that standard output's terminal supports, according to TERM, COLORTERM and NO_COLOR.
[[nodiscard]] PictureInk picture_ink();
// Returns the properties of standard output's terminal.
[[nodiscard]] PictureTerminal find_picture_terminal();
// Reserves lines for text above the picture, but leaves a minimum for the picture.
void leave_lines(PictureTerminal& terminal, std::size_t lines);

// A part of a mask, in pixels.
struct MaskArea {
  std::int32_t left = 0, top = 0, width = 0, height = 0;
  bool operator==(const MaskArea&) const = default;
};

[[nodiscard]] MaskArea whole_of(const Mask& mask);
// Returns the lit area with a margin, or the whole mask if nothing is lit. REQUIRES: the mask has pixels.
[[nodiscard]] MaskArea lit_area(const Mask& mask);
// Returns the lit area if it appears much larger on this terminal than in the whole mask, else the whole
// mask. REQUIRES: the mask has pixels.
[[nodiscard]] MaskArea area_to_show(const Mask& mask, const PictureTerminal& terminal);

// Draws the area as large as the terminal allows; enlarges only by whole factors. Returns complete lines.
// REQUIRES: the area is inside the mask and has pixels.
[[nodiscard]] std::string draw_picture(const Mask& mask, const MaskArea& area,
                                       const PictureTerminal& terminal);

// Prints the picture to standard output. If a signal ends or stops the program meanwhile, the terminal is
// first reset to plain text; after a stop, the picture is drawn again. Throws OutputError.
void print_picture(std::string_view picture);

}  // namespace contourd::ctl
