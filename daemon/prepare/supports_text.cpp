#include "daemon/prepare/supports_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/config/support_figures.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

// Maximum number of places that a sentence names.
constexpr std::size_t kMaxNamedPlaces = 3;

Json contact_json(const SupportContact& contact) {
  return {{"cause", name_of(contact.cause)},
          {"plate_mm", {contact.place.x, contact.place.y, contact.place.z}},
          {"outward", {contact.outward.x, contact.outward.y, contact.outward.z}},
          {"load_mm2", contact.load_mm2}};
}

}  // namespace

std::string supports_line(const SupportCounts& supports) {
  if (!supports.any()) return "none needed";
  std::string text =
      fmt::format("{} ({} at islands, {} at overhangs, {} against peel), {}, {}",
                  count_of(supports.contacts(), "contact", "contacts"), supports.islands, supports.overhangs,
                  supports.peel, count_of(supports.branches, "branch", "branches"),
                  count_of(supports.feet, "foot", "feet"));
  if (supports.feet_on_models > 0) text += fmt::format(", {} on the model", supports.feet_on_models);
  text += fmt::format(", {:.2f} ml", supports.volume_mm3 / 1000);
  if (supports.unheld > 0) text += fmt::format("; {} not held", count_of(supports.unheld, "place", "places"));
  return text;
}

std::string unheld_text(const UnheldPlace& place) {
  const SupportContact& contact = place.contact;
  return fmt::format(
      "at {:.2f}, {:.2f} mm from the plate's centre, {:.2f} mm above the plate ({}, {:.3g} mm²): {}",
      contact.place.x, contact.place.y, contact.place.z, name_of(contact.cause), contact.load_mm2, place.why);
}

std::string unheld_sentence(const std::vector<UnheldPlace>& places) {
  if (places.empty()) return "";
  std::string text = count_of(places.size(), "place cannot", "places cannot") + " be held:";
  for (std::size_t i = 0; i < std::min(kMaxNamedPlaces, places.size()); ++i)
    text += (i == 0 ? " " : "; ") + unheld_text(places[i]);
  if (places.size() > kMaxNamedPlaces) text += fmt::format("; and {} more", places.size() - kMaxNamedPlaces);
  return text;
}

Json support_settings_json(const SupportSettings& settings) {
  Json json = Json::object();
  for (const SupportFigure& figure : support_figures())
    json[std::string(figure.key)] = figure.get(settings);
  return json;
}

Json supports_summary_json(const SupportCounts& supports) {
  return {{"contacts", supports.contacts()},
          {"islands", supports.islands},
          {"overhangs", supports.overhangs},
          {"peel", supports.peel},
          {"branches", supports.branches},
          {"feet", supports.feet},
          {"feet_on_models", supports.feet_on_models},
          {"volume_mm3", supports.volume_mm3},
          {"unheld", supports.unheld}};
}

SupportCounts supports_in_summary(const Json& summary) {
  return {.islands = summary.at("islands"),
          .overhangs = summary.at("overhangs"),
          .peel = summary.at("peel"),
          .unheld = summary.at("unheld"),
          .branches = summary.at("branches"),
          .feet = summary.at("feet"),
          .feet_on_models = summary.at("feet_on_models"),
          .volume_mm3 = summary.at("volume_mm3")};
}

Json supports_json(const Supports& supports) {
  Json json = supports_summary_json(counts_of(supports));
  json["contact_list"] = Json::array();
  for (const SupportContact& contact : supports.contacts)
    json["contact_list"].push_back(contact_json(contact));
  json["unheld_list"] = Json::array();
  for (const UnheldPlace& place : supports.unheld) {
    json["unheld_list"].push_back(contact_json(place.contact));
    json["unheld_list"].back()["why"] = place.why;
  }
  return json;
}

}  // namespace contourd
