#include "daemon/config/orientation_ticket.hpp"

#include <nlohmann/json.hpp>

namespace contourd {
namespace {

void check_box(JsonDocument& document, const std::string& place) {
  for (const char* axis : {"x", "y", "z"}) {
    const auto least = document.valid_number(place + "/min/" + axis);
    const auto most = document.valid_number(place + "/max/" + axis);
    if (least && most && *least > *most)
      document.add_violation(place + "/min/" + axis, std::string("it is more than the ") + axis + " of max");
  }
}

void check_surface(JsonDocument& document, const std::string& place, const nlohmann::json& surface) {
  const bool has_box = surface.contains("min") || surface.contains("max");
  const bool has_direction = surface.contains("x") || surface.contains("y") || surface.contains("z");
  const bool whole_box = surface.contains("min") && surface.contains("max");
  if (has_direction == has_box || (has_box && !whole_box)) {
    document.add_violation(place,
                           "a surface to keep clean is either a direction (x, y, z) or a box (min and max)");
    return;
  }
  if (has_box) return check_box(document, place);
  for (const auto& [axis, value] : surface.items())
    if (value != 0) return;
  document.add_violation(place, "a direction must not be zero in x, y and z");
}

Direction read_point(const JsonSection& point) {
  const auto along = [&point](const char* axis) { return point.has(axis) ? point.number(axis) : 0; };
  return {along("x"), along("y"), along("z")};
}

}  // namespace

void check_orientation_rules(JsonDocument& document, const std::string& place) {
  const nlohmann::json model = document.value().at(nlohmann::json::json_pointer(place));
  if (!model.contains("keep_clean")) return;
  if (!model.contains("up") || model.at("up").is_object()) {
    document.add_violation(place + "/keep_clean",
                           "it requires \"up\": \"auto\", \"fast\", \"clean\" or \"safe\"");
  }
  const nlohmann::json& surfaces = model.at("keep_clean");
  if (!surfaces.is_array()) return;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (surfaces[i].is_object())
      check_surface(document, place + "/keep_clean/" + std::to_string(i), surfaces[i]);
}

std::optional<OrientationTicket> read_orientation(const JsonSection& model) {
  if (!model.has("up") || model.is_section("up")) return std::nullopt;
  OrientationTicket ticket;
  ticket.preset = orientation_preset(model.text("up")).value_or(OrientationPreset::Auto);
  if (!model.has("keep_clean")) return ticket;
  for (const JsonSection& surface : model.sections("keep_clean")) {
    if (surface.has("min")) {
      ticket.keep_clean.emplace_back(
          KeepCleanBox{read_point(surface.section("min")), read_point(surface.section("max"))});
    } else {
      ticket.keep_clean.emplace_back(read_point(surface));
    }
  }
  return ticket;
}

}  // namespace contourd
