#include "daemon/config/job_ticket.hpp"

#include <nlohmann/json.hpp>

#include "daemon/config/support_figures.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/json_section.hpp"

namespace contourd {
namespace {

// Rejects the zero vector, which has no direction.
void check_direction(JsonDocument& document, const std::string& place) {
  const auto component = [&](const char* axis) { return document.valid_number(place + "/" + axis); };
  if (component("x") == 0.0 && component("y") == 0.0 && component("z") == 0.0)
    document.add_violation(place, "a direction must not be zero in x, y and z");
}

void check_drain_rules(JsonDocument& document, const nlohmann::json& model, const std::string& place) {
  const nlohmann::json drain = model.value("drain", nlohmann::json());
  for (std::size_t i = 0; drain.is_array() && i < drain.size(); ++i) {
    if (drain[i].is_object() && drain[i].contains("direction"))
      check_direction(document, place + "/drain/" + std::to_string(i) + "/direction");
  }
}

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

// Checks the rules across keys for the model at the pointer `place`, which must be an object.
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

void check_infill_rules(JsonDocument& document, const std::string& place) {
  const auto cell = document.valid_number(place + "/cell_mm"),
             strut = document.valid_number(place + "/strut_mm");
  if (cell && strut && 2 * *strut > *cell)
    document.add_violation(place + "/strut_mm", decimal(*strut) + " is more than half of cell_mm, " +
                                                    decimal(*cell) + ": the cells would be closed");
}

// Rules across one model's keys; `place` is its pointer.
void check_model_rules(JsonDocument& document, const std::string& place) {
  const nlohmann::json::json_pointer pointer(place);
  if (!document.value().contains(pointer) || !document.value().at(pointer).is_object()) return;
  const nlohmann::json model = document.value().at(pointer);
  const bool has_scale =
      document.valid_number(place + "/scale") || model.value("scale", nlohmann::json()).is_object();
  if (has_scale && model.value("fit", nlohmann::json()) == true)
    document.add_violation(place + "/scale", "a ticket has either scale or fit, not both");
  check_drain_rules(document, model, place);
  check_infill_rules(document, place + "/hollow/infill");
  check_orientation_rules(document, place);
  if (!model.contains("up")) return;
  if (model.contains("rotation_deg"))
    document.add_violation(place + "/up", "a ticket has either up or rotation_deg, not both");
  check_direction(document, place + "/up");
}

void check_exposure_steps(JsonDocument& document) {
  const nlohmann::json& root = document.value();
  if (!root.is_object() || !root.contains("exposure_steps")) return;
  if (root.contains("adaptive_layers"))
    document.add_violation("/exposure_steps",
                           "a ticket has either adaptive_layers or exposure_steps, not both");
  const std::size_t steps = root.at("exposure_steps").size();
  for (std::size_t i = 1; i < steps; ++i) {
    const auto place = [](std::size_t step) {
      return "/exposure_steps/" + std::to_string(step) + "/from_mm";
    };
    const auto below = document.valid_number(place(i - 1)), from = document.valid_number(place(i));
    if (below && from && *from <= *below)
      document.add_violation(place(i),
                             decimal(*from) + " is not above the step before it, " + decimal(*below));
  }
}

void check_exposure_source(JsonDocument& document) {
  const nlohmann::json& root = document.value();
  if (!root.is_object() || root.value("exposure_from", nlohmann::json()) != "file") return;
  for (const char* exposure : {"exposure_ms", "bottom_exposure_ms", "exposure_steps"})
    if (root.contains(exposure))
      document.add_violation("/exposure_from", std::string("a ticket has either the file's exposures, or ") +
                                                   exposure + ", not both");
}

void check_layer_rules(JsonDocument& document) {
  if (document.valid_number("/layer_height_um") && document.value().contains("adaptive_layers")) {
    document.add_violation("/adaptive_layers",
                           "a ticket has either adaptive_layers or layer_height_um, not both");
  }
  for (const char* exposure : {"exposure_ms", "bottom_exposure_ms"}) {
    const std::string key = std::string("/") + exposure;
    if (document.valid_number(key) && document.value().contains("adaptive_layers")) {
      document.add_violation(key, std::string("a ticket has either adaptive_layers, whose exposures follow "
                                              "the thickness, or ") +
                                      exposure + ", not both");
    }
  }
  check_exposure_steps(document);
  check_exposure_source(document);
  const auto thinnest = document.valid_number("/adaptive_layers/min_um");
  const auto thickest = document.valid_number("/adaptive_layers/max_um");
  if (thinnest && thickest && *thinnest > *thickest)
    document.add_violation("/adaptive_layers/min_um", "it is more than max_um");
}

Scale read_scale(const JsonSection& model) {
  if (!model.is_section("scale")) return Scale{model.number("scale")};
  const JsonSection scale = model.section("scale");
  return {scale.number("x"), scale.number("y"), scale.number("z")};
}

// Reads x, y and z; a missing one is 0.
Direction read_direction(const JsonSection& direction) {
  const auto along = [&](const char* axis) { return direction.find(axis, &JsonSection::number).value_or(0); };
  return {along("x"), along("y"), along("z")};
}

// Returns nullopt if "up" is a direction or missing. The model must satisfy check_orientation_rules().
std::optional<OrientationTicket> read_orientation(const JsonSection& model) {
  if (!model.has("up") || model.is_section("up")) return std::nullopt;
  OrientationTicket ticket;
  ticket.preset = orientation_preset(model.text("up")).value_or(OrientationPreset::Auto);
  if (!model.has("keep_clean")) return ticket;
  for (const JsonSection& surface : model.sections("keep_clean")) {
    if (surface.has("min")) {
      ticket.keep_clean.emplace_back(
          KeepCleanBox{read_direction(surface.section("min")), read_direction(surface.section("max"))});
    } else {
      ticket.keep_clean.emplace_back(read_direction(surface));
    }
  }
  return ticket;
}

DrainHole read_drain_hole(const JsonSection& hole) {
  const JsonSection position = hole.section("position_mm");
  return {position.number("x"),       position.number("y"),
          position.number("z"),       read_direction(hole.section("direction")),
          hole.number("diameter_mm"), hole.number("depth_mm")};
}

HollowSettings read_hollow(const JsonSection& root) {
  const auto length = [](const JsonSection& section, const char* key) {
    return Millimeters{section.number(key)};
  };
  HollowSettings hollow{.wall = length(root, "wall_mm"), .hole = length(root, "hole_mm")};
  if (root.has("infill")) {
    const JsonSection infill = root.section("infill");
    hollow.infill = {length(infill, "cell_mm"), length(infill, "strut_mm")};
  }
  return hollow;
}

ModelTicket read_model(const JsonSection& root) {
  ModelTicket model;
  if (root.has("file")) model.file = root.text("file");
  if (root.has("model"))
    model.entries = root.is_list("model") ? root.texts("model") : std::vector{root.text("model")};
  if (root.has("unit")) model.unit = length_unit(root.text("unit"));
  if (root.has("rotation_deg")) {
    const JsonSection rotation = root.section("rotation_deg");
    model.rotation = {rotation.number("x"), rotation.number("y"), rotation.number("z")};
  }
  model.orientation = read_orientation(root);
  if (root.has("up") && root.is_section("up")) model.up = read_direction(root.section("up"));
  if (root.has("scale")) model.scale = read_scale(root);
  if (root.has("fit")) model.fit = root.boolean("fit");
  if (root.has("position_mm")) {
    const JsonSection position = root.section("position_mm");
    model.position = {Millimeters{position.number("x")}, Millimeters{position.number("y")}};
  }
  model.copies = root.integer<int>("copies");
  if (root.has("drain")) {
    for (const JsonSection& hole : root.sections("drain"))
      model.drain.push_back(read_drain_hole(hole));
  }
  if (root.has("hollow")) model.hollow = read_hollow(root.section("hollow"));
  return model;
}

std::vector<ExposureStep> read_exposure_steps(const JsonSection& root) {
  std::vector<ExposureStep> steps;
  if (root.has("exposure_steps"))
    for (const JsonSection& step : root.sections("exposure_steps"))
      steps.push_back({step.length("from_mm"), step.duration("exposure_ms")});
  return steps;
}

TicketOverrides read_overrides(const JsonSection& root) {
  return {.exposure = root.find("exposure_ms", &JsonSection::duration),
          .bottom_exposure = root.find("bottom_exposure_ms", &JsonSection::duration),
          .exposure_steps = read_exposure_steps(root),
          .lift = root.find("lift_mm", &JsonSection::length),
          .settle = root.find("settle_ms", &JsonSection::duration),
          .rest = root.find("rest_ms", &JsonSection::duration)};
}

SupportTicket read_supports(const JsonSection& root) {
  if (root.is_section("supports")) return {SupportPolicy::On, read_asked_figures(root.section("supports"))};
  return {support_policy(root.text("supports")), {}};
}

// Reads the settings of the whole job.
JobTicket read_job(const JsonSection& root) {
  JobTicket ticket;
  ticket.resin = root.find("resin", &JsonSection::text);
  ticket.layer_height = root.find("layer_height_um", &JsonSection::length);
  if (root.has("adaptive_layers")) {
    const JsonSection adaptive = root.section("adaptive_layers");
    ticket.adaptive.emplace().cusp = adaptive.length("cusp_um");
    ticket.adaptive->thinnest = adaptive.find("min_um", &JsonSection::length);
    ticket.adaptive->thickest = adaptive.find("max_um", &JsonSection::length);
  }
  ticket.overrides = read_overrides(root);
  ticket.exposures_of_file = root.has("exposure_from") && root.text("exposure_from") == "file";
  if (root.has("undersides")) ticket.undersides = undersides_of(root.text("undersides"));
  if (root.has("mode")) ticket.mode = print_way_of(root.text("mode"));
  if (root.has("cracks"))
    ticket.cracks = root.text("cracks") == "refuse" ? CrackPolicy::Refuse : CrackPolicy::Repair;
  ticket.dry = root.boolean("dry");
  ticket.confirm = root.boolean("confirm");
  if (root.has("supports")) ticket.supports = read_supports(root);
  return ticket;
}

JobTicket read_job_ticket(JsonDocument document) {
  ticket_schema().check(document);
  check_model_rules(document, "");
  check_layer_rules(document);
  document.throw_if_violated();
  const JsonSection root(document);
  JobTicket ticket = read_job(root);
  ticket.models = {read_model(root)};
  return ticket;
}

}  // namespace

SupportPolicy support_policy(std::string_view name) {
  if (name == "on") return SupportPolicy::On;
  if (name == "in the file") return SupportPolicy::InFile;
  return name == "auto" ? SupportPolicy::Auto : SupportPolicy::Off;
}

JobTicket load_job_ticket(const std::filesystem::path& path, Links links) {
  return read_job_ticket(JsonDocument::from_file(path, links));
}

JobTicket parse_job_ticket(std::string_view text, std::string file) {
  return read_job_ticket(JsonDocument::from_text(text, std::move(file)));
}

JobTicket load_plate_ticket(const std::filesystem::path& path, Links links) {
  JsonDocument document = JsonDocument::from_file(path, links);
  plate_schema().check(document);
  const nlohmann::json& value = document.value();
  const std::size_t models = value.is_object() && value.contains("models") && value.at("models").is_array()
                                 ? value.at("models").size()
                                 : 0;
  for (std::size_t i = 0; i < models; ++i)
    check_model_rules(document, "/models/" + std::to_string(i));
  check_layer_rules(document);
  document.throw_if_violated();
  const JsonSection root(document);
  JobTicket ticket = read_job(root);
  ticket.models.clear();
  for (const JsonSection& model : root.sections("models"))
    ticket.models.push_back(read_model(model));
  return ticket;
}

}  // namespace contourd
