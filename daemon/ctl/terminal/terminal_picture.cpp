#include "daemon/ctl/terminal/terminal_picture.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sixel.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/system/standard_output.hpp"

namespace contourd::ctl {
namespace {

using SteadyClock = std::chrono::steady_clock;

// --- properties of the terminal

constexpr auto kLongestAnswer = std::chrono::seconds(1);
constexpr std::size_t kMostSent = 4096;
constexpr int kFewestRows = 6;
constexpr int kMostColumns = 1000, kMostRows = 500, kLargestCell = 100;

// True if both are the same terminal, even if one of them was opened as /dev/tty.
bool is_one_terminal(int one, int other) {
  unsigned one_device = 0, other_device = 0;
  return ::ioctl(one, TIOCGDEV, &one_device) == 0 && ::ioctl(other, TIOCGDEV, &other_device) == 0 &&
         one_device == other_device;
}

// During its lifetime, standard input delivers each byte at once, without echo.
class RawInput {
 public:
  RawInput() : valid_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!valid_) return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    valid_ = ::tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
  }
  ~RawInput() {
    if (valid_) (void)::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  RawInput(const RawInput&) = delete;
  RawInput& operator=(const RawInput&) = delete;

  [[nodiscard]] bool valid() const { return valid_; }

 private:
  termios before_{};
  bool valid_;
};

enum class Waited { Ready, Late, Signal };

// Waits until the descriptor is ready or a signal is pending; at most until the deadline if there is one.
Waited wait_for(int descriptor, short event, const HeldSignals& signals,
                std::optional<SteadyClock::time_point> deadline = std::nullopt) {
  std::array polled{pollfd{descriptor, event, 0}, pollfd{signals.descriptor(), POLLIN, 0}};
  int milliseconds = -1;
  if (deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*deadline - SteadyClock::now()).count();
    milliseconds = static_cast<int>(std::max<decltype(left)>(left, 0));
  }
  if (::poll(polled.data(), polled.size(), milliseconds) <= 0) return Waited::Late;
  return polled[1].revents != 0 ? Waited::Signal : Waited::Ready;
}

bool is_typed_ahead() {
  pollfd keys{STDIN_FILENO, POLLIN, 0};
  return ::poll(&keys, 1, 0) != 0;
}

// Reads the terminal's answer byte by byte, so that keys typed after the answer stay unread.
std::optional<bool> read_answer(const HeldSignals& signals, SteadyClock::time_point deadline) {
  std::string sent;
  while (sent.size() < kMostSent && wait_for(STDIN_FILENO, POLLIN, signals, deadline) == Waited::Ready) {
    char byte = 0;
    if (::read(STDIN_FILENO, &byte, 1) != 1) break;
    sent += byte;
    if (byte != 'c') continue;
    if (const std::optional<bool> answer = sixels_in_answer(sent)) return answer;
  }
  return std::nullopt;
}

bool has_sixels() {
  constexpr std::string_view kPrimaryDeviceAttributes = "\x1B[c";
  if (!is_one_terminal(STDIN_FILENO, STDOUT_FILENO) || !in_foreground()) return false;
  const FileDescriptor out = open_output_without_waiting();
  if (!out.valid()) return false;
  const HeldSignals signals;
  const RawInput input;
  if (!input.valid() || is_typed_ahead()) return false;
  const auto deadline = SteadyClock::now() + kLongestAnswer;
  if (wait_for(out.get(), POLLOUT, signals, deadline) != Waited::Ready) return false;
  if (::write(out.get(), kPrimaryDeviceAttributes.data(), kPrimaryDeviceAttributes.size()) !=
      static_cast<ssize_t>(kPrimaryDeviceAttributes.size()))
    return false;
  const std::optional<bool> answer = read_answer(signals, deadline);
  // Discards an incomplete answer, so that no other program reads it as input.
  if (!answer) (void)::tcflush(STDIN_FILENO, TCIFLUSH);
  return answer.value_or(false);
}

PictureInk ink_of_terminal() {
  if (!knows_sequences() || !wants_colors()) return PictureInk::Characters;
  return has_sixels() ? PictureInk::Sixels : line_ink();
}

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

struct Size {
  double width = 0, height = 0;
};

// Returns the room in square pixels. A character is twice as high as wide.
Size room_on(const PictureTerminal& terminal) {
  if (terminal.ink == PictureInk::Sixels)
    return {static_cast<double>(terminal.columns) * terminal.cell_width,
            static_cast<double>(terminal.rows) * terminal.cell_height};
  return {static_cast<double>(terminal.columns), 2.0 * terminal.rows};
}

