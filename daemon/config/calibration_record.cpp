#include "daemon/config/calibration_record.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <stdexcept>

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMost = 100;  // as in resin.schema.json
constexpr const char* kKept = "calibrations";

// Returns the value at that place; null if there is none.
Json value_at(const Json& object, const Json::json_pointer& place) {
  return object.contains(place) ? object.at(place) : Json();
}

// Sets a value, or removes it and a section that it leaves empty.
void set(Json& object, const Json::json_pointer& place, const Json& value) {
  if (!value.is_null()) {
    object[place] = value;
    return;
  }
  if (!object.contains(place)) return;
  Json& section = object.at(place.parent_pointer());
  section.erase(place.back());
  if (section.empty() && !place.parent_pointer().empty()) object.erase(place.parent_pointer().back());
}

std::string text_of(const Json& object) {
  return object.dump(2) + "\n";
}

}  // namespace

std::string with_calibration(const std::string& text, const Calibration& calibration) {
  Json object = Json::parse(text);
  Json kept{{"kind", calibration.kind}, {"date", calibration.date}};
  if (calibration.lamp_hours) kept["lamp_hours"] = *calibration.lamp_hours;
  kept["values"] = Json::array();
  for (const auto& [key, value, uncertainty, correlation] : calibration.values) {
    const Json::json_pointer place(key);
    Json of_value{{"key", key}};
    if (const Json before = value_at(object, place); !before.is_null()) of_value["before"] = before;
    if (!value.is_null()) of_value["after"] = value;
    if (uncertainty) of_value["uncertainty"] = *uncertainty;
    if (correlation) of_value["correlation"] = *correlation;
    kept["values"].push_back(std::move(of_value));
    set(object, place, value);
  }
  Json& all = object[kKept];
  while (all.size() >= kMost)
    all.erase(0);
  all.push_back(std::move(kept));
  return text_of(object);
}

std::optional<CalibratedError> calibrated_error(const std::string& text, const std::string& key) {
  const Json object = Json::parse(text);
  const Json now = value_at(object, Json::json_pointer(key));
  std::optional<CalibratedError> error;
  for (const Json& calibration : object.value(kKept, Json::array()))
    for (const Json& value : calibration["values"]) {
      if (value["key"] != key) continue;
      error.reset();
      if (value.contains("uncertainty") && value.value("after", Json()) == now)
        error = {value["uncertainty"].get<double>(), value.value("correlation", 0.0)};
    }
  return error;
}

UndoneCalibration without_last_calibration(const std::string& text) {
  Json object = Json::parse(text);
  if (!object.contains(kKept) || object[kKept].empty())
    throw std::runtime_error("there is no calibration to undo: contourctl fit --accept has written none");
  const Json last = object[kKept].back();
  object[kKept].erase(object[kKept].size() - 1);
  if (object[kKept].empty()) object.erase(kKept);
  // In reverse order, so that a section that the calibration made is empty at its end.
  const Json& values = last["values"];
  for (auto value = values.rbegin(); value != values.rend(); ++value) {
    const auto key = (*value)["key"].get<std::string>();
    const Json::json_pointer place(key);
    const Json now = value_at(object, place), after = value->value("after", Json());
    if (now != after)
      throw std::runtime_error(fmt::format("{} is {}, not {} as the last calibration set it: undo it by hand",
                                           key, now.is_null() ? "absent" : now.dump(),
                                           after.is_null() ? "absent" : after.dump()));
    set(object, place, value->value("before", Json()));
  }
  return {text_of(object), last["kind"].get<std::string>(), last["date"].get<std::string>()};
}

}  // namespace contourd
