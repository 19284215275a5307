#include "daemon/config/projector_config.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "daemon/config/projector_table.hpp"
#include "daemon/json/profile_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

SerialProjectorConfig read_serial(const JsonSection& section, const JsonSection& table) {
  SerialProjectorConfig config{.port = section.text("port"),
                               .table = read_projector_table(table),
                               .brightness = section.find("brightness", &JsonSection::integer<std::int32_t>)};
  // The longer warm-up counts.
  config.table.warm_up = std::max(config.table.warm_up, section.duration("warm_up_s"));
  return config;
}

}  // namespace

std::span<const char* const> light_keys() {
  static constexpr std::array kKeys{"light", "table"};
  return kKeys;
}

std::optional<JsonDocument> named_table(JsonDocument& printer, const fs::path& folder) {
  const auto tables = printer.valid_text("/projectors_folder"), name = printer.valid_text("/projector/table");
  if (!tables || !name) return std::nullopt;
  const fs::path tables_folder = resolved(folder, *tables);
  if (const auto file = profile_file(tables_folder, *name)) return JsonDocument::from_file(*file);
  printer.add_violation("/projector/table", no_such_profile("projector table", tables_folder, *name));
  return std::nullopt;
}

std::optional<ProjectorConfig> read_projector(const JsonSection& section,
                                              const std::optional<JsonSection>& table) {
  if (table) return read_serial(section, *table);
  return std::nullopt;
}

std::optional<ProjectorConfig> read_light_projector(const JsonSection& section,
                                                    const std::optional<JsonSection>& table) {
  if (!table) return read_projector(section, table);
  std::optional<ProjectorTable> light = read_light_table(*table);
  if (!light) return std::nullopt;
  return SerialProjectorConfig{.port = section.text("port"), .table = std::move(*light), .brightness = {}};
}

}  // namespace contourd
