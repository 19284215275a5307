#include "daemon/prepare/print_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <span>
#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

// Maximum number of islands, or of runs of layers, that a sentence names.
constexpr std::size_t kMaxNamedFindings = 3;

// Returns the area with three significant digits and all digits before the point, never with an exponent.
std::string area_text(double area_mm2) {
  if (area_mm2 < 0.0001) return "less than 0.0001 mm²";
  return area_mm2 < 999.5 ? fmt::format("{:.3g} mm²", area_mm2) : fmt::format("{:.0f} mm²", area_mm2);
}

// Returns the first kMaxNamedFindings runs of consecutive layers. `layers` is in rising order.
std::vector<std::span<const std::int32_t>> first_runs(std::span<const std::int32_t> layers) {
  std::vector<std::span<const std::int32_t>> runs;
  for (std::size_t i = 0; i < layers.size() && runs.size() < kMaxNamedFindings;) {
    std::size_t end = i + 1;
    while (end < layers.size() && layers[end] == layers[end - 1] + 1)
      ++end;
    runs.push_back(layers.subspan(i, end - i));
    i = end;
  }
  return runs;
}

// Returns the layers, counted from 1: "3", "3 to 7", "3 to 7, 9, 12 and 4 more".
std::string layers_text(std::span<const std::int32_t> layers) {
  std::string text;
  std::size_t named = 0;
  for (const auto& run : first_runs(layers)) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", run.front() + 1);
    if (run.size() > 1) text += fmt::format(" to {}", run.back() + 1);
    named += run.size();
  }
  if (named < layers.size()) text += fmt::format(" and {} more", layers.size() - named);
  return text;
}

FindingWarning warning_about(std::span<const std::int32_t> layers, std::string_view mark,
                             std::string sentence) {
  FindingWarning warning{std::move(sentence), mark, {}};
  for (const auto& run : first_runs(layers))
    warning.layers.push_back(run.front());
  return warning;
}

// A warning about islands, suction cups or resin traps, without the places themselves.
struct PlacesWarning {
  std::string sentence;  // up to the first place
  std::string_view mark;
  std::uint64_t count;  // including places that are not listed
};

// Adds the places with the largest figure. `text_of` describes one.
template <typename Place, typename Text>
FindingWarning places_warning(PlacesWarning about, const std::vector<Place>& places, double Place::*figure,
                              std::int32_t Place::*layer, Text text_of) {
  std::vector<Place> largest(std::min(kMaxNamedFindings, places.size()));
  std::ranges::partial_sort_copy(places, largest, std::ranges::greater{}, figure, figure);
  FindingWarning warning{std::move(about.sentence), about.mark, {}};
  std::string_view comma;
  for (const Place& place : largest) {
    if (std::ranges::find(warning.layers, place.*layer) == warning.layers.end())
      warning.layers.push_back(place.*layer);
    warning.sentence += fmt::format("{} {}", std::exchange(comma, ","), text_of(place));
  }
  if (about.count > largest.size())
    warning.sentence += fmt::format(", and {} more", about.count - largest.size());
  return warning;
}

FindingWarning island_warning(const PrintFindings& findings) {
  const std::uint64_t count = findings.island_count;
  return places_warning(
      {fmt::format("{} with nothing under {}:", count_of(count, "island begins", "islands begin"),
                   count == 1 ? "it" : "them"),
       "island", count},
      findings.islands, &Island::area_mm2, &Island::layer, [](const Island& island) {
        return fmt::format("layer {} at {} mm from the plate's centre ({})", island.layer + 1,
                           coordinates({island.plate_mm.x, island.plate_mm.y}), area_text(island.area_mm2));
      });
}

// Returns "800 mm³", or "1.2 ml" from one millilitre on.
std::string volume_text(double volume_mm3) {
  if (volume_mm3 >= 999.5) return fmt::format("{:.1f} ml", volume_mm3 / 1000);
  return fmt::format("{:.3g} mm³", volume_mm3);
}

// Returns "layers 12 to 40, at 3.10, -2.00 mm from the plate's centre in layer 20".
std::string place_text(const PrintVoid& each) {
  const std::string layers =
      each.first_layer == each.last_layer
          ? fmt::format("layer {}, at", each.first_layer + 1)
          : fmt::format("layers {} to {}, at", each.first_layer + 1, each.last_layer + 1);
  return fmt::format("{} {} mm from the plate's centre in layer {}", layers,
                     coordinates({each.plate_mm.x, each.plate_mm.y}), each.widest_layer + 1);
}

