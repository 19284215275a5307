#include "daemon/report/cured_part_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "daemon/report/first_items.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

Json place_json(const CurePlace& place) {
  return {place.plate_mm.x, place.plate_mm.y, place.height_mm};
}

Json distances_json(const SurfaceDistances& distances) {
  Json json{{"places", distances.places}, {"missing", distances.missing}};
  if (distances.places == 0) return json;
  json["median_um"] = distances.median_um;
  json["p95_um"] = distances.p95_um;
  json["worst_um"] = distances.worst_um;
  json["worst_mm"] = place_json(distances.worst);
  return json;
}

std::string cut_copies_text(const std::vector<CutCopy>& copies) {
  constexpr std::size_t kMost = 10;
  std::string text;
  for (const CutCopy& each : first_items(copies, kMost))
    text +=
        fmt::format("{}copy {} up to {:.3f} mm", text.empty() ? "" : ", ", each.number + 1, each.up_to_mm);
  if (copies.size() > kMost) text += fmt::format(" and {} more", copies.size() - kMost);
  return text + ": compared as far as they were printed";
}

Json cut_copies_json(const std::vector<CutCopy>& copies) {
  Json list = Json::array();
  for (const CutCopy& each : copies)
    list.push_back({{"number", each.number + 1}, {"up_to_mm", each.up_to_mm}});
  return list;
}

}  // namespace

std::string pixel_light_text(const PixelLight& light) {
  double sum = 0;
  for (const auto& gaussian : light.gaussians)
    sum += gaussian.share;
  std::string text;
  for (const auto& [sigma_pixels, share] : light.gaussians) {
    text += fmt::format("{}sigma {:.3g} pixels", text.empty() ? "" : ", ", sigma_pixels);
    if (light.gaussians.size() > 1) text += fmt::format(" ({:.3g} %)", 100 * share / sum);
  }
  return text;
}

Json pixel_light_json(const PixelLight& light) {
  Json json = Json::array();
  for (const auto& [sigma_pixels, share] : light.gaussians)
    json.push_back({{"sigma_pixels", sigma_pixels}, {"share", share}});
  return json;
}

std::string place_text(const CurePlace& place) {
  return fmt::format("at {} mm, {} mm above the plate", coordinates({place.plate_mm.x, place.plate_mm.y}),
                     coordinates({place.height_mm}));
}

std::string distances_text(const SurfaceDistances& distances) {
  if (distances.places + distances.missing == 0) return "none";
  std::string text;
  if (distances.places > 0)
    text = fmt::format("median {:+.0f} um, 95 % within {:.0f} um, worst {:+.0f} um {}", distances.median_um,
                       distances.p95_um, distances.worst_um, place_text(distances.worst));
  if (distances.missing > 0)
    text += fmt::format("{}{:.2f} % missing", text.empty() ? "" : ", ",
                        100.0 * static_cast<double>(distances.missing) /
                            static_cast<double>(distances.missing + distances.places));
  return text;
}

std::vector<CureLine> cured_part_lines(const CuredPart& part) {
  const CureFigures& found = part.figures;
  std::vector<CureLine> lines{
      {"undersides", distances_text(found.undersides)},
      {"tops", distances_text(found.tops)},
      {"walls", distances_text(found.walls)},
      {"volume", fmt::format("{:.2f} mm³; {:.2f} mm³ too much, {:.2f} mm³ missing", found.model_mm3,
                             found.too_much_mm3, found.too_little_mm3)}};
  if (found.closed_mm2 > 0)
    lines.push_back({"closed gaps", fmt::format("{:.2f} mm², the tallest {:.3f} mm {}", found.closed_mm2,
                                                found.tallest_closed_mm, place_text(found.closed))});
  if (!part.cut_copies.empty()) lines.push_back({"excluded", cut_copies_text(part.cut_copies)});
  if (part.weakest_bond > 0)
    lines.push_back({"weakest bond", fmt::format("{:.2f} of the dose at which resin gels, layer {}",
                                                 part.weakest_bond, part.weakest_bond_layer + 1)});
  return lines;
}

std::vector<std::string> cured_part_warnings(const CuredPart& part, bool memory_measured) {
  std::vector<std::string> warnings;
  if (!memory_measured)
    warnings.push_back(
        "the resin's peel_memory was not measured: all light is taken to be remembered, so undersides are "
        "the lowest that they can be");
  if (part.weakest_bond > 0 && part.weakest_bond < 1)
    warnings.push_back(fmt::format(
        "layer {} does not cure down to the layer beneath, which gets {:.2f} of the dose at which resin gels",
        part.weakest_bond_layer + 1, part.weakest_bond));
  if (part.abandoned_layers > 0)
    warnings.push_back(
        fmt::format("{} masks exceeded their time budget and count as dark", part.abandoned_layers));
  if (part.unfound_undersides > 0)
    warnings.push_back(
        fmt::format("undersides of {} layers kept all their light, because they were not found within the "
                    "time budget of a mask",
                    part.unfound_undersides));
  return warnings;
}

std::vector<std::string> warnings_of(const PrintedPart& cured, bool memory_measured) {
  if (!cured.part) return {};
  std::vector<std::string> warnings = cured_part_warnings(*cured.part, memory_measured);
  if (!cured.without_frames.empty()) warnings.push_back(cured.without_frames);
  return warnings;
}

CureLine rise_light_line(const RiseLight& rise) {
  return {"rise",
          fmt::format("{} masks in steps of {:.0f} um; {:.2f} times the dose at which resin gels, at the "
                      "least {:.2f} at {:.2f} mm; light cures {:.0f} um through an underside",
                      rise.masks, in_mm(rise.step) * 1000, rise.margin, rise.least_margin,
                      in_mm(rise.least_at), rise.print_through.count())};
}

Json rise_light_json(const RiseLight& rise) {
  return {{"masks", rise.masks},
          {"step_um", in_mm(rise.step) * 1000},
          {"margin", rise.margin},
          {"least_margin", rise.least_margin},
          {"least_margin_at_mm", in_mm(rise.least_at)},
          {"print_through_um", rise.print_through.count()}};
}

Json cured_part_json(const CuredPart& part) {
  const CureFigures& found = part.figures;
  Json json{{"undersides", distances_json(found.undersides)},
            {"tops", distances_json(found.tops)},
            {"walls", distances_json(found.walls)},
            {"model_mm3", found.model_mm3},
            {"too_much_mm3", found.too_much_mm3},
            {"missing_mm3", found.too_little_mm3},
            {"closed_gaps_mm2", found.closed_mm2},
            {"tallest_closed_gap_mm", found.tallest_closed_mm}};
  if (found.closed_mm2 > 0) json["tallest_closed_gap_at_mm"] = place_json(found.closed);
  json["compared_up_to"] = cut_copies_json(part.cut_copies);
  json["weakest_bond"] = part.weakest_bond;
  json["weakest_bond_layer"] = part.weakest_bond > 0 ? Json(part.weakest_bond_layer + 1) : Json();
  return json;
}

}  // namespace contourd
