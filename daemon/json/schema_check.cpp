#include "daemon/json/schema_check.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/system/utf_8.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// Returns the Levenshtein distance.
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

// Returns ` mm` for ".../travel_mm", from the pointer's last key that ends in a unit; empty if there is none.
std::string unit_of(std::string_view pointer) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kUnits{{
      // Longer endings first: mm/s before s.
      {"_mpa_s", "mPa s"},
      {"_mw_cm2", "mW/cm²"},
      {"_mj_cm2", "mJ/cm²"},
      {"_per_mm", "per mm"},
      {"_mm_s2", "mm/s2"},
      {"_mm_s3", "mm/s3"},
      {"_mm_s", "mm/s"},
      {"_n_mm", "N/mm"},
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
    for (const auto& [ending, unit] : kUnits) {
      if (pointer.ends_with(ending)) return " " + std::string(unit);
    }
    pointer = pointer.substr(0, pointer.rfind('/'));
  }
  return {};
}

// Returns a description of the value for use after "found".
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

// Joins the words with `between`.
std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

// Returns the message about an unknown key. It suggests the known key that was probably meant, or lists all
// of them.
std::string unknown_key(const std::string& key, const std::vector<std::string>& known) {
  std::size_t best = std::max<std::size_t>(2, key.size() / 3) + 1;
  std::string closest;
  std::vector<std::string> quoted;
  for (const std::string& name : known) {
    quoted.push_back(in_quotes(name));
    if (key.size() >= name.size() + best) continue;  // the distance is at least `best`
    const std::size_t distance = edit_distance(key, name);
    if (distance < best && distance < name.size()) {
      best = distance;
      closest = name;
    }
  }
  const std::string sentence = "there is no key " + in_quotes(key) + " here; ";
  if (!closest.empty()) return sentence + "did you mean " + in_quotes(closest) + "?";
  return sentence + "the known keys are " + joined(quoted, ", ");
}

// The violations found so far, up to a limit.
class Findings {
 public:
  struct Finding {
    std::string pointer, message;
  };

  explicit Findings(std::size_t most) : most_(most) {}

  void add(std::string pointer, std::string message) {
    if (!full()) findings_.push_back({std::move(pointer), std::move(message)});
  }
  [[nodiscard]] bool full() const { return findings_.size() == most_; }
  [[nodiscard]] const std::vector<Finding>& all() const { return findings_; }

 private:
  std::size_t most_;
  std::vector<Finding> findings_;
};

// Checks the value against the schema `named`. That schema describes the value in messages, even if its rules
// are those of a schema that it refers to.
void check(const SchemaNode& named, const json& value, const std::string& pointer, Findings& findings);

bool fits(const SchemaNode& schema, const json& value) {
  Findings first(1);
  check(schema, value, "", first);
  return first.all().empty();
}

// Returns the number. The type holds every number of a document exactly.
long double number(const json& value) {
  static_assert(std::numeric_limits<long double>::digits >= 64);
  return value.get<long double>();
}

// Compares by JSON Schema's rules: 1 equals 1.0, but not true. Recursion is bounded by the schema's depth.
bool is_equal(const json& a, const json& b) {
  if (a.is_number() && b.is_number()) return number(a) == number(b);
  if (a.type() != b.type() || a.size() != b.size()) return false;
  if (a.is_array()) return std::equal(a.begin(), a.end(), b.begin(), is_equal);
  if (!a.is_object()) return a == b;
  return std::ranges::all_of(a.items(), [&](const auto& member) {
    const auto other = b.find(member.key());
    return other != b.end() && is_equal(member.value(), *other);
  });
}

std::optional<std::string> wrong_type(const SchemaNode& rules, const json& value) {
  std::vector<std::string> expected;
  for (const JsonType* type : rules.types) {
    if (type->fits(value)) return std::nullopt;
    expected.emplace_back(type->expected);
  }
  if (expected.empty()) return std::nullopt;
  return "expected " + joined(expected, " or ") + ", found " + found(value);
}

std::optional<std::string> not_listed(const SchemaNode& rules, const json& value) {
  const auto is_value = [&](const json& allowed) { return is_equal(allowed, value); };
  if (rules.enumeration.empty() || std::ranges::any_of(rules.enumeration, is_value)) return std::nullopt;
  std::vector<std::string> words;
  for (const json& word : rules.enumeration)
    words.push_back(word.dump());
  return found(value) + " is not " + (words.size() > 1 ? "one of " : "") + joined(words, ", ");
}

std::optional<std::string> wrong_number(const SchemaNode& rules, const json& value,
                                        const std::string& pointer) {
  if (!value.is_number()) return std::nullopt;
  if (rules.maximum && number(value) > number(*rules.maximum))
    return value.dump() + " is more than the limit, " + rules.maximum->dump() + unit_of(pointer);
  if (rules.minimum && number(value) < number(*rules.minimum))
    return value.dump() + " is less than the least allowed, " + rules.minimum->dump() + unit_of(pointer);
  return std::nullopt;
}

std::optional<std::string> wrong_text(const SchemaNode& named, const SchemaNode& rules, const json& value) {
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  const std::size_t length = code_points(text).size();
  const auto is_long = [&](const char* what, std::size_t limit) {
    return in_quotes(text) + " is " + std::to_string(length) + " characters long; " + what + " " +
           std::to_string(limit);
  };
  const bool is_too_short = rules.min_length && length < *rules.min_length;
  const bool has_pattern = !rules.pattern || rules.pattern->is_in(text);
  if (text.empty() && (is_too_short || !has_pattern)) return "it must not be empty";
  if (rules.max_length && length > *rules.max_length) return is_long("the limit is", *rules.max_length);
  if (is_too_short) return is_long("it must have at least", *rules.min_length);
  if (!has_pattern) return in_quotes(text) + " is not allowed: " + named.description_here();
  return std::nullopt;
}

