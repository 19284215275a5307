#include "daemon/json/json_section.hpp"

#include <cmath>
#include <optional>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

bool is_length(std::string_view key) {
  return key.ends_with("_mm") || key.ends_with("_um");
}
bool is_duration(std::string_view key) {
  return key.ends_with("_s") || key.ends_with("_ms") || key.ends_with("_us");
}

}  // namespace

JsonSection::JsonSection(const JsonDocument& document) : JsonSection(document, document.value(), "") {}

JsonSection::JsonSection(const JsonDocument& document, const nlohmann::json& object, std::string pointer)
    : document_(document), object_(object), pointer_(std::move(pointer)) {
  if (!object_.is_object()) throw ConfigError({{document_.file(), pointer_, "expected an object"}});
}

void JsonSection::reject(std::string_view key, std::string message) const {
  throw ConfigError({{document_.file(), child_pointer(pointer_, key), std::move(message)}});
}

const nlohmann::json& JsonSection::at(std::string_view key) const {
  const auto member = object_.find(std::string(key));
  if (member == object_.end()) reject(key, "this key is missing");
  return *member;
}

bool JsonSection::has(std::string_view key) const {
  return object_.contains(std::string(key));
}

JsonSection JsonSection::section(std::string_view key) const {
  return {document_, at(key), child_pointer(pointer_, key)};
}

bool JsonSection::is_section(std::string_view key) const {
  return at(key).is_object();
}

bool JsonSection::is_list(std::string_view key) const {
  return at(key).is_array();
}

std::vector<JsonSection> JsonSection::sections(std::string_view key) const {
  const nlohmann::json& list = at(key);
  if (!list.is_array()) reject(key, "expected a list");
  std::vector<JsonSection> all;
  const std::string place = child_pointer(pointer_, key);
  for (std::size_t i = 0; i < list.size(); ++i)
    all.push_back(JsonSection(document_, list[i], child_pointer(place, std::to_string(i))));
  return all;
}

std::vector<std::string> JsonSection::texts(std::string_view key) const {
  const nlohmann::json& list = at(key);
  if (!list.is_array()) reject(key, "expected a list");
  std::vector<std::string> all;
  for (const nlohmann::json& each : list) {
    if (!each.is_string()) reject(key, "expected a list of texts");
    all.push_back(each.get<std::string>());
  }
  return all;
}

bool JsonSection::boolean(std::string_view key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_boolean()) reject(key, "expected true or false");
  return value.get<bool>();
}

std::string JsonSection::text(std::string_view key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_string()) reject(key, "expected a text");
  return value.get<std::string>();
}

std::string JsonSection::text_or_digits(std::string_view key) const {
  return at(key).is_number() ? std::to_string(int64(key)) : text(key);
}

double JsonSection::number(std::string_view key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_number() || !std::isfinite(value.get<double>())) reject(key, "expected a number");
  return value.get<double>();
}

std::int64_t JsonSection::int64(std::string_view key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_number_integer()) reject(key, "expected a whole number");
  if (value.is_number_unsigned() && !std::in_range<std::int64_t>(value.get<std::uint64_t>())) {
    reject(key, value.dump() + " is out of range");
  }
  return value.get<std::int64_t>();
}

std::vector<double> JsonSection::numbers(std::string_view key) const {
  const nlohmann::json& list = at(key);
  if (!list.is_array()) reject(key, "expected a list");
  std::vector<double> numbers;
  for (const nlohmann::json& value : list) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) reject(key, "expected numbers");
    numbers.push_back(value.get<double>());
  }
  return numbers;
}

Nanometers JsonSection::as_length(std::string_view key, double number) const {
  const std::optional<Nanometers> length =
      to_nanometers(Millimeters{key.ends_with("_um") ? number / 1e3 : number});
  if (!length) reject(key, "this length is out of range");
  return *length;
}

Duration JsonSection::as_duration(std::string_view key, double number) const {
  const double unit_ns = key.ends_with("_ms") ? 1e6 : key.ends_with("_us") ? 1e3 : 1e9;
  const double duration_ns = number * unit_ns;
  constexpr double kHundredYearsNs = 3.2e18;  // int64 nanoseconds overflow after 292 years
  if (!(std::fabs(duration_ns) <= kHundredYearsNs)) reject(key, "this duration is out of range");
  return Duration{std::llround(duration_ns)};
}

Nanometers JsonSection::length(std::string_view key) const {
  expects(is_length(key), "the key ends in a length's unit");
  return as_length(key, number(key));
}

Duration JsonSection::duration(std::string_view key) const {
  expects(is_duration(key), "the key ends in a duration's unit");
  return as_duration(key, number(key));
}

std::vector<Nanometers> JsonSection::lengths(std::string_view key) const {
  expects(is_length(key), "the key ends in a length's unit");
  std::vector<Nanometers> lengths;
  for (const double each : numbers(key))
    lengths.push_back(as_length(key, each));
  return lengths;
}

std::vector<Duration> JsonSection::durations(std::string_view key) const {
  expects(is_duration(key), "the key ends in a duration's unit");
  std::vector<Duration> durations;
  for (const double each : numbers(key))
    durations.push_back(as_duration(key, each));
  return durations;
}

}  // namespace contourd
