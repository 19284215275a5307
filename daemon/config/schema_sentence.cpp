#include "daemon/config/schema_sentence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace contourd {
namespace {

using nlohmann::json;

// ` mm` for ".../travel_mm", by the pointer's last key that ends in a unit; nothing for a plain number.
std::string unit_of(std::string_view pointer) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 15> units{{
      // Longer endings first: mm/s before s.
      {"_mw_cm2", "mW/cm2"},
      {"_mj_cm2", "mJ/cm2"},
      {"_per_mm", "per mm"},
      {"_mm_s2", "mm/s2"},
      {"_mm_s3", "mm/s3"},
      {"_mm_s", "mm/s"},
      {"_deg", "degrees"},
      {"_mm", "mm"},
      {"_um", "um"},
      {"_px", "px"},
      {"_ms", "ms"},
      {"_us", "us"},
      {"_mb", "MB"},
      {"_hz", "Hz"},
      {"_s", "s"},
  }};
  while (!pointer.empty()) {
    for (const auto& [ending, unit] : units) {
      if (pointer.ends_with(ending)) return " " + std::string(unit);
    }
    pointer = pointer.substr(0, pointer.rfind('/'));
  }
  return {};
}

// The value as a message shows it, after "found".
std::string found(const json& value) {
  switch (value.type()) {
    case json::value_t::object:
      return "an object";
    case json::value_t::array:
      return "an array";
    case json::value_t::string:
      return "the text " + in_quotes(value.get_ref<const std::string&>());
    default:
      return value.dump();
  }
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

std::string description_of(const json& schema) {
  std::string text = schema.value("description", std::string("see the schema"));
  while (text.ends_with('.'))
    text.pop_back();
  return text;
}

bool is_whole(const json& value) {
  return value.is_number_integer() || (value.is_number_float() && std::trunc(value.get<double>()) == value);
}

struct JsonType {
  std::string_view name, expected;
  bool (*fits)(const json&);
};

constexpr std::array<JsonType, 6> kTypes{{
    {"object", "an object", [](const json& value) { return value.is_object(); }},
    {"array", "a list", [](const json& value) { return value.is_array(); }},
    {"string", "a text", [](const json& value) { return value.is_string(); }},
    {"boolean", "true or false", [](const json& value) { return value.is_boolean(); }},
    {"number", "a number", [](const json& value) { return value.is_number(); }},
    // A whole number too large for an integer is out of range, not of the wrong type.
    {"integer", "a whole number", is_whole},
}};

// `type` is one name or a list of them.
std::optional<std::string> wrong_type(const json& schema, const json& value) {
  if (!schema.contains("type")) return std::nullopt;
  const json names = schema["type"].is_array() ? schema["type"] : json::array({schema["type"]});
  std::vector<std::string> expected;
  for (const JsonType& type : kTypes) {
    if (std::find(names.begin(), names.end(), type.name) == names.end()) continue;
    if (type.fits(value)) return std::nullopt;
    expected.emplace_back(type.expected);
  }
  if (expected.empty()) return std::nullopt;
  return "expected " + joined(expected, " or ") + ", found " + found(value);
}

std::optional<std::string> wrong_length(const json& schema, const json& value) {
  if (!value.is_array()) return std::nullopt;
  const auto says = [&](const char* limit, const char* what) {
    return "there are " + std::to_string(value.size()) + " in this list; " + what + " " +
           schema[limit].dump();
  };
  if (schema.contains("minItems") && value.size() < schema["minItems"].get<std::size_t>())
    return says("minItems", "it must have at least");
  if (schema.contains("maxItems") && value.size() > schema["maxItems"].get<std::size_t>())
    return says("maxItems", "the limit is");
  return std::nullopt;
}

std::optional<std::string> wrong_number(const json& schema, const json& value, const std::string& pointer) {
  if (!value.is_number()) return std::nullopt;
  const auto number = value.get<double>();
  if (schema.contains("maximum") && number > schema["maximum"].get<double>()) {
    return value.dump() + " is more than the limit, " + schema["maximum"].dump() + unit_of(pointer);
  }
  if (schema.contains("minimum") && number < schema["minimum"].get<double>()) {
    return value.dump() + " is less than the least allowed, " + schema["minimum"].dump() + unit_of(pointer);
  }
  return std::nullopt;
}

std::size_t characters(std::string_view utf8) {
  return static_cast<std::size_t>(std::count_if(
      utf8.begin(), utf8.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

std::optional<std::string> wrong_text(const json& schema, const json& value) {
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  const std::size_t length = characters(text);
  if (text.empty() && (schema.value("minLength", 0) > 0 || schema.contains("pattern")))
    return "it must not be empty";
  if (schema.contains("maxLength") && length > schema["maxLength"].get<std::size_t>()) {
    return in_quotes(text) + " is " + std::to_string(length) + " characters long; the limit is " +
           schema["maxLength"].dump();
  }
  // A text has no parts to be blamed for: as it was found wrong, what is left is the pattern.
  if (schema.contains("pattern")) return in_quotes(text) + " is not allowed: " + description_of(schema);
  return std::nullopt;
}

std::optional<std::string> not_listed(const json& schema, const json& value) {
  if (!schema.contains("enum")) return std::nullopt;
  const json& allowed = schema["enum"];
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return std::nullopt;
  std::vector<std::string> words;
  for (const json& word : allowed)
    words.push_back(word.dump());
  return found(value) + " is not " + (words.size() > 1 ? "one of " : "") + joined(words, ", ");
}

// Levenshtein's.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

std::string unknown_key(const std::string& key, const json& properties) {
  std::size_t best = std::max<std::size_t>(2, key.size() / 3) + 1;
  std::string closest;
  std::vector<std::string> known;
  for (const auto& property : properties.items()) {
    known.push_back(in_quotes(property.key()));
    const std::size_t distance = edit_distance(key, property.key());
    if (distance < best && distance < property.key().size()) {
      best = distance;
      closest = property.key();
    }
  }
  const std::string sentence = "there is no key " + in_quotes(key) + " here; ";
  if (!closest.empty()) return sentence + "did you mean " + in_quotes(closest) + "?";
  return sentence + "the known ones are " + joined(known, ", ");
}

void explain_keys(const json& schema, const json& value, const std::string& pointer, JsonDocument& document) {
  const json properties = schema.value("properties", json::object());
  if (schema.value("additionalProperties", json(true)) == json(false)) {
    for (const auto& member : value.items()) {
      if (properties.contains(member.key())) continue;
      document.add_violation(child_pointer(pointer, member.key()), unknown_key(member.key(), properties));
    }
  }
  for (const json& required : schema.value("required", json::array())) {
    const auto key = required.get<std::string>();
    if (value.contains(key)) continue;
    document.add_violation(child_pointer(pointer, key),
                           "this key is missing: " + description_of(properties.value(key, json::object())));
  }
}

// oneOf, where each branch is a set of required keys that excludes the other branches' keys.
std::optional<std::string> wrong_choice(const json& schema, const json& value) {
  if (!schema.contains("oneOf")) return std::nullopt;
  std::vector<std::string> choices;
  std::vector<std::string> present;
  std::size_t branches_touched = 0;
  bool one_is_whole = false;
  for (const json& branch : schema["oneOf"]) {
    std::vector<std::string> keys;
    const std::size_t present_before = present.size();
    for (const json& required : branch.value("required", json::array())) {
      keys.push_back(required.dump());
      if (value.contains(required.get<std::string>())) present.push_back(keys.back());
    }
    branches_touched += present.size() > present_before ? 1U : 0U;
    one_is_whole = one_is_whole || present.size() - present_before == keys.size();
    choices.push_back(joined(keys, " and "));
  }
  if (branches_touched == 1 && one_is_whole) return std::nullopt;
  return "give either " + joined(choices, ", or ") + "; found " +
         (present.empty() ? "neither" : (present.size() == 1 ? "only " : "") + joined(present, " and "));
}

}  // namespace

void explain(const json& schema, const json& value, const std::string& pointer, JsonDocument& document) {
  if (const auto sentence = wrong_type(schema, value)) {
    document.add_violation(pointer, *sentence);
    return;
  }
  for (const auto& sentence :
       {not_listed(schema, value), wrong_number(schema, value, pointer), wrong_text(schema, value),
        wrong_length(schema, value), wrong_choice(schema, value)}) {
    if (sentence) document.add_violation(pointer, *sentence);
  }
  if (value.is_object()) explain_keys(schema, value, pointer, document);
}

}  // namespace contourd