// Returns the largest scale that fits. Above 1 it is a whole number, so that all pixels get the same size.
double scale_of(const MaskArea& area, const PictureTerminal& terminal) {
  const Size room = room_on(terminal);
  const double scale = std::min(room.width / area.width, room.height / area.height);
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

template <auto release>
struct Release {
  template <typename Object>
  void operator()(Object* object) const {
    release(object);
  }
};

void require_sixels(SIXELSTATUS status) {
  if (SIXEL_FAILED(status))
    throw std::runtime_error(fmt::format("cannot encode sixels: {}", sixel_helper_format_error(status)));
}

// Draws sixels, with the greys that occur as the palette.
std::string draw_sixels(Raster raster) {
  std::bitset<256> used;
  for (const std::uint8_t grey : raster.greys)
    used.set(grey);
  std::array<std::uint8_t, 256> number{};
  std::vector<std::uint8_t> palette;
  for (std::size_t grey = 0; grey < used.size(); ++grey) {
    if (!used[grey]) continue;
    number[grey] = static_cast<std::uint8_t>(palette.size() / 3);
    palette.insert(palette.end(), 3, static_cast<std::uint8_t>(grey));
  }
  for (std::uint8_t& grey : raster.greys)
    grey = number[grey];
  std::string text;
  const auto take = [](char* data, int size, void* to) {
    static_cast<std::string*>(to)->append(data, static_cast<std::size_t>(size));
    return size;
  };
  sixel_output_t* made_output = nullptr;
  require_sixels(sixel_output_new(&made_output, take, &text, nullptr));
  const std::unique_ptr<sixel_output_t, Release<sixel_output_unref>> output(made_output);
  sixel_dither_t* made_colors = nullptr;
  require_sixels(sixel_dither_new(&made_colors, static_cast<int>(palette.size() / 3), nullptr));
  const std::unique_ptr<sixel_dither_t, Release<sixel_dither_unref>> colors(made_colors);
  sixel_dither_set_palette(colors.get(), palette.data());
  sixel_dither_set_pixelformat(colors.get(), SIXEL_PIXELFORMAT_PAL8);
  constexpr int kUnusedDepth = 8;
  require_sixels(sixel_encode(raster.greys.data(), raster.width, raster.height, kUnusedDepth, colors.get(),
                              output.get()));
  return text + '\n';
}

// --- standard output

[[noreturn]] void fail_to_write(int error) {
  throw OutputError(fmt::format("cannot write the picture: {}", std::strerror(error)));
}

// Ends an incomplete picture. Waits at most 500 ms for the terminal.
void end_drawing(int out) {
  // Ends a device control string and resets colours.
  constexpr std::string_view kBackToText = "\x1B\\\x1B[0m\n";
  constexpr int kPatienceMs = 500;
  pollfd room{out, POLLOUT, 0};
  if (::poll(&room, 1, kPatienceMs) > 0) (void)!::write(out, kBackToText.data(), kBackToText.size());
}

// Writes the picture. Returns false if a signal came meanwhile.
bool write_unless_interrupted(int out, std::string_view picture) {
  const HeldSignals signals;
  while (!picture.empty()) {
    if (wait_for(out, POLLOUT, signals) == Waited::Signal) {
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

PictureInk line_ink() {
  if (!knows_sequences() || !wants_colors()) return PictureInk::Characters;
  const char* const colors = std::getenv("COLORTERM");
  const std::string_view word = colors != nullptr ? colors : "";
  return word == "truecolor" || word == "24bit" ? PictureInk::TrueColor : PictureInk::Greys;
}

PictureTerminal find_picture_terminal() {
  PictureTerminal terminal;
  terminal.ink = ink_of_terminal();
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return terminal;
  terminal.columns = std::min<int>(size.ws_col, kMostColumns);
  constexpr int kPrompt = 1;  // row for the shell's prompt
  terminal.rows = std::clamp(size.ws_row - kPrompt, kFewestRows, kMostRows);
  if (size.ws_xpixel >= size.ws_col && size.ws_ypixel >= size.ws_row) {
    terminal.cell_width = std::min(size.ws_xpixel / size.ws_col, kLargestCell);
    terminal.cell_height = std::min(size.ws_ypixel / size.ws_row, kLargestCell);
  }
  return terminal;
}

void leave_lines(PictureTerminal& terminal, std::size_t lines) {
  const auto some = static_cast<int>(std::min<std::size_t>(lines, kMostRows));
  terminal.rows = std::max(terminal.rows - some, kFewestRows);
}

std::optional<bool> sixels_in_answer(std::string_view sent) {
  constexpr std::string_view kBegin = "\x1B[?", kSixels = "4";
  for (std::size_t at = sent.find(kBegin); at != std::string_view::npos; at = sent.find(kBegin, at + 1)) {
    std::string_view answer = sent.substr(at + kBegin.size());
    const std::size_t end = answer.find_first_not_of("0123456789;");
    if (end == std::string_view::npos || answer[end] != 'c') continue;
    answer = answer.substr(0, end);
    // The first number is the terminal's class (4 would be a VT132), so it is skipped.
    bool found = false;
    for (std::size_t next = answer.find(';'); next != std::string_view::npos; next = answer.find(';')) {
      answer.remove_prefix(next + 1);
      found = found || answer.substr(0, answer.find(';')) == kSixels;
    }
    return found;
  }
  return std::nullopt;
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
  Raster raster = scaled_for(mask, area, terminal);
  switch (terminal.ink) {
    case PictureInk::Sixels:
      return draw_sixels(std::move(raster));
    case PictureInk::TrueColor:
    case PictureInk::Greys:
      return draw_half_blocks(raster, terminal.ink);
    case PictureInk::Characters:
      break;
  }
  return draw_characters(raster);
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