// `figure`: by which the largest voids are chosen.
FindingWarning void_warning(PlacesWarning about, const std::vector<PrintVoid>& voids,
                            double PrintVoid::*figure) {
  const auto text = [figure](const PrintVoid& each) {
    return fmt::format("{} ({}{}{})", place_text(each),
                       figure == &PrintVoid::area_mm2 ? area_text(each.area_mm2) + ", " : "",
                       volume_text(each.volume_mm3), each.on_plate ? ", closed by the plate" : "");
  };
  return places_warning(std::move(about), voids, figure, &PrintVoid::widest_layer, text);
}

void add_void_warnings(const PrintFindings& findings, std::vector<FindingWarning>& warnings) {
  if (const auto count = findings.suction_cup_count; count > 0) {
    warnings.push_back(void_warning(
        {fmt::format("{} on the film until {}:", count_of(count, "suction cup pulls", "suction cups pull"),
                     count == 1 ? "it opens or is closed" : "they open or are closed"),
         "suction cup", count},
        findings.suction_cups, &PrintVoid::area_mm2));
  }
  if (const auto count = findings.resin_trap_count; count > 0) {
    warnings.push_back(
        void_warning({fmt::format("{} resin that cannot flow out:",
                                  count_of(count, "closed hollow keeps", "closed hollows keep")),
                      "resin trap", count},
                     findings.resin_traps, &PrintVoid::volume_mm3));
  }
}

void add_empty_layers_warnings(const PrintFindings& findings, std::vector<FindingWarning>& warnings) {
  const std::span<const std::int32_t> empty = findings.empty_layers;
  if (!empty.empty() && empty.size() == findings.area_mm2.size()) {
    warnings.push_back(warning_about(empty, "empty",
                                     fmt::format("all masks are dark ({}): nothing would be printed",
                                                 count_of(empty.size(), "layer", "layers"))));
    return;
  }
  const auto warn = [&warnings](std::span<const std::int32_t> layers, std::string_view consequence) {
    if (layers.empty()) return;
    const bool one = layers.size() == 1;
    warnings.push_back(warning_about(layers, "empty",
                                     fmt::format("layer{} {} {} empty: {}", one ? "" : "s",
                                                 layers_text(layers), one ? "is" : "are", consequence)));
  };
  std::size_t inside = empty.size();
  for (std::int32_t top = findings.layers() - 1; inside > 0 && empty[inside - 1] == top; --top)
    --inside;
  warn(empty.first(inside), "nothing holds the layers above");
  warn(empty.subspan(inside), "the print ends below");
}

// Returns the layers in which this number of chains is not 0.
std::vector<std::int32_t> cracked_layers(const PrintFindings& findings, std::uint32_t LayerCracks::*chains) {
  std::vector<std::int32_t> layers;
  for (const CrackedLayer& each : findings.cracked_layers)
    if (each.cracks.*chains > 0) layers.push_back(each.layer);
  return layers;
}

FindingWarning open_contours_warning(const PrintFindings& findings) {
  const std::vector<std::int32_t> open = cracked_layers(findings, &LayerCracks::open_chains);
  return warning_about(
      open, "crack",
      fmt::format(
          "the model is cracked: contours of {} ({}) did not close; the widest gap bridged is {:.3f} mm",
          count_of(open.size(), "layer", "layers"), layers_text(open), findings.cracks.widest_gap.count()));
}

FindingWarning turned_chains_warning(const PrintFindings& findings) {
  const std::vector<std::int32_t> turned = cracked_layers(findings, &LayerCracks::turned_chains);
  return warning_about(turned, "turned facets",
                       fmt::format("facets of {} ({}) are turned against the others; they were turned back",
                                   count_of(turned.size(), "layer", "layers"), layers_text(turned)));
}

Json voids_json(const std::vector<PrintVoid>& voids) {
  Json list = Json::array();
  for (const PrintVoid& each : voids) {
    list.push_back({{"first_layer", each.first_layer + 1},
                    {"last_layer", each.last_layer + 1},
                    {"widest_layer", each.widest_layer + 1},
                    {"plate_mm", {each.plate_mm.x, each.plate_mm.y}},
                    {"pixel", {each.pixel.x, each.pixel.y}},
                    {"area_mm2", each.area_mm2},
                    {"volume_mm3", each.volume_mm3},
                    {"on_plate", each.on_plate}});
  }
  return list;
}

}  // namespace

