#include "daemon/ctl/terminal/terminal_picture.hpp"

#include <sstream>

#include "daemon/ctl/terminal/text_columns.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

using namespace contourd::ctl;

namespace {

using Rows = std::vector<std::vector<int>>;

Mask picture_of(const Rows& rows) {
  Mask mask(Pixels{static_cast<std::int32_t>(rows.front().size())},
            Pixels{static_cast<std::int32_t>(rows.size())});
  for (std::size_t y = 0; y < rows.size(); ++y)
    std::ranges::transform(rows[y], mask.row(static_cast<std::int32_t>(y)).begin(),
                           [](int grey) { return static_cast<std::uint8_t>(grey); });
  return mask;
}

// Returns a mask whose area `lit` is white.
Mask picture_with(int width, int height, const MaskArea& lit) {
  Mask mask{Pixels{width}, Pixels{height}};
  for (std::int32_t y = lit.top; y < lit.top + lit.height; ++y)
    std::ranges::fill(
        mask.row(y).subspan(static_cast<std::size_t>(lit.left), static_cast<std::size_t>(lit.width)),
        std::uint8_t{255});
  return mask;
}

PictureTerminal terminal_of(PictureInk ink, int columns, int rows) {
  PictureTerminal terminal;
  terminal.ink = ink;
  terminal.columns = columns;
  terminal.rows = rows;
  return terminal;
}

std::string drawn(const Rows& rows, PictureInk ink, int columns, int lines) {
  const Mask mask = picture_of(rows);
  return draw_picture(mask, whole_of(mask), terminal_of(ink, columns, lines));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);)
    lines.push_back(line);
  return lines;
}

// Returns the visible text, without colour sequences (SGR).
std::string without_colors(const std::string& text) {
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\x1B')
      at = text.find('m', at);
    else
      plain += text[at];
  }
  return plain;
}

}  // namespace

TEST_CASE("Characters show greys by their density, and every grey above 0 is visible") {
  // A character is twice as high as a pixel is wide: two rows are one line.
  const std::vector<int> row{0, 1, 64, 128, 191, 255};
  CHECK(drawn({row, row}, PictureInk::Characters, 6, 1) == " \u2591\u2591\u2592\u2593\u2588\n");
  CHECK(drawn({{255, 0, 0}, {255, 0, 0}}, PictureInk::Characters, 3, 1) ==
        "\u2588\n");  // no blanks at the end
  CHECK(drawn({{0, 0}, {0, 0}}, PictureInk::Characters, 2, 1) == "\n");
}

TEST_CASE("Half blocks show two rows per line, each pixel in its grey") {
  CHECK(drawn({{0, 255}, {128, 255}}, PictureInk::TrueColor, 2, 1) ==
        "\x1B[48;2;128;128;128m\x1B[38;2;0;0;0m\u2580\x1B[48;2;255;255;255m \x1B[0m\n");
  CHECK(drawn({{0, 255}, {128, 255}}, PictureInk::Greys, 2, 1) ==
        "\x1B[48;5;244m\x1B[38;5;16m\u2580\x1B[48;5;231m \x1B[0m\n");
}

TEST_CASE("If the last line has only an upper row, its lower half keeps the terminal's background") {
  CHECK(drawn({{255}, {255}, {255}}, PictureInk::TrueColor, 1, 2) ==
        "\x1B[48;2;255;255;255m \x1B[0m\n\x1B[38;2;255;255;255m\u2580\x1B[0m\n");
}

TEST_CASE("With 256 colours, each grey is shown as the nearest available grey") {
  for (int grey = 0; grey < 256; ++grey) {
    CAPTURE(grey);
    const std::string text = drawn({{grey}, {grey}}, PictureInk::Greys, 1, 1);
    const int color = std::stoi(text.substr(text.find("48;5;") + 5));
    const int shown = color == 16 ? 0 : color == 231 ? 255 : 8 + 10 * (color - 232);
    CHECK((color == 16 || color >= 231));
    for (int other = 0; other <= 255; other == 0 ? other = 8 : other == 238 ? other = 255 : other += 10)
      CHECK(std::abs(shown - grey) <= std::abs(other - grey));
  }
}

TEST_CASE("A reduced picture averages linear light") {
  // Grey 188 has half of the light of 255 (sRGB).
  CHECK(drawn({{0, 255}, {255, 0}, {0, 255}, {255, 0}}, PictureInk::TrueColor, 1, 1) ==
        "\x1B[48;2;188;188;188m \x1B[0m\n");
  // Grey 137 has a quarter of the light.
  CHECK(drawn({{0, 255}, {0, 0}, {0, 0}, {255, 0}}, PictureInk::TrueColor, 1, 1) ==
        "\x1B[48;2;137;137;137m \x1B[0m\n");
  // Three columns become two: half of the middle column falls into each, so a third of each is white. Grey
  // 156 has a third of the light.
  const std::vector<int> row{0, 255, 0};
  CHECK(drawn({row, row, row, row}, PictureInk::TrueColor, 2, 1).find("48;2;156;156;156m") !=
        std::string::npos);
}

TEST_CASE("A uniform grey does not change at any size") {
  for (const int grey : {0, 1, 60, 128, 254, 255}) {
    const Mask mask = picture_of(Rows(7, std::vector<int>(11, grey)));
    for (const int columns : {1, 2, 3, 5, 11, 13, 47}) {
      CAPTURE(grey, columns);
      const std::string text =
          draw_picture(mask, whole_of(mask), terminal_of(PictureInk::TrueColor, columns, 50));
      const std::string color = "8;2;" + std::to_string(grey) + ";" + std::to_string(grey) + ";";
      for (std::size_t at = text.find("8;2;"); at != std::string::npos; at = text.find("8;2;", at + 1))
        CHECK(text.substr(at, color.size()) == color);
    }
  }
}

