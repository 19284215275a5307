#include "daemon/web/hosts/nanodlp_replies.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>
#include <utility>

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

// Returns the usable profiles.
std::vector<Json> usable(const Json& resins) {
  std::vector<Json> usable;
  const auto found = resins.find("resins");
  if (found == resins.end() || !found->is_array()) return usable;
  for (const Json& resin : *found)
    if (resin.is_object() && resin.contains("resin") && resin["resin"].is_string() &&
        resin.value("trouble", Json()).is_null())
      usable.push_back(resin);
  return usable;
}

std::uint32_t id_of_resin(const Json& resin) {
  return id_of(resin["resin"].get<std::string>());
}

}  // namespace

Json nanodlp_status(const HostStatus& status, std::string_view version) {
  constexpr double kStepsPerMm = 6400;
  // DragonFruit talks to models of Athena only; a name of another one would make it refuse the printer.
  Json reply{{"Model", "contourd (Athena)"},
             {"Name", status.printer},
             {"Build", fmt::format("contourd {}", version)},
             {"Version", version},
             {"State", static_cast<int>(status.phase)},
             {"Status", status.text},
             {"Printing", status.job.has_value()},
             {"Paused", status.phase == HostPhase::Paused},
             {"Curing", status.is_lit},
             {"Path", status.job ? status.job->name : ""}};
  if (status.height_mm) reply["CurrentHeight"] = std::llround(*status.height_mm * kStepsPerMm);
  if (status.layer) {
    reply["LayerID"] = *status.layer;
    reply["LayersCount"] = status.layers;
    // Clients take a number up to 1 for a fraction, and above for percent.
    if (status.layers > 0)
      reply["Progress"] = static_cast<double>(*status.layer) / static_cast<double>(status.layers);
  }
  if (status.job) {
    reply["PlateID"] = status.job->id();
    reply["TimeRemain"] = std::llround(status.time_left_s);
  }
  return reply;
}

Json nanodlp_plates(const std::vector<HostJob>& jobs) {
  Json plates = Json::array();
  for (const HostJob& job : jobs) {
    Json plate{{"PlateID", job.id()}, {"Path", job.name}, {"Preview", true}, {"FileSize", job.bytes}};
    if (!job.resin.empty()) plate["ProfileName"] = job.resin;
    if (job.layers > 0) {
      plate["LayersCount"] = plate["LayerCount"] = job.layers;
      plate["LayerThickness"] = job.layer_um;
      plate["LayerHeight"] = job.layer_um / 1000;
      plate["PrintTime"] = std::llround(job.print_time_s);
      plate["UsedMaterial"] = job.resin_ml;
    }
    plates.push_back(std::move(plate));
  }
  return plates;
}

Json nanodlp_profiles(const Json& resins) {
  Json profiles = Json::array();
  for (const Json& resin : usable(resins)) {
    Json profile{{"ProfileID", id_of_resin(resin)}, {"Title", resin["resin"]}, {"locked", true}};
    const auto copy = [&](const char* to, const char* from, double factor) {
      if (const Json figure = resin.value(from, Json()); figure.is_number())
        profile[to] = figure.get<double>() * factor;
    };
    copy("Depth", "layer_height_um", 1);
    copy("CureTime", "exposure_ms", 0.001);
    copy("SupportCureTime", "bottom_exposure_ms", 0.001);
    copy("WaitHeight", "lift_mm", 1);
    if (const Json layers = resin.value("bottom_layers", Json()); layers.is_number_integer())
      profile["SupportLayerNumber"] = layers;
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

Json nanodlp_machine(const std::string& printer, const Json& resins) {
  Json machine{{"Name", printer}, {"CustomValues", Json::object()}};
  for (const Json& resin : usable(resins))
    if (resin.value("is_default", Json()) == Json(true)) machine["DefaultProfile"] = id_of_resin(resin);
  return machine;
}

std::optional<std::string> nanodlp_resin(const Json& resins, std::string_view number) {
  const std::optional<std::uint32_t> id = nanodlp_number(number);
  std::optional<std::string> name;
  for (const Json& resin : usable(resins)) {
    if (!id || id_of_resin(resin) != *id) continue;
    if (name) return std::nullopt;
    name = resin["resin"].get<std::string>();
  }
  return name;
}

std::optional<std::uint32_t> nanodlp_number(std::string_view text) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number == 0) return std::nullopt;
  return number;
}

}  // namespace contourd::web
