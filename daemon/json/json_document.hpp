// A JSON file as an owner wrote it, read with distrust, and what is found to be wrong with it on the way.
// Value type; not thread-safe while violations are being added.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

class JsonDocument {
 public:
  static constexpr std::size_t kLargestBytes = std::size_t{1} << 20U;

  // Reads a regular file of at most 1 MiB of UTF-8 (a byte order mark is skipped), nested at most 64 deep,
  // with no text longer than 1024 bytes and no NUL in one. Throws ConfigError when there is no such thing, or
  // it is not JSON. A duplicate key is a violation of the document, not a throw: the rest can still be
  // checked.
  [[nodiscard]] static JsonDocument from_file(const std::filesystem::path& path, Links links = Links::Follow);
  // The same for text at hand; `file` is its name in messages.
  [[nodiscard]] static JsonDocument from_text(std::string_view text, std::string file);

  [[nodiscard]] const std::string& file() const { return file_; }

  // Whole numbers are stored as integers however they are written (3.0, 3e0), where a double holds them
  // exactly; integers beyond int64 as doubles. So "is it an integer" has one answer, and none wraps around.
  [[nodiscard]] const nlohmann::json& value() const { return value_; }
  [[nodiscard]] nlohmann::json& value() { return value_; }

  void add_violation(std::string pointer, std::string message);
  // What is allowed, but implausible.
  void add_warning(std::string pointer, std::string message);
  // In the order of their pointers.
  [[nodiscard]] std::vector<Violation> violations() const;
  [[nodiscard]] std::vector<Violation> warnings() const;
  void throw_if_violated() const;

  // The value at the pointer, if it is of that kind and nothing was found to be wrong with it: for rules
  // across fields, which have nothing to say about a value that is wrong in itself.
  [[nodiscard]] std::optional<double> valid_number(const std::string& pointer) const;
  [[nodiscard]] std::optional<std::string> valid_text(const std::string& pointer) const;
  [[nodiscard]] std::optional<bool> valid_boolean(const std::string& pointer) const;

 private:
  JsonDocument(std::string file, nlohmann::json value, std::vector<Violation> violations);
  [[nodiscard]] const nlohmann::json* valid_value(const std::string& pointer) const;

  std::string file_;
  nlohmann::json value_;
  std::vector<Violation> violations_, warnings_;
};

}  // namespace contourd
