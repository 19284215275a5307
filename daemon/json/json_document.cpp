#include "daemon/json/json_document.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>
#include <utility>

#include "daemon/json/json_syntax.hpp"

namespace contourd {
namespace {

[[noreturn]] void reject(const std::string& file, std::string message) {
  throw ConfigError({{file, "", std::move(message)}});
}

void check_size(std::size_t bytes, const std::string& file) {
  if (bytes > JsonDocument::kLargestBytes) reject(file, "it is larger than the limit, 1 MiB");
}

// Reads the file, up to one byte more than is allowed.
std::string read_all(const FileDescriptor& file, const std::string& name) {
  std::string text(JsonDocument::kLargestBytes + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t bytes = ::read(file.get(), text.data() + size, text.size() - size);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) reject(name, "it cannot be read: " + std::generic_category().message(errno));
    if (bytes == 0) break;
    size += static_cast<std::size_t>(bytes);
  }
  text.resize(size);
  return text;
}

void normalize_number(nlohmann::json& number) {
  constexpr double kExactLimit = 9007199254740992.0;  // 2^53: doubles hold every whole number up to here
  if (number.is_number_float()) {
    const auto value = number.get<double>();
    if (std::fabs(value) <= kExactLimit && std::trunc(value) == value)
      number = static_cast<std::int64_t>(value);
  } else if (number.is_number_unsigned()) {
    const auto value = number.get<std::uint64_t>();
    if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      number = static_cast<double>(value);
    }
  }
}

// Recursion is bounded by the nesting limit.
void normalize_numbers(nlohmann::json& value) {
  if (value.is_structured()) {
    for (nlohmann::json& child : value)
      normalize_numbers(child);
  } else {
    normalize_number(value);
  }
}

std::vector<Violation> by_pointer(std::vector<Violation> violations) {
  std::stable_sort(violations.begin(), violations.end(),
                   [](const Violation& a, const Violation& b) { return a.pointer < b.pointer; });
  return violations;
}

}  // namespace

JsonDocument::JsonDocument(std::string file, nlohmann::json value, std::vector<Violation> violations)
    : file_(std::move(file)), value_(std::move(value)), violations_(std::move(violations)) {}

JsonDocument JsonDocument::from_file(const std::filesystem::path& path, Links links) {
  const std::string name = path.string();
  FileDescriptor file;
  try {
    file = open_regular_file(path, links);
  } catch (const UnreadableFile& error) {
    reject(name, error.what());
  }
  return from_text(read_all(file, name), name);
}

JsonDocument JsonDocument::from_text(std::string_view text, std::string file) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  check_size(text.size(), file);
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<Violation> violations = check_json_syntax(text, file);
  nlohmann::json value = nlohmann::json::parse(text.begin(), text.end());
  normalize_numbers(value);
  return {std::move(file), std::move(value), std::move(violations)};
}

void JsonDocument::add_violation(std::string pointer, std::string message) {
  violations_.push_back({file_, std::move(pointer), std::move(message)});
}

void JsonDocument::add_warning(std::string pointer, std::string message) {
  warnings_.push_back({file_, std::move(pointer), std::move(message)});
}

std::vector<Violation> JsonDocument::violations() const {
  return by_pointer(violations_);
}

std::vector<Violation> JsonDocument::warnings() const {
  return by_pointer(warnings_);
}

void JsonDocument::throw_if_violated() const {
  if (!violations_.empty()) throw ConfigError(violations());
}

const nlohmann::json* JsonDocument::valid_value(const std::string& pointer) const {
  const auto is_here = [&](const Violation& violation) { return violation.pointer == pointer; };
  if (std::any_of(violations_.begin(), violations_.end(), is_here)) return nullptr;
  const nlohmann::json::json_pointer place(pointer);
  return value_.contains(place) ? &value_.at(place) : nullptr;
}

std::optional<double> JsonDocument::valid_number(const std::string& pointer) const {
  const nlohmann::json* value = valid_value(pointer);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  return value->get<double>();
}

std::optional<std::string> JsonDocument::valid_text(const std::string& pointer) const {
  const nlohmann::json* value = valid_value(pointer);
  if (value == nullptr || !value->is_string()) return std::nullopt;
  return value->get<std::string>();
}

std::optional<bool> JsonDocument::valid_boolean(const std::string& pointer) const {
  const nlohmann::json* value = valid_value(pointer);
  if (value == nullptr || !value->is_boolean()) return std::nullopt;
  return value->get<bool>();
}

}  // namespace contourd