std::optional<std::string> wrong_size(const SchemaNode& rules, const json& value) {
  if (!value.is_array()) return std::nullopt;
  const auto there_are = [&](const char* what, std::size_t limit) {
    return "there are " + std::to_string(value.size()) + " in this list; " + what + " " +
           std::to_string(limit);
  };
  if (rules.min_items && value.size() < *rules.min_items)
    return there_are("it must have at least", *rules.min_items);
  if (rules.max_items && value.size() > *rules.max_items) return there_are("the limit is", *rules.max_items);
  return std::nullopt;
}

// True if the branch only names keys that must be present and keys (of the other branches) that must not be.
bool is_key_set(const SchemaNode& branch) {
  return !branch.required.empty() && std::ranges::all_of(branch.properties, [](const auto& property) {
    return property.second->followed().is_false;
  });
}

std::string wrong_keys(const SchemaNode& rules, const json& value) {
  std::vector<std::string> choices;
  std::vector<std::string> present;
  for (const SchemaNode* branch : rules.one_of) {
    std::vector<std::string> keys;
    for (const std::string& key : branch->followed().required) {
      keys.push_back(json(key).dump());
      if (value.contains(key)) present.push_back(keys.back());
    }
    choices.push_back(joined(keys, " and "));
  }
  return "give either " + joined(choices, ", or ") + "; found " +
         (present.empty() ? "neither" : (present.size() == 1 ? "only " : "") + joined(present, " and "));
}

std::optional<std::string> wrong_choice(const SchemaNode& rules, const json& value) {
  if (rules.one_of.empty()) return std::nullopt;
  const auto fitting =
      std::ranges::count_if(rules.one_of, [&](const SchemaNode* branch) { return fits(*branch, value); });
  if (fitting == 1) return std::nullopt;
  const bool are_key_sets = std::ranges::all_of(
      rules.one_of, [](const SchemaNode* branch) { return is_key_set(branch->followed()); });
  if (value.is_object() && are_key_sets) return wrong_keys(rules, value);
  return "it must fit exactly one of the schema's " + std::to_string(rules.one_of.size()) +
         " alternatives; it fits " + std::to_string(fitting);
}

void check_elements(const SchemaNode& rules, const json& list, const std::string& pointer,
                    Findings& findings) {
  if (rules.items == nullptr) return;
  for (std::size_t i = 0; i < list.size() && !findings.full(); ++i)
    check(*rules.items, list[i], child_pointer(pointer, std::to_string(i)), findings);
}

void check_unknown_key(const SchemaNode& rules, const std::string& key, const json& value,
                       const std::string& pointer, Findings& findings) {
  if (rules.additional_properties == nullptr) return;
  if (!rules.additional_properties->followed().is_false)
    return check(*rules.additional_properties, value, pointer, findings);
  std::vector<std::string> known;
  for (const auto& [name, property] : rules.properties)
    known.push_back(name);
  findings.add(pointer, unknown_key(key, known));
}

void check_members(const SchemaNode& rules, const json& object, const std::string& pointer,
                   Findings& findings) {
  for (const auto& member : object.items()) {
    if (findings.full()) return;
    const std::string place = child_pointer(pointer, member.key());
    const auto property = rules.properties.find(member.key());
    if (property == rules.properties.end()) {
      check_unknown_key(rules, member.key(), member.value(), place, findings);
    } else {
      check(*property->second, member.value(), place, findings);
    }
  }
  for (const std::string& key : rules.required) {
    if (object.contains(key)) continue;
    const auto property = rules.properties.find(key);
    const SchemaNode none;
    const SchemaNode& missing = property == rules.properties.end() ? none : *property->second;
    findings.add(child_pointer(pointer, key), "this key is missing: " + missing.description_here());
  }
}

void check(const SchemaNode& named, const json& value, const std::string& pointer, Findings& findings) {
  const SchemaNode& rules = named.followed();
  if (rules.is_false) return findings.add(pointer, "it is not allowed here");
  if (const auto sentence = wrong_type(rules, value)) return findings.add(pointer, *sentence);
  for (const auto& sentence :
       {not_listed(rules, value), wrong_number(rules, value, pointer), wrong_text(named, rules, value),
        wrong_size(rules, value), wrong_choice(rules, value)}) {
    if (sentence) findings.add(pointer, *sentence);
  }
  if (value.is_array()) check_elements(rules, value, pointer, findings);
  if (value.is_object()) check_members(rules, value, pointer, findings);
}

}  // namespace

void check_by_schema(const SchemaNode& schema, JsonDocument& document) {
  Findings findings(kMaxViolations);
  check(schema, document.value(), "", findings);
  for (const Findings::Finding& finding : findings.all())
    document.add_violation(finding.pointer, finding.message);
}

void fill_defaults(const SchemaNode& schema, json& value) {
  const SchemaNode& rules = schema.followed();
  if (value.is_array() && rules.items != nullptr) {
    for (json& item : value)
      fill_defaults(*rules.items, item);
  }
  if (!value.is_object()) return;
  for (const auto& [key, property] : rules.properties) {
    const json* missing = property->default_here();
    if (missing != nullptr && !value.contains(key)) value[key] = *missing;
    if (value.contains(key)) fill_defaults(*property, value[key]);
  }
}

}  // namespace contourd
