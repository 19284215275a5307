#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/check/config_check.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/schema_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Pointer = nlohmann::json::json_pointer;

const std::map<std::string, std::string_view>& schemas() {
  static const std::map<std::string, std::string_view> all{{"plate", plate_schema_text},
                                                           {"printer", contourd_schema_text},
                                                           {"projector", projector_schema_text},
                                                           {"resin", resin_schema_text},
                                                           {"ticket", ticket_schema_text}};
  return all;
}

// A printer's configuration file that conforms to its schema. Throws ConfigError if it does not.
struct Documents {
  explicit Documents(const std::filesystem::path& file)
      : effective(JsonDocument::from_file(file)), written(effective.value()) {
    printer_schema().check(effective);
    effective.throw_if_violated();
  }

  JsonDocument effective;  // with defaults
  nlohmann::json written;  // as in the file
};

// Calls `call` and prints a line for each mistake in the configuration. Returns the exit code.
int report_mistakes(const std::function<void()>& call) {
  try {
    call();
    return kOk;
  } catch (const ConfigError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return kBadConfig;
  }
}

// Returns the schema's default for this key, or nullptr if the schema has no default.
const nlohmann::json* default_at(const Pointer& place) {
  try {
    return printer_schema().at(place).default_here();
  } catch (const std::out_of_range&) {
    return nullptr;
  }
}

// Returns the key in the manual's notation: z_axis.travel_mm.
std::string name_of(const Pointer& place) {
  std::string name;
  for (Pointer rest = place; !rest.empty(); rest.pop_back())
    name = fmt::format("{}{}{}", rest.back(), name.empty() ? "" : ".", name);
  return printable(name);
}

std::string value_text(const nlohmann::json& value) {
  return printable(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

void print_differences(const nlohmann::json& value, const Pointer& place) {
  if (value.is_object()) {
    for (const auto& [key, member] : value.items())
      print_differences(member, place / key);
    return;
  }
  const nlohmann::json* const by_default = default_at(place);
  if (by_default != nullptr && *by_default == value) return;
  fmt::print("{} = {}{}\n", name_of(place), value_text(value),
             by_default != nullptr ? " (default " + value_text(*by_default) + ")" : "");
}

int config_check(const std::filesystem::path& file) {
  return report_mistakes([&] { check_config(file); });
}

int config_show(const std::filesystem::path& file) {
  return report_mistakes([&] {
    // Escaped to ASCII: no control sequence of the file reaches the terminal.
    fmt::print("{}\n", Documents(file).effective.value().dump(2, ' ', true));
  });
}

int config_diff(const std::filesystem::path& file) {
  return report_mistakes([&] {
    nlohmann::json written = Documents(file).written;
    written.erase("$schema");
    print_differences(written, Pointer());
  });
}

int config_schema(const std::string& format) {
  const auto schema = schemas().find(format);
  expects(schema != schemas().end(), "the format is one of config_formats()");
  fmt::print("{}", schema->second);
  return kOk;
}

std::vector<std::string> config_formats() {
  std::vector<std::string> formats;
  for (const auto& [format, schema] : schemas())
    formats.push_back(format);
  return formats;
}

}  // namespace

void add_config(Command& program) {
  Command& config = program.add("config", "Check and show the printer's configuration");
  const auto add = [&config](const char* name, const char* help, int (*call)(const std::filesystem::path&)) {
    Command& command = config.add(name, help);
    auto& file = command.arguments<std::filesystem::path>();
    file = kDefaultConfig;
    command.option("FILE", file, "Configuration file");
    command.run = [&file, call] { return call(file); };
  };
  add("check", "List the configuration's mistakes, like contourd --check-config", config_check);
  add("show", "Print the configuration with all defaults, as JSON", config_show);
  add("diff", "Print the values that differ from their defaults", config_diff);
  Command& schema = config.add("schema", "Print the JSON schema of a file format");
  auto& format = schema.arguments<std::string>();
  format = "printer";
  schema.option("FORMAT", format, "File format: printer, resin, projector, ticket or plate")
      .one_of(config_formats());
  schema.run = [&format] { return config_schema(format); };
}

}  // namespace contourd::ctl
