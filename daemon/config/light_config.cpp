#include "daemon/config/light_config.hpp"

#include <algorithm>
#include <initializer_list>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/config/hardware_config.hpp"
#include "daemon/config/projector_table.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/json_section.hpp"
#include "daemon/json/profile_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// True if the two JSON pointers are equal or one contains the other.
bool are_nested(std::string_view one, std::string_view other) {
  if (one.size() > other.size()) std::swap(one, other);
  return other.starts_with(one) && (one.size() == other.size() || other[one.size()] == '/');
}

// Adds the document's violations to `found`: to the problems if they touch one of the places, else to
// `elsewhere`.
void add_violations(const JsonDocument& document, std::initializer_list<std::string_view> places,
                    FoundLight& found) {
  for (Violation& violation : document.violations()) {
    const bool needed = std::any_of(places.begin(), places.end(), [&](std::string_view place) {
      return are_nested(violation.pointer, place);
    });
    (needed ? found.problems : found.elsewhere).push_back(std::move(violation));
  }
}

// Runs a part of the reading. Adds its exceptions to the problems unless the same place already has one.
template <typename Read>
void attempt(const std::string& file, FoundLight& found, Read read) {
  const auto add = [&](Violation violation) {
    const auto same_place = [&](const Violation& known) {
      return known.file == violation.file && are_nested(known.pointer, violation.pointer);
    };
    if (std::none_of(found.problems.begin(), found.problems.end(), same_place))
      found.problems.push_back(std::move(violation));
  };
  try {
    read();
  } catch (const ConfigError& error) {
    for (const Violation& violation : error.violations())
      add(violation);
  } catch (const std::invalid_argument& error) {
    add({file, "", error.what()});
  }
}

void find_projector(JsonDocument& printer, const fs::path& folder, FoundLight& found) {
  const auto tables = printer.valid_text("/projectors_folder"), name = printer.valid_text("/projector/table"),
             port = printer.valid_text("/projector/port");
  if (!tables || !name || !port) return;
  const fs::path tables_folder = resolved(folder, *tables);
  const auto file = profile_file(tables_folder, *name);
  if (!file) {
    printer.add_violation("/projector/table", no_such_profile("projector table", tables_folder, *name));
    return;
  }
  attempt(file->string(), found, [&] {
    JsonDocument table = JsonDocument::from_file(*file);
    check_table(table);
    add_violations(table,
                   {"/brand", "/baud", "/line_end", "/echo", "/checksum", "/timeout_ms", "/retries",
                    "/gap_ms", "/commands/light_off"},
                   found);
    if (auto light = read_light_table(JsonSection(table)))
      found.light.projector = {.port = *port, .table = std::move(*light), .brightness = {}};
  });
}

}  // namespace

std::string light_record(const JsonDocument& printer, const std::optional<nlohmann::json>& table) {
  expects(printer.value().contains("projector"), "the printer has a projector");
  const nlohmann::json& projector = printer.value().at("projector");
  nlohmann::json record = nlohmann::json::object();
  if (projector.contains("light")) record["light"] = projector.at("light");
  if (table) record["projector"] = {{"port", projector.at("port")}, {"table", *table}};
  return record.dump(2) + "\n";
}

std::string left_dark(const std::string& record) {
  expects(nlohmann::json::accept(record), "the record is JSON text");
  nlohmann::json marked = nlohmann::json::parse(record);
  marked["left_dark"] = true;
  return marked.dump(2) + "\n";
}

LightConfig read_light_record(const fs::path& record) {
  const JsonDocument document = JsonDocument::from_file(record);
  document.throw_if_violated();
  const JsonSection root(document);
  LightConfig light;
  light.left_dark = root.has("left_dark") && root.boolean("left_dark");
  if (root.has("light")) light.line = read_gpio_line(root.section("light"));
  if (!root.has("projector")) return light;
  const JsonSection projector = root.section("projector");
  try {
    if (auto table = read_light_table(projector.section("table")))
      light.projector = {.port = projector.text("port"), .table = std::move(*table), .brightness = {}};
  } catch (const std::invalid_argument& error) {
    throw ConfigError({{record.string(), "/projector/table", error.what()}});
  }
  return light;
}

FoundLight find_light(const fs::path& printer_file) {
  FoundLight found;
  const std::string file = printer_file.string();
  attempt(file, found, [&] {
    JsonDocument printer = JsonDocument::from_file(printer_file);
    const fs::path folder = folder_of(printer_file);
    printer_schema().check(printer);
    check_hardware_rules(printer);
    if (const auto socket = printer.valid_text("/control_socket"))
      found.control_socket = resolved(folder, *socket);
    const bool simulated = printer.valid_text("/hardware") == "simulated";
    if (!simulated) find_projector(printer, folder, found);
    add_violations(
        printer,
        {"/hardware", "/projectors_folder", "/projector/port", "/projector/table", "/projector/light"},
        found);
    if (simulated) return;
    attempt(file, found, [&] {
      const JsonSection projector = JsonSection(printer).section("projector");
      if (projector.has("light")) found.light.line = read_gpio_line(projector.section("light"));
    });
    if (found.problems.empty() && !found.light.line && !found.light.projector)
      found.problems.push_back({file, "/projector", "it contains nothing that turns the light off"});
  });
  return found;
}

}  // namespace contourd
