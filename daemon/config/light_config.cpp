#include "daemon/config/light_config.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/config/hardware_config.hpp"
#include "daemon/config/projector_config.hpp"
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
void add_violations(const JsonDocument& document, const std::vector<std::string>& places, FoundLight& found) {
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

// Reads the table that the printer's file names. Adds its violations and its exceptions to `found`.
std::optional<JsonDocument> find_table(JsonDocument& printer, const fs::path& folder, FoundLight& found) {
  std::optional<JsonDocument> table;
  if (!printer.valid_text("/projector/port")) return table;
  attempt(printer.file(), found, [&] {
    table = named_table(printer, folder);
    if (!table) return;
    check_table(*table);
    add_violations(*table,
                   {"/brand", "/baud", "/line_end", "/echo", "/checksum", "/timeout_ms", "/retries",
                    "/gap_ms", "/commands/light_off"},
                   found);
  });
  return table;
}

}  // namespace

std::string light_record(const JsonDocument& printer, const std::optional<JsonDocument>& table) {
  expects(printer.value().contains("projector"), "the printer has a projector");
  nlohmann::json record = printer.value().at("projector");
  if (table) record["table"] = table->value();
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
  try {
    light.projector =
        read_light_projector(root, root.has("port") ? std::optional(root.section("table")) : std::nullopt);
  } catch (const std::invalid_argument& error) {
    throw ConfigError({{record.string(), "/table", error.what()}});
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
    const auto table = simulated ? std::nullopt : find_table(printer, folder, found);
    std::vector<std::string> places{"/hardware", "/projectors_folder", "/projector/port"};
    for (const char* key : light_keys())
      places.push_back("/projector/" + std::string(key));
    add_violations(printer, places, found);
    if (simulated) return;
    attempt(file, found, [&] {
      const JsonSection projector = JsonSection(printer).section("projector");
      if (projector.has("light")) found.light.line = read_gpio_line(projector.section("light"));
    });
    attempt(table ? table->file() : file, found, [&] {
      found.light.projector =
          read_light_projector(JsonSection(printer).section("projector"), std::optional<JsonSection>(table));
    });
    if (found.problems.empty() && !found.light.line && !found.light.projector)
      found.problems.push_back({file, "/projector", "it contains nothing that turns the light off"});
  });
  return found;
}

}  // namespace contourd
