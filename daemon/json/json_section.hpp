// Typed access to an object of a validated document: no read converts between types, wraps around or drops a
// fraction. Holds a reference to the document; thread-safe as long as the document does not change.
#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/units.hpp"
#include "daemon/json/json_document.hpp"
#include "hw/clock.hpp"

namespace contourd {

// An object of a JSON document. Every read throws ConfigError if the key is missing or its value has another
// type.
class JsonSection {
 public:
  // The section is the document's outermost object. The document must outlive the section.
  explicit JsonSection(const JsonDocument& document);

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_section(std::string_view key) const;
  [[nodiscard]] bool is_list(std::string_view key) const;
  [[nodiscard]] JsonSection section(std::string_view key) const;
  // Returns the objects of a list.
  [[nodiscard]] std::vector<JsonSection> sections(std::string_view key) const;
  [[nodiscard]] bool boolean(std::string_view key) const;
  [[nodiscard]] std::string text(std::string_view key) const;
  // Returns the texts of a list.
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  // Returns a text, or a whole number as digits.
  [[nodiscard]] std::string text_or_digits(std::string_view key) const;
  // Returns a finite number, whole or not.
  [[nodiscard]] double number(std::string_view key) const;
  // Returns a whole number. Throws ConfigError for a fraction or if T cannot hold the number.
  template <std::integral T>
  [[nodiscard]] T integer(std::string_view key) const {
    const std::int64_t value = int64(key);
    if (!std::in_range<T>(value)) reject(key, std::to_string(value) + " is out of range");
    return static_cast<T>(value);
  }

  // Returns what the function reads, or nullopt if there is no such key: find("fit", &JsonSection::boolean).
  template <typename Value>
  [[nodiscard]] std::optional<Value> find(std::string_view key,
                                          Value (JsonSection::*read)(std::string_view) const) const {
    return has(key) ? std::optional((this->*read)(key)) : std::nullopt;
  }

  // Returns a length in the unit that the key ends in, rounded to whole nanometres. REQUIRES: the key ends in
  // _mm or _um.
  [[nodiscard]] Nanometers length(std::string_view key) const;
  // Returns a duration in the unit that the key ends in, rounded to whole nanoseconds. REQUIRES: the key ends
  // in _s, _ms or _us.
  [[nodiscard]] Duration duration(std::string_view key) const;
  // Returns the lengths of a list, in the unit that the key ends in. REQUIRES: the key ends in _mm or _um.
  [[nodiscard]] std::vector<Nanometers> lengths(std::string_view key) const;
  // Returns the durations of a list, in the unit that the key ends in. REQUIRES: the key ends in _s, _ms or
  // _us.
  [[nodiscard]] std::vector<Duration> durations(std::string_view key) const;
  // Throws ConfigError with this message about the key.
  [[noreturn]] void reject(std::string_view key, std::string message) const;

 private:
  JsonSection(const JsonDocument& document, const nlohmann::json& object, std::string pointer);
  [[nodiscard]] const nlohmann::json& at(std::string_view key) const;
  [[nodiscard]] std::int64_t int64(std::string_view key) const;
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;
  [[nodiscard]] Nanometers as_length(std::string_view key, double number) const;
  [[nodiscard]] Duration as_duration(std::string_view key, double number) const;

  const JsonDocument& document_;
  const nlohmann::json& object_;
  std::string pointer_;
};

}  // namespace contourd
