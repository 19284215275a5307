#include "daemon/prepare/model_orientation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

Json figures_json(const OrientationFigures& figures) {
  return {{"up", {figures.up.x, figures.up.y, figures.up.z}},
          {"score", figures.score},
          {"contacts", figures.contacts},
          {"support_mm3", figures.support_mm3},
          {"overhang_mm2", figures.overhang_mm2},
          {"largest_area_mm2", figures.largest_mm2},
          {"size_mm", {figures.size_x_mm, figures.size_y_mm, figures.size_z_mm}},
          {"stands", figures.stands},
          {"standing_mm2", figures.standing_mm2},
          {"touched_mm2", figures.touched_mm2},
          {"fits", figures.fits},
          {"tried", figures.tried}};
}

}  // namespace

std::optional<ModelOrientation> find_orientation(std::span<const Facet> facets, const ModelTicket& ticket,
                                                 const OrientationLimits& limits,
                                                 const std::stop_token& stop) {
  expects(ticket.orientation.has_value() && !facets.empty(),
          "the ticket leaves the orientation to contourd, and there is a facet");
  const auto start = std::chrono::steady_clock::now();
  OrientationRequest request;
  request.scale = ticket.scale.value_or(Scale{}) * limits.shrinkage;
  if (!ticket.fit) request.build = limits.build;
  request.supports = limits.supports;
  request.keep_own_supports = limits.keep_own_supports;
  request.keep_clean = ticket.orientation->keep_clean;
  request.weights = weights_of(ticket.orientation->preset, limits.weights);
  std::optional<OrientationChoice> choice = choose_orientation(facets, request, stop);
  if (!choice) return std::nullopt;
  return ModelOrientation{ticket.orientation->preset, std::move(*choice),
                          std::chrono::steady_clock::now() - start};
}

std::string text_of(const Direction& up) {
  // Adding 0.0 turns -0 into 0, so that it is printed without a minus.
  const auto rounded = [](double along) { return std::round(along * 1000) / 1000 + 0.0; };
  return fmt::format("{:g}, {:g}, {:g}", rounded(up.x), rounded(up.y), rounded(up.z));
}

std::string describe(const OrientationFigures& figures) {
  const double contacts = std::ceil(figures.contacts);
  std::string text = contacts > 0 ? fmt::format("about {:.0f} contact{}, {:.2f} ml of supports", contacts,
                                                contacts == 1 ? "" : "s", figures.support_mm3 / 1000)
                                  : "no overhangs";
  text += fmt::format(", {:.2f} mm high, largest layer {:.0f} mm²", figures.size_z_mm, figures.largest_mm2);
  if (figures.stands) text += ", stands by itself";
  if (figures.touched_mm2 > 0)
    text += fmt::format(", touches {:.0f} mm² of the surfaces to be kept clean", figures.touched_mm2);
  if (!figures.fits) text += ", does not fit into the machine";
  return text;
}

std::string describe(const ModelOrientation& orientation) {
  const OrientationChoice& choice = orientation.choice;
  const std::string preset(name_of(orientation.preset));
  if (choice.as_drawn()) {
    return fmt::format("stays as drawn ({}): {}{}", preset,
                       choice.own_supports ? "the model carries supports in its file, " : "",
                       describe(choice.chosen()));
  }
  const auto drawn = std::ranges::find(choice.ranked, Direction{0, 0, 1}, &OrientationFigures::up);
  return fmt::format(
      "{} points up ({}): {}{}; as drawn: {}", text_of(choice.chosen().up), preset,
      choice.own_supports ? "the supports that the model carries in its file are turned as well, " : "",
      describe(choice.chosen()), describe(*drawn));
}

std::span<const OrientationFigures> reported(const OrientationChoice& choice) {
  return std::span(choice.ranked).first(std::min(choice.ranked.size(), kMaxReported));
}

Json orientation_json(const ModelOrientation& orientation) {
  Json alternatives = Json::array();
  for (const OrientationFigures& figures : reported(orientation.choice))
    alternatives.push_back(figures_json(figures));
  return {{"preset", name_of(orientation.preset)},           {"as_drawn", orientation.choice.as_drawn()},
          {"own_supports", orientation.choice.own_supports}, {"tried", orientation.choice.tried},
          {"took_ms", milliseconds(orientation.took)},       {"alternatives", std::move(alternatives)}};
}

}  // namespace contourd
