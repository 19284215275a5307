// Pictures in a terminal: a mask or another grey picture drawn with what the terminal has, and what that is.
// Greys are taken as sRGB has them: what is drawn smaller is averaged as light. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/mask/mask.hpp"

namespace contourd::ctl {

enum class PictureInk {
  Sixels,      // pixels, in up to 256 greys
  TrueColor,   // two pixels a character, in 256 greys
  Greys,       // the same, in the 26 greys of a terminal of 256 colours
  Characters,  // one pixel a character, by its density; no control sequences
};

// Sizes are bounded, whatever a terminal says of itself.
struct PictureTerminal {
  PictureInk ink = PictureInk::Characters;
  int columns = 80, rows = 40;            // to be filled by a picture
  int cell_width = 10, cell_height = 20;  // a character's pixels, for sixels
};

// What standard output's terminal has. It is asked for sixels, which takes a second where it does not answer,
// when standard input is the same terminal; what was typed before stays there for whoever reads next. Its
// modes are as they were then, whatever ends the program meanwhile. Throws std::system_error.
[[nodiscard]] PictureTerminal find_picture_terminal();
// What can be drawn within a view that is made of lines: no sixels. Asks the terminal nothing.
[[nodiscard]] PictureInk line_ink();
// Leaves room for so many lines of text above the picture, as long as there are some for that.
void leave_lines(PictureTerminal& terminal, std::size_t lines);

// Whether a terminal's answer to Primary Device Attributes (DA1), among what it sent, has sixels in it.
// Nothing as long as there is no such answer.
[[nodiscard]] std::optional<bool> sixels_in_answer(std::string_view sent);

// A part of a mask, in pixels.
struct MaskArea {
  std::int32_t left = 0, top = 0, width = 0, height = 0;
  bool operator==(const MaskArea&) const = default;
};

[[nodiscard]] MaskArea whole_of(const Mask& mask);
// What is lit, with a margin; all of it where nothing is. REQUIRES: the mask has pixels.
[[nodiscard]] MaskArea lit_area(const Mask& mask);
// The same where it is seen much larger on this terminal then; else all of it. REQUIRES: the mask has pixels.
[[nodiscard]] MaskArea area_to_show(const Mask& mask, const PictureTerminal& terminal);

// That part, as large as the terminal has room for, made larger by whole factors only. Whole lines. Throws
// std::runtime_error where sixels cannot be made. REQUIRES: the area is one of the mask's, with pixels.
[[nodiscard]] std::string draw_picture(const Mask& mask, const MaskArea& area,
                                       const PictureTerminal& terminal);

// To standard output. A signal that ends the program in the middle of it leaves the terminal fit for text;
// one that stops it, too, and then all is drawn anew. Throws OutputError.
void print_picture(std::string_view picture);

}  // namespace contourd::ctl
