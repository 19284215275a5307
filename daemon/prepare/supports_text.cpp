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

Json contacts_json(const std::vector<SupportContact>& contacts) {
  Json list = Json::array();
  for (const SupportContact& contact : contacts)
    list.push_back(contact_json(contact));
  return list;
}

std::string place_text(const PlatePoint& place) {
  return fmt::format("{} mm from the plate's centre, {} mm above the plate", coordinates({place.x, place.y}),
                     coordinates({place.z}));
}

// Returns the clause, the first place and what to do; empty if there are no contacts.
std::string staying_sentence(const std::vector<SupportContact>& contacts, std::string_view one,
                             std::string_view several, std::string_view advice) {
  if (contacts.empty()) return "";
  std::string text =
      fmt::format("{}: {}at {}", count_of(contacts.size(), one, several),
                  contacts.size() > 1 ? "the lowest " : "", place_text(contacts.front().place));
  return fmt::format("{}; {}", text, advice);
}

}  // namespace

std::string supports_line(const SupportCounts& supports) {
  const std::string own = count_of(supports.carriers, "model carries its own in its file",
                                   "models carry their own in their files");
  if (!supports.any()) return supports.carriers > 0 ? "none added: " + own : "none needed";
  std::string text =
      fmt::format("{} ({} at islands, {} at overhangs, {} against peel), {}, {}",
                  count_of(supports.contacts(), "contact", "contacts"), supports.islands, supports.overhangs,
                  supports.peel, count_of(supports.branches, "branch", "branches"),
                  count_of(supports.feet, "foot", "feet"));
  if (supports.feet_on_models > 0) text += fmt::format(", {} on the model", supports.feet_on_models);
  text += fmt::format(", {:.2f} ml", supports.volume_mm3 / 1000);
  if (supports.carriers > 0) text += "; " + own;
  if (supports.over_gaps > 0)
    text += fmt::format("; {} left", count_of(supports.over_gaps, "overhang over a narrow gap",
                                              "overhangs over narrow gaps"));
  if (supports.unheld > 0) text += fmt::format("; {} not held", count_of(supports.unheld, "place", "places"));
  return text;
}

std::string unheld_text(const UnheldPlace& place) {
  const SupportContact& contact = place.contact;
  return fmt::format("at {} ({}, {:.3g} mm²): {}", place_text(contact.place), name_of(contact.cause),
                     contact.load_mm2, place.why);
}

std::string unheld_sentence(const std::vector<UnheldPlace>& places) {
  if (places.empty()) return "";
  std::string text = count_of(places.size(), "place cannot", "places cannot") + " be held:";
  for (std::size_t i = 0; i < std::min(kMaxNamedPlaces, places.size()); ++i)
    text += (i == 0 ? " " : "; ") + unheld_text(places[i]);
  if (places.size() > kMaxNamedPlaces) text += fmt::format("; and {} more", places.size() - kMaxNamedPlaces);
  return text;
}

std::vector<std::string> staying_sentences(const Supports& supports) {
  std::vector<std::string> sentences{
      staying_sentence(supports.on_hairs, "support holds a part that is one pixel thick and may break off",
                       "supports hold parts that are one pixel thick and may break off",
                       "make the part thicker, or turn the model"),
      staying_sentence(supports.in_hollows, "support stands in a sealed hollow and cannot be taken out",
                       "supports stand in sealed hollows and cannot be taken out",
                       "open the hollow, or turn the model"),
      staying_sentence(supports.in_gaps, "support fills a gap narrower than itself and joins both sides",
                       "supports fill gaps narrower than themselves and join both sides",
                       "widen the gap, or turn the model"),
      staying_sentence(
          supports.over_gaps,
          "overhang is not held over a gap narrower than a support, which would join both sides",
          "overhangs are not held over gaps narrower than a support, which would join both sides",
          "widen the gap, or turn the model"),
      staying_sentence(supports.resting,
                       "part begins above the plate with nothing beneath it, so low that the bottom "
                       "exposures join it to the plate",
                       "parts begin above the plate with nothing beneath them, so low that the bottom "
                       "exposures join them to the plate",
                       "if that is not meant, change the gap or turn the model")};
  std::erase(sentences, "");
  return sentences;
}

std::vector<std::string> supports_warnings(const Supports& supports) {
  std::vector<std::string> warnings = staying_sentences(supports);
  if (!supports.unheld.empty()) warnings.insert(warnings.begin(), unheld_sentence(supports.unheld));
  return warnings;
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
          {"unheld", supports.unheld},
          {"over_gaps", supports.over_gaps},
          {"carriers", supports.carriers}};
}

SupportCounts supports_in_summary(const Json& summary) {
  return {.islands = summary.at("islands"),
          .overhangs = summary.at("overhangs"),
          .peel = summary.at("peel"),
          .unheld = summary.at("unheld"),
          .over_gaps = summary.at("over_gaps"),
          .branches = summary.at("branches"),
          .feet = summary.at("feet"),
          .feet_on_models = summary.at("feet_on_models"),
          .carriers = summary.at("carriers"),
          .volume_mm3 = summary.at("volume_mm3")};
}

Json supports_json(const Supports& supports) {
  Json json = supports_summary_json(counts_of(supports));
  json["contact_list"] = contacts_json(supports.contacts);
  json["on_hair_list"] = contacts_json(supports.on_hairs);
  json["in_hollow_list"] = contacts_json(supports.in_hollows);
  json["in_gap_list"] = contacts_json(supports.in_gaps);
  json["over_gap_list"] = contacts_json(supports.over_gaps);
  json["resting_list"] = contacts_json(supports.resting);
  json["unheld_list"] = Json::array();
  for (const UnheldPlace& place : supports.unheld) {
    json["unheld_list"].push_back(contact_json(place.contact));
    json["unheld_list"].back()["why"] = place.why;
  }
  return json;
}

}  // namespace contourd