TEST_CASE("A picture keeps its aspect ratio and fits into every terminal") {
  const Mask mask = picture_with(1920, 1080, {0, 0, 1920, 1080});
  for (const PictureInk ink : {PictureInk::TrueColor, PictureInk::Characters}) {
    for (const auto& [columns, rows, wide, high] : {std::tuple{80, 40, 80, 22.5},
                                                    {200, 60, 200, 56.25},
                                                    {40, 40, 40, 11.25},
                                                    {80, 10, 36, 10.0},
                                                    {1, 1, 1, 1.0},
                                                    {1000, 500, 1000, 281.25}}) {
      CAPTURE(static_cast<int>(ink), columns, rows);
      const auto lines =
          lines_of(without_colors(draw_picture(mask, whole_of(mask), terminal_of(ink, columns, rows))));
      CHECK(std::abs(static_cast<double>(lines.size()) - high) <= 1);  // half a line, rounded
      for (const std::string& line : lines)
        CHECK(std::abs(static_cast<int>(columns_of(line)) - wide) <= 1);
      CHECK(columns_of(lines.front()) <= static_cast<std::size_t>(columns));
      CHECK(lines.size() <= static_cast<std::size_t>(rows));
    }
  }
  // A very long picture still has one line or one column.
  CHECK(lines_of(drawn({std::vector<int>(5000, 255)}, PictureInk::Characters, 80, 24)).size() == 1);
  CHECK(lines_of(drawn(Rows(5000, {255}), PictureInk::Characters, 80, 24)).size() == 24);
}

TEST_CASE("A small picture is enlarged by whole factors") {
  const std::string text = drawn({{255, 0}, {0, 255}}, PictureInk::TrueColor, 9, 100);
  const auto lines = lines_of(without_colors(text));
  REQUIRE(lines.size() == 4);  // 4 times
  CHECK(columns_of(lines.front()) == 8);
  CHECK(lines_of(drawn({{255, 0}, {0, 255}}, PictureInk::Characters, 9, 100)) ==
        std::vector<std::string>{"\u2588\u2588\u2588\u2588", "\u2588\u2588\u2588\u2588",
                                 "    \u2588\u2588\u2588\u2588", "    \u2588\u2588\u2588\u2588"});
}

TEST_CASE("The lit area is shown with a margin if this makes it larger") {
  const PictureTerminal terminal = terminal_of(PictureInk::Characters, 80, 40);
  CHECK(area_to_show(picture_with(1920, 1080, {900, 500, 100, 50}), terminal) == MaskArea{893, 493, 114, 64});
  CHECK(area_to_show(picture_with(1920, 1080, {0, 0, 1, 1}), terminal) == MaskArea{0, 0, 3, 3});
  CHECK(area_to_show(picture_with(1920, 1080, {1919, 1079, 1, 1}), terminal) == MaskArea{1917, 1077, 3, 3});
  CHECK(area_to_show(picture_with(1920, 1080, {0, 0, 1920, 1080}), terminal) == MaskArea{0, 0, 1920, 1080});
  CHECK(area_to_show(picture_with(1920, 1080, {100, 100, 1500, 900}), terminal) ==
        MaskArea{0, 0, 1920, 1080});
  CHECK(area_to_show(picture_with(1920, 1080, {}), terminal) == MaskArea{0, 0, 1920, 1080});
  CHECK(lit_area(picture_with(720, 720, {50, 100, 620, 500})) == MaskArea{17, 67, 686, 566});
  // A factor of 2 is a gain; a smaller gain shows the whole mask.
  CHECK(area_to_show(picture_with(20, 20, {8, 8, 4, 4}), terminal_of(PictureInk::Characters, 20, 10)) ==
        MaskArea{6, 6, 8, 8});
  CHECK(area_to_show(picture_with(20, 20, {3, 3, 14, 14}), terminal_of(PictureInk::Characters, 20, 10)) ==
        MaskArea{0, 0, 20, 20});
}

TEST_CASE("Only the area is drawn") {
  const Mask mask = picture_with(100, 100, {40, 40, 10, 10});
  const PictureTerminal terminal = terminal_of(PictureInk::Characters, 10, 5);
  for (const std::string& line : lines_of(draw_picture(mask, {40, 40, 10, 10}, terminal)))
    CHECK(line == "\u2588\u2588\u2588\u2588\u2588\u2588\u2588\u2588\u2588\u2588");
  CHECK(draw_picture(mask, {50, 50, 10, 10}, terminal) == "\n\n\n\n\n");
}

TEST_CASE("Text above a picture reduces its rows down to a minimum") {
  PictureTerminal terminal = terminal_of(PictureInk::Greys, 80, 24);
  leave_lines(terminal, 4);
  CHECK(terminal.rows == 20);
  leave_lines(terminal, 1'000'000'000);
  CHECK(terminal.rows == 6);
}

TEST_CASE("A drawn area must be inside the mask and have pixels") {
  const Mask none, mask = picture_with(10, 10, {});
  CHECK(contract_broken_by([&] { (void)area_to_show(none, {}); }) == "the mask has pixels");
  CHECK(contract_broken_by([&] { (void)lit_area(none); }) == "the mask has pixels");
  const std::string broken = "the area is inside the mask and has pixels";
  for (const MaskArea& area :
       {MaskArea{}, {0, 0, 11, 1}, {5, 5, 6, 1}, {0, 9, 1, 2}, {-1, 0, 5, 5}, {0, -1, 5, 5}, {0, 0, 5, 0}})
    CHECK(contract_broken_by([&] { (void)draw_picture(mask, area, {}); }) == broken);
}
