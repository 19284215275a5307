#include "daemon/ctl/terminal/terminal_picture.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/system/standard_output.hpp"

namespace contourd::ctl {
namespace {

constexpr int kFewestRows = 6;
constexpr int kMostColumns = 1000, kMostRows = 500;

// --- light

// The transfer functions of sRGB (IEC 61966-2-1); values from 0 to 1.
double linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

const std::array<double, 256>& light_of_greys() {
  static const std::array<double, 256> light = [] {
    std::array<double, 256> each{};
    for (std::size_t grey = 0; grey < each.size(); ++grey)
      each[grey] = linear(static_cast<double>(grey) / 255);
    return each;
  }();
  return light;
}

struct Raster {
  int width = 0, height = 0;
  std::vector<std::uint8_t> greys;  // row by row

  [[nodiscard]] std::uint8_t at(int x, int y) const {
    return greys[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

// Resamples an area of a mask: each new pixel has the mean linear light of the area that it covers.
class Resampler {
 public:
  Resampler(const Mask& mask, const MaskArea& area, int width, int height)
      : mask_(mask), area_(area), raster_{width, height, {}}, row_(static_cast<std::size_t>(width)) {}

  Raster take() {
    for (std::int64_t y = 0; y < raster_.height; ++y) {
      std::ranges::fill(row_, 0.0);
      for_each_overlap(y, area_.height, raster_.height, [this](std::int64_t from, std::int64_t overlap) {
        add_row(area_.top + static_cast<std::int32_t>(from), static_cast<double>(overlap));
      });
      const double all = static_cast<double>(area_.width) * area_.height;
      for (const double light : row_)
        raster_.greys.push_back(static_cast<std::uint8_t>(std::lround(encoded(light / all) * 255)));
    }
    return std::move(raster_);
  }

 private:
  // Calls take(pixel, overlap) for each of `from` source pixels that pixel `place` of `to` covers; the
  // overlap is in units of 1 / `to` source pixel.
  template <typename Take>
  static void for_each_overlap(std::int64_t place, std::int64_t from, std::int64_t to, Take&& take) {
    const std::int64_t begin = place * from, end = begin + from;
    for (std::int64_t each = begin / to; each * to < end; ++each)
      take(each, std::min(end, (each + 1) * to) - std::max(begin, each * to));
  }

  void add_row(std::int32_t y, double weight) {
    const auto greys = mask_.row(y).subspan(static_cast<std::size_t>(area_.left));
    const auto& light = light_of_greys();
    for (std::size_t x = 0; x < row_.size(); ++x) {
      double sum = 0;
      for_each_overlap(static_cast<std::int64_t>(x), area_.width, raster_.width,
                       [&](std::int64_t from, std::int64_t overlap) {
                         sum += light[greys[static_cast<std::size_t>(from)]] * static_cast<double>(overlap);
                       });
      row_[x] += weight * sum;
    }
  }

  const Mask& mask_;
  MaskArea area_;
  Raster raster_;
  std::vector<double> row_;
};

// --- size

// Returns the largest scale that fits. Above 1 it is a whole number, so that all pixels get the same size.
double scale_of(const MaskArea& area, const PictureTerminal& terminal) {
  // A character is twice as high as wide.
  const double width = terminal.columns, height = 2.0 * terminal.rows;
  const double scale = std::min(width / area.width, height / area.height);
  return scale > 1 ? std::floor(scale) : scale;
}

Raster scaled_for(const Mask& mask, const MaskArea& area, const PictureTerminal& terminal) {
  const double scale = scale_of(area, terminal);
  const int pixel_height = terminal.ink == PictureInk::Characters ? 2 : 1;
  const auto side = [](double length) { return std::max(1, static_cast<int>(std::lround(length))); };
  return Resampler(mask, area, side(area.width * scale), side(area.height * scale / pixel_height)).take();
}

// --- ink

std::string draw_characters(const Raster& raster) {
  constexpr std::array<std::string_view, 5> kDensities{" ", "\u2591", "\u2592", "\u2593", "\u2588"};
  std::string text;
  for (int y = 0; y < raster.height; ++y) {
    std::string line;
    std::size_t end = 0;
    for (int x = 0; x < raster.width; ++x) {
      const int grey = raster.at(x, y);
      // A pixel that is not black is always visible.
      const int density = grey == 0 ? 0 : std::max(1, (grey * 4 + 127) / 255);
      line += kDensities[static_cast<std::size_t>(density)];
      if (density > 0) end = line.size();
    }
    text.append(line, 0, end) += '\n';
  }
  return text;
}

// Returns the nearest grey of xterm's 256 colours: 24 greys from 8 to 238 in steps of 10, black and white.
int color_of(std::uint8_t grey) {
  constexpr int kBlack = 16, kWhite = 231, kFirstGrey = 232;
  if (grey < 4) return kBlack;
  if (grey > 246) return kWhite;
  return kFirstGrey + std::clamp((grey - 3) / 10, 0, 23);
}

// Returns the sequence that sets a colour (SGR; ECMA-48 and ISO 8613-6).
std::string color_sequence(int which, std::uint8_t grey, PictureInk ink) {
  if (ink == PictureInk::TrueColor) return fmt::format("\x1B[{};2;{};{};{}m", which, grey, grey, grey);
  return fmt::format("\x1B[{};5;{}m", which, color_of(grey));
}

// Draws two rows per line: the upper row in the character's colour, the lower row as its background.
std::string draw_half_blocks(const Raster& raster, PictureInk ink) {
  constexpr int kForeground = 38, kBackground = 48;
  constexpr std::string_view kUpperHalf = "\u2580", kPlain = "\x1B[0m";
  std::string text;
  for (int y = 0; y < raster.height; y += 2) {
    const bool has_lower = y + 1 < raster.height;
    std::string fore, back;
    for (int x = 0; x < raster.width; ++x) {
      const std::uint8_t upper = raster.at(x, y), lower = has_lower ? raster.at(x, y + 1) : upper;
      if (std::string color = color_sequence(kBackground, lower, ink); has_lower && color != back)
        text += back = std::move(color);
      if (has_lower && upper == lower) {
        text += ' ';
        continue;
      }
      if (std::string color = color_sequence(kForeground, upper, ink); color != fore)
        text += fore = std::move(color);
      text += kUpperHalf;
    }
    text += kPlain;
    text += '\n';
  }
  return text;
}

// --- standard output

[[noreturn]] void fail_to_write(int error) {
  throw OutputError(fmt::format("cannot write the picture: {}", std::strerror(error)));
}

// Ends an incomplete picture. Waits at most 500 ms for the terminal.
void end_drawing(int out) {
  constexpr std::string_view kPlainLine = "\x1B[0m\n";
  constexpr int kPatienceMs = 500;
  pollfd room{out, POLLOUT, 0};
  if (::poll(&room, 1, kPatienceMs) > 0) (void)!::write(out, kPlainLine.data(), kPlainLine.size());
}

// Writes the picture. Returns false if a signal came meanwhile.
bool write_unless_interrupted(int out, std::string_view picture) {
  const HeldSignals signals;
  while (!picture.empty()) {
    std::array polled{pollfd{out, POLLOUT, 0}, pollfd{signals.descriptor(), POLLIN, 0}};
    if (::poll(polled.data(), polled.size(), -1) > 0 && polled[1].revents != 0) {
      end_drawing(out);
      return false;
    }
    const ssize_t written = ::write(out, picture.data(), picture.size());
    if (written < 0 && errno != EINTR && errno != EAGAIN) fail_to_write(errno);
    if (written > 0) picture.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

PictureInk picture_ink() {
  if (!knows_sequences() || !wants_colors()) return PictureInk::Characters;
  const char* const colors = std::getenv("COLORTERM");
  const std::string_view word = colors != nullptr ? colors : "";
  return word == "truecolor" || word == "24bit" ? PictureInk::TrueColor : PictureInk::Greys;
}

PictureTerminal find_picture_terminal() {
  PictureTerminal terminal;
  terminal.ink = picture_ink();
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return terminal;
  terminal.columns = std::min<int>(size.ws_col, kMostColumns);
  constexpr int kPrompt = 1;  // row for the shell's prompt
  terminal.rows = std::clamp(size.ws_row - kPrompt, kFewestRows, kMostRows);
  return terminal;
}

void leave_lines(PictureTerminal& terminal, std::size_t lines) {
  const auto some = static_cast<int>(std::min<std::size_t>(lines, kMostRows));
  terminal.rows = std::max(terminal.rows - some, kFewestRows);
}

MaskArea whole_of(const Mask& mask) {
  return {0, 0, mask.width().count(), mask.height().count()};
}

MaskArea lit_area(const Mask& mask) {
  expects(!mask.pixels().empty(), "the mask has pixels");
  const MaskArea whole = whole_of(mask);
  std::int32_t left = whole.width, right = 0, top = whole.height, bottom = 0;
  for (std::int32_t y = 0; y < whole.height; ++y) {
    const auto row = mask.row(y);
    const auto is_lit = [](std::uint8_t grey) { return grey != 0; };
    const auto first = std::ranges::find_if(row, is_lit);
    if (first == row.end()) continue;
    const auto last = std::find_if(row.rbegin(), row.rend(), is_lit);
    left = std::min(left, static_cast<std::int32_t>(first - row.begin()));
    right = std::max(right, static_cast<std::int32_t>(row.rend() - last));
    top = std::min(top, y);
    bottom = y + 1;
  }
  if (right == 0) return whole;
  const std::int32_t margin = 2 + std::max(right - left, bottom - top) / 20;
  left = std::max(left - margin, 0);
  top = std::max(top - margin, 0);
  return {left, top, std::min(right + margin, whole.width) - left,
          std::min(bottom + margin, whole.height) - top};
}

MaskArea area_to_show(const Mask& mask, const PictureTerminal& terminal) {
  expects(!mask.pixels().empty(), "the mask has pixels");
  const MaskArea whole = whole_of(mask), lit = lit_area(mask);
  constexpr double kMuchLarger = 1.5;
  return scale_of(lit, terminal) >= kMuchLarger * scale_of(whole, terminal) ? lit : whole;
}

std::string draw_picture(const Mask& mask, const MaskArea& area, const PictureTerminal& terminal) {
  expects(area.width > 0 && area.height > 0 && area.left >= 0 && area.top >= 0 &&
              area.width <= mask.width().count() - area.left &&
              area.height <= mask.height().count() - area.top,
          "the area is inside the mask and has pixels");
  const Raster raster = scaled_for(mask, area, terminal);
  return terminal.ink == PictureInk::Characters ? draw_characters(raster)
                                                : draw_half_blocks(raster, terminal.ink);
}

void print_picture(std::string_view picture) {
  if (std::fflush(stdout) != 0) fail_to_write(errno);
  const FileDescriptor out = ::isatty(STDOUT_FILENO) != 0 ? open_output_without_waiting() : FileDescriptor();
  if (!out.valid()) {
    fmt::print("{}", picture);
    return;
  }
  while (!write_unless_interrupted(out.get(), picture)) {
  }
}

}  // namespace contourd::ctl
