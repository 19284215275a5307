#include "daemon/web/qr_code.hpp"

#include <langinfo.h>
#include <qrencode.h>
#include <unistd.h>

#include <clocale>
#include <cstdlib>
#include <memory>
#include <string_view>

namespace contourd::web {

std::string qr_code_of(const std::string& text) {
  const std::unique_ptr<QRcode, decltype(&::QRcode_free)> code(
      ::QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_M), &::QRcode_free);
  if (!code) return "";
  constexpr int kMargin = 4;  // modules, by ISO/IEC 18004
  const auto is_dark = [&code](int row, int column) {
    const bool inside = row >= 0 && column >= 0 && row < code->width && column < code->width;
    return inside && (code->data[row * code->width + column] & 1U) != 0;
  };
  // Black on white: the glyphs are the dark modules.
  constexpr std::string_view kColors = "\x1b[30;107m", kNormal = "\x1b[0m\n";
  std::string picture;
  for (int row = -kMargin; row < code->width + kMargin; row += 2) {
    picture += kColors;
    for (int column = -kMargin; column < code->width + kMargin; ++column) {
      const bool upper = is_dark(row, column), lower = is_dark(row + 1, column);
      picture += upper ? (lower ? "\u2588" : "\u2580") : (lower ? "\u2584" : " ");
    }
    picture += kNormal;
  }
  return picture;
}

bool can_show_qr_code() {
  const char* const terminal = std::getenv("TERM");
  const std::string_view name = terminal == nullptr ? "" : terminal;
  if (::isatty(STDOUT_FILENO) == 0 || name.empty() || name == "dumb") return false;
  (void)std::setlocale(LC_CTYPE, "");
  return std::string_view(::nl_langinfo(CODESET)) == "UTF-8";
}

}  // namespace contourd::web
