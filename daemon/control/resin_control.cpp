#include "daemon/control/resin_control.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/resin_profile.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

using Json = ResinControl::Json;

namespace {

constexpr std::size_t kLongestTrouble = 500;

double micrometers(Nanometers length) {
  return 1000 * to_millimeters(length).count();
}

Json value_json(const nlohmann::json& value) {
  const auto given = [&value](const char* key) { return value.contains(key) ? Json(value[key]) : Json(); };
  return {{"key", value["key"]},
          {"before", given("before")},
          {"after", given("after")},
          {"uncertainty", given("uncertainty")}};
}

// Returns the last calibrations of a profile that is valid, the latest first.
Json calibrations_json(const nlohmann::json& profile) {
  Json all = Json::array();
  const nlohmann::json recorded = profile.value("calibrations", nlohmann::json::array());
  for (auto each = recorded.rbegin(); each != recorded.rend(); ++each) {
    if (all.size() == ResinControl::kMostCalibrations) break;
    Json values = Json::array();
    for (const nlohmann::json& value : (*each)["values"])
      values.push_back(value_json(value));
    all.push_back({{"kind", (*each)["kind"]},
                   {"date", (*each)["date"]},
                   {"lamp_hours", each->contains("lamp_hours") ? Json((*each)["lamp_hours"]) : Json()},
                   {"values", std::move(values)}});
  }
  return all;
}

void add_figures(Json& reply, const ResinProfile& resin, double irradiance_mw_cm2) {
  const auto exposure_ms = [&](int layer) {
    return figure_of(exposure_time(resin, resin.layer_height, layer, irradiance_mw_cm2));
  };
  reply["layer_height_um"] = micrometers(resin.layer_height);
  reply["layer_height_min_um"] = micrometers(resin.layer_height_min);
  reply["layer_height_max_um"] = micrometers(resin.layer_height_max);
  reply["exposure_ms"] = exposure_ms(resin.bottom_layers + resin.fade_layers);
  reply["bottom_exposure_ms"] = exposure_ms(0);
  reply["bottom_layers"] = resin.bottom_layers;
  reply["lift_mm"] = figure_of(resin.motion.whole_lift());
  reply["continuous"] = resin.mode == PrintWay::Continuous;
}

Json resin_json(const PrinterConfig& printer, const std::string& name) {
  Json reply{{"resin", name}, {"is_default", name == printer.resin}, {"trouble", nullptr}};
  for (const char* key : {"layer_height_um", "layer_height_min_um", "layer_height_max_um", "exposure_ms",
                          "bottom_exposure_ms", "bottom_layers", "lift_mm", "continuous"})
    reply[key] = nullptr;
  reply["calibrations"] = Json::array();
  try {
    add_figures(reply, find_resin(printer, name), printer.irradiance_mw_cm2);
    reply["calibrations"] =
        calibrations_json(JsonDocument::from_file(printer.resins_folder / (name + ".json")).value());
  } catch (const ConfigError& error) {
    reply["trouble"] = shortened(error.in_one_line(), kLongestTrouble);
  }
  return reply;
}

}  // namespace

ControlMethods ResinControl::methods() {
  return {{"resins",
           {.description = "Lists the resin profiles, with the calibrations in them.",
            .call_later = [this](const Json&, const ControlCaller&, ControlMethod::Later later) {
              spool_.run([&config = config_] { return resins_json(config); }, std::move(later));
            }}}};
}

Json resins_json(const PrinterConfig& printer) {
  std::vector<std::string> names = profiles_in(printer.resins_folder);
  std::ranges::sort(names);
  Json resins = Json::array();
  for (const std::string& name : names) {
    if (resins.size() == ResinControl::kMostResins) break;
    resins.push_back(resin_json(printer, name));
  }
  return {{"resins", std::move(resins)}, {"more", names.size() - resins.size()}};
}

}  // namespace contourd
