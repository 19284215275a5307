#include "daemon/system/readable.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/system/utf_8.hpp"

namespace contourd {
namespace {

bool is_plain(char c) {
  return c >= 0x20 && c < 0x7F;
}

// True for control characters and for invisible ones that reorder or break the line: with them, a name could
// look like another name or like several lines.
bool is_unprintable(char32_t c) {
  struct Range {
    char32_t first, last;
  };
  constexpr std::array<Range, 11> kRanges{{{0x00, 0x1F},
                                           {0x7F, 0x9F},
                                           {0x61C, 0x61C},
                                           {0x180E, 0x180E},
                                           {0x200B, 0x200B},
                                           {0x200E, 0x200F},
                                           {0x2028, 0x202E},
                                           {0x2060, 0x206F},
                                           {0xFEFF, 0xFEFF},
                                           {0xFFF9, 0xFFFB},
                                           {0xE0000, 0xE007F}}};
  return std::ranges::any_of(kRanges,
                             [c](const Range& range) { return c >= range.first && c <= range.last; });
}

// Replaces invalid UTF-8 with U+FFFD, as nlohmann-json does when it writes a string.
std::string valid_utf_8(std::string_view text) {
  const std::string quoted =
      nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

std::string cleaned(std::string_view text, bool keep_lines) {
  if (std::ranges::all_of(text, is_plain)) return std::string(text);
  const std::string valid = valid_utf_8(text);
  std::string clean;
  for (std::string_view rest = valid; !rest.empty();) {
    const std::string_view bytes = rest.substr(0, utf_8_length(rest));
    rest.remove_prefix(bytes.size());
    const bool stays = !is_unprintable(code_point(bytes)) || (keep_lines && bytes == "\n");
    clean += stays ? bytes : "?";
  }
  return clean;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t bytes) {
  const std::string_view shown = cut_utf_8(text, bytes);
  if (shown.size() == text.size()) return std::string(text);
  return std::string(shown) + "... (" + std::to_string(text.size() - shown.size()) + " bytes more)";
}

std::string printable(std::string_view text) {
  return cleaned(text, false);
}

std::string printable_lines(std::string_view text) {
  return cleaned(text, true);
}

std::string readable(Duration duration) {
  const double seconds = std::chrono::duration<double>(duration).count();
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string count_of(std::uint64_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string coordinates(std::initializer_list<double> mm, int decimals) {
  std::string text;
  for (const double each : mm) {
    const std::string number = fmt::format("{:.{}f}", each, decimals);
    const bool is_zero = number.find_first_not_of("-0.") == std::string::npos;
    text += fmt::format("{}{}", text.empty() ? "" : ", ",
                        is_zero && number[0] == '-' ? number.substr(1) : number);
  }
  return text;
}

std::string local_time(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S %z}", fmt::localtime(std::chrono::system_clock::to_time_t(time)));
}

std::string iso_time(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

}  // namespace contourd
