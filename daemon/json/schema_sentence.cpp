#include "daemon/json/schema_sentence.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "daemon/json/config_error.hpp"

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

}  // namespace

std::string unit_of(std::string_view pointer) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kUnits{{
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
    for (const auto& [ending, unit] : kUnits) {
      if (pointer.ends_with(ending)) return " " + std::string(unit);
    }
    pointer = pointer.substr(0, pointer.rfind('/'));
  }
  return {};
}

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

}  // namespace contourd