std::string findings_line(const PrintFindings& findings) {
  std::string text = count_of(findings.area_mm2.size(), "layer", "layers");
  if (findings.layer_time > Duration{0}) text += fmt::format(" in {}", readable(findings.layer_time));
  text += fmt::format(", {:.2f} ml of resin", findings.resin_ml());
  if (findings.layers() > 0) {
    text += fmt::format(", at most {:.2f} mm² (layer {})", findings.largest_area_mm2,
                        findings.largest_area_layer + 1);
  }
  text += fmt::format(", {}, {}", count_of(findings.island_count, "island", "islands"),
                      count_of(findings.empty_layers.size(), "empty layer", "empty layers"));
  if (const auto count = findings.suction_cup_count; count > 0)
    text += ", " + count_of(count, "suction cup", "suction cups");
  if (const auto count = findings.resin_trap_count; count > 0)
    text += ", " + count_of(count, "resin trap", "resin traps");
  return text;
}

std::vector<FindingWarning> findings_warnings(const PrintFindings& findings) {
  std::vector<FindingWarning> warnings;
  if (findings.island_count > 0) warnings.push_back(island_warning(findings));
  add_void_warnings(findings, warnings);
  add_empty_layers_warnings(findings, warnings);
  if (const auto& abandoned = findings.abandoned_layers; !abandoned.empty()) {
    warnings.push_back(warning_about(
        abandoned, "no mask",
        fmt::format("the mask of {} ({}) takes far longer than mask_budget_ms: the print will stop there",
                    count_of(abandoned.size(), "layer", "layers"), layers_text(abandoned))));
  }
  if (findings.cracks.open_chains > 0) warnings.push_back(open_contours_warning(findings));
  if (findings.cracks.turned_chains > 0) warnings.push_back(turned_chains_warning(findings));
  return warnings;
}

std::vector<std::string> warnings_about(const PrintFindings& findings) {
  std::vector<std::string> sentences;
  for (FindingWarning& warning : findings_warnings(findings))
    sentences.push_back(std::move(warning.sentence));
  return sentences;
}

Json cracks_json(const LayerCracks& cracks) {
  return {{"open_chains", cracks.open_chains},
          {"turned_chains", cracks.turned_chains},
          {"gaps_closed", cracks.gaps_closed},
          {"widest_gap_mm", cracks.widest_gap.count()}};
}

Json findings_summary_json(const PrintFindings& findings) {
  Json json;
  json["layers"] = findings.layers();
  json["layer_time_s"] = std::chrono::duration<double>(findings.layer_time).count();
  json["resin_ml"] = findings.resin_ml();
  json["largest_area_mm2"] = findings.largest_area_mm2;
  json["largest_area_layer"] = findings.layers() > 0 ? Json(findings.largest_area_layer + 1) : Json();
  json["islands"] = findings.island_count;
  json["suction_cups"] = findings.suction_cup_count;
  json["resin_traps"] = findings.resin_trap_count;
  json["empty_layers"] = findings.empty_layers.size();
  json["abandoned_layers"] = findings.abandoned_layers.size();
  json["cracked_layers"] = findings.cracked_layers.size();
  json.update(cracks_json(findings.cracks));
  json["warnings"] = warnings_about(findings);
  return json;
}

Json findings_json(const PrintFindings& findings) {
  Json json = findings_summary_json(findings);
  Json islands = Json::array(), empty = Json::array(), cracked = Json::array();
  for (const Island& island : findings.islands) {
    islands.push_back({{"layer", island.layer + 1},
                       {"plate_mm", {island.plate_mm.x, island.plate_mm.y}},
                       {"pixel", {island.pixel.x, island.pixel.y}},
                       {"area_mm2", island.area_mm2}});
  }
  for (const std::int32_t layer : findings.empty_layers)
    empty.push_back(layer + 1);
  for (const CrackedLayer& each : findings.cracked_layers) {
    cracked.push_back({{"layer", each.layer + 1}});
    cracked.back().update(cracks_json(each.cracks));
  }
  json["island_list"] = std::move(islands);
  json["suction_cup_list"] = voids_json(findings.suction_cups);
  json["resin_trap_list"] = voids_json(findings.resin_traps);
  json["empty_layer_list"] = std::move(empty);
  json["cracked_layer_list"] = std::move(cracked);
  return json;
}

}  // namespace contourd
