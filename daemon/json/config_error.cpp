#include "daemon/json/config_error.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/utf_8.hpp"

namespace contourd {
namespace {

constexpr std::size_t kLongestQuote = 60;
// The limits of a message: a person corrects no more violations at once, and a job's reason holds no more
// bytes without a cut.
constexpr std::size_t kMaxLines = 20, kMaxBytes = 6000;
constexpr std::size_t kLongestPointer = 200;

// Returns the text cut at `bytes`, with dots in place of the rest.
std::string cut(std::string_view text, std::size_t bytes) {
  const std::string_view shown = cut_utf_8(text, bytes);
  return std::string(shown) + (shown.size() == text.size() ? "" : "...");
}

// Returns "FILE: severity/pointer: message".
std::string line(const Violation& violation, const char* severity) {
  std::string text = violation.file + ": " + severity;
  if (!violation.pointer.empty()) text += cut(violation.pointer, kLongestPointer) + ": ";
  return printable(text + violation.message);
}

std::string lines(const std::vector<Violation>& violations, const std::string& divider = "\n") {
  std::string text;
  std::size_t shown = 0;
  for (; shown < std::min(violations.size(), kMaxLines) && text.size() < kMaxBytes; ++shown)
    text += (text.empty() ? "" : divider) + line(violations[shown], "");
  if (shown < violations.size()) {
    const char* const counted = violations.size() < kMaxViolations ? "and " : "and at least ";
    text += divider + counted + std::to_string(violations.size() - shown) + " more";
  }
  return text;
}

}  // namespace

ConfigError::ConfigError(std::vector<Violation> violations)
    : std::runtime_error(lines(violations)), violations_(std::move(violations)) {
  expects(!violations_.empty(), "there is at least one violation");
}

std::string ConfigError::in_one_line() const {
  return lines(violations_, "; ");
}

std::string warning_line(const Violation& warning) {
  return line(warning, "warning: ");
}

std::string in_quotes(std::string_view text) {
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  return printable(nlohmann::json(cut(text, kLongestQuote)).dump(-1, ' ', false, kReplace));
}

std::string decimal(double number) {
  const auto whole = static_cast<long long>(number);
  return static_cast<double>(whole) == number ? std::to_string(whole) : nlohmann::json(number).dump();
}

std::string child_pointer(std::string_view pointer, std::string_view token) {
  std::string result(pointer);
  result += '/';
  for (const char c : token) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace contourd
