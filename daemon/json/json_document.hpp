// A JSON file that a person wrote, read as untrusted input, with the violations found in it. Value type; not
// thread-safe while violations are being added.
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
  // with no text longer than 1024 bytes and no NUL in one. Throws ConfigError if the file does not exist,
  // breaks these limits or is not JSON. A duplicate key is only added to the violations, so that the rest can
  // still be checked.
  [[nodiscard]] static JsonDocument from_file(const std::filesystem::path& path, Links links = Links::Follow);
  // Reads the document from `text`; `file` is its name in messages.
  [[nodiscard]] static JsonDocument from_text(std::string_view text, std::string file);

  [[nodiscard]] const std::string& file() const { return file_; }

  // Returns the content. Whole numbers are integers however they are written (3.0, 3e0), provided that a
  // double holds them exactly; integers beyond int64 are doubles. So each number is clearly an integer or
  // not, and none wraps around.
  [[nodiscard]] const nlohmann::json& value() const { return value_; }
  [[nodiscard]] nlohmann::json& value() { return value_; }

  void add_violation(std::string pointer, std::string message);
  // Adds a warning about a value that is allowed but implausible.
  void add_warning(std::string pointer, std::string message);
  // Return the violations or warnings, sorted by pointer.
  [[nodiscard]] std::vector<Violation> violations() const;
  [[nodiscard]] std::vector<Violation> warnings() const;
  void throw_if_violated() const;

  // Return the value at the pointer if it has this type and no violation. For rules across fields, which must
  // ignore values that are already wrong by themselves.
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
