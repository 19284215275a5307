// Checked reading of a validated object: no read converts between kinds, wraps around or cuts off a fraction.
// Holds a reference to the document; thread-safe as long as that does not change.
#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/units.hpp"
#include "daemon/json/json_document.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Every read throws ConfigError when the key is missing or its value is of another kind.
class JsonSection {
 public:
  // The document's outermost object. The document must outlive the section.
  explicit JsonSection(const JsonDocument& document);

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_section(std::string_view key) const;
  [[nodiscard]] JsonSection section(std::string_view key) const;
  // A list of objects.
  [[nodiscard]] std::vector<JsonSection> sections(std::string_view key) const;
  [[nodiscard]] bool boolean(std::string_view key) const;
  [[nodiscard]] std::string text(std::string_view key) const;
  // A list of texts.
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  // A text, or the digits of a whole number.
  [[nodiscard]] std::string text_or_digits(std::string_view key) const;
  // Finite. An integer or a fraction.
  [[nodiscard]] double number(std::string_view key) const;
  // Throws ConfigError for a fraction and for what T cannot hold.
  template <std::integral T>
  [[nodiscard]] T integer(std::string_view key) const {
    const std::int64_t value = int64(key);
    if (!std::in_range<T>(value)) reject(key, std::to_string(value) + " is out of range");
    return static_cast<T>(value);
  }

  // In the unit that the key ends in, rounded to whole nanometres: _mm or _um. REQUIRES: one of these.
  [[nodiscard]] Nanometers length(std::string_view key) const;
  // In the unit that the key ends in, rounded to whole nanoseconds: _s, _ms or _us. REQUIRES: one of these.
  [[nodiscard]] Duration duration(std::string_view key) const;
  // A list's, each in the unit that the list's key ends in. REQUIRES: as above.
  [[nodiscard]] std::vector<Nanometers> lengths(std::string_view key) const;
  [[nodiscard]] std::vector<Duration> durations(std::string_view key) const;

 private:
  JsonSection(const JsonDocument& document, const nlohmann::json& object, std::string pointer);
  [[nodiscard]] const nlohmann::json& at(std::string_view key) const;
  [[nodiscard]] std::int64_t int64(std::string_view key) const;
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;
  [[nodiscard]] Nanometers as_length(std::string_view key, double number) const;
  [[nodiscard]] Duration as_duration(std::string_view key, double number) const;
  [[noreturn]] void reject(std::string_view key, std::string message) const;

  const JsonDocument& document_;
  const nlohmann::json& object_;
  std::string pointer_;
};

}  // namespace contourd
