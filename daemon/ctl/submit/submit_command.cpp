#include "daemon/ctl/submit/submit_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

#include "daemon/config/job_ticket.hpp"
#include "daemon/config/sliced_settings.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/submit/spool_submission.hpp"
#include "daemon/ctl/submit/submit_outlook.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/ctl/watch/watch_command.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

struct SubmitOptions {
  std::vector<std::filesystem::path> models;
  // Keys of the tickets (config/ticket.schema.json); a value that is not given is not in the ticket.
  std::optional<std::string> resin, unit, supports, undersides, mode, exposure_from;
  std::optional<double> layer_height_um, scale, hollow_mm;
  std::optional<double> exposure_ms, bottom_exposure_ms, lift_mm, settle_ms, rest_ms;
  std::optional<int> copies;
  std::optional<std::string> up;
  std::vector<std::string> entries;  // models of a ZIP archive
  bool fit = false, dry = false;
  // Ticket instead of the keys above.
  std::optional<std::filesystem::path> ticket;
  std::optional<std::filesystem::path> spool;  // nullopt: ask contourd
  bool wait = false;
  // Configuration for the check of the ticket's settings, and for the forecast of time, resin and warnings.
  // nullopt: the installed configuration, if it can be read and names this spool.
  std::optional<std::filesystem::path> printer;
  bool yes = false;  // do not ask
};

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json up_json(const UpOption& up) {
  if (const auto* const preset = std::get_if<OrientationPreset>(&up)) return name_of(*preset);
  const auto& direction = std::get<Direction>(up);
  return {{"x", direction.x}, {"y", direction.y}, {"z", direction.z}};
}

// Returns the ticket as text, or an empty text if there is none.
std::string ticket_of(const SubmitOptions& options) {
  if (options.ticket) {
    (void)load_job_ticket(*options.ticket);
    return text_of(open_regular_file(*options.ticket, Links::Follow), JsonDocument::kLargestBytes);
  }
  Json ticket = Json::object();
  if (options.resin) ticket["resin"] = *options.resin;
  if (options.layer_height_um) ticket["layer_height_um"] = *options.layer_height_um;
  for (const auto& [key, value] :
       {std::pair("exposure_ms", options.exposure_ms),
        std::pair("bottom_exposure_ms", options.bottom_exposure_ms), std::pair("lift_mm", options.lift_mm),
        std::pair("settle_ms", options.settle_ms), std::pair("rest_ms", options.rest_ms)})
    if (value) ticket[key] = *value;
  if (options.exposure_from) ticket["exposure_from"] = *options.exposure_from;
  if (const auto unit = parse_unit(options.unit)) ticket["unit"] = name_of(*unit);
  if (const auto up = parse_up(options.up)) ticket["up"] = up_json(*up);
  if (options.supports) ticket["supports"] = *options.supports;
  if (options.undersides) ticket["undersides"] = *options.undersides;
  if (options.mode) ticket["mode"] = *options.mode;
  if (options.scale) ticket["scale"] = *options.scale;
  if (options.fit) ticket["fit"] = true;
  if (options.hollow_mm) ticket["hollow"]["wall_mm"] = *options.hollow_mm;
  if (options.dry) ticket["dry"] = true;
  if (options.copies) ticket["copies"] = *options.copies;
  if (!options.entries.empty()) ticket["model"] = options.entries;
  if (ticket.empty()) return "";
  std::string text = ticket.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  try {
    (void)parse_job_ticket(text, "the options");
  } catch (const ConfigError& error) {
    throw UsageError(error.what());
  }
  return text;
}

// Returns the ticket's name in messages.
std::string ticket_name(const SubmitOptions& options) {
  return options.ticket ? options.ticket->string() : "the options";
}

// Throws UsageError or ConfigError if the ticket sets a value that the resin's profile does not allow.
void check_overrides(const SubmitOptions& options, const std::string& text, const SpoolPrinter& printer) {
  const std::string file = ticket_name(options);
  JobTicket ticket = text.empty() ? JobTicket{} : parse_job_ticket(text, file);
  if (ticket.overrides == TicketOverrides{}) return;
  // Without a configuration the check is left to contourd, which checks every ticket.
  if (!printer.config) return;
  try {
    (void)settings_by(std::move(ticket), file, *printer.config);
  } catch (const ProfileTrouble&) {
    // The profile may have been corrected when the job is printed.
  } catch (const ConfigError& error) {
    if (options.ticket) throw;
    throw UsageError(error.what());
  }
}

// Checks the model's name and the beginning of its file. Throws ModelError.
void check_model(const fs::path& path, const std::vector<std::string>& names) {
  if (!is_model_name(path.filename().string()))
    throw ModelError(fmt::format("{}: not a model's name: it must end in {} and not begin with a dot",
                                 path.string(), model_extensions_text()));
  look_at_models(path, names);
}

// Throws ModelError if the ticket asks for what finished layers cannot have, and a file holds such layers.
void check_layers(const SubmitOptions& options, const std::string& text,
                  const std::vector<std::string>& names) {
  if (text.empty()) return;
  const std::string refusal = refusal_for_layers(parse_job_ticket(text, ticket_name(options)));
  if (refusal.empty()) return;
  for (const fs::path& model : options.models)
    if (holds_layers(model, names)) throw ModelError(fmt::format("{}: {}", model.string(), refusal));
}

// Puts the model into the spool. Returns the job's name.
std::string put(const SpoolSubmission& submission, const fs::path& model, const std::string& ticket) {
  try {
    return submission.put(model.filename().string(), open_regular_file(model, Links::Follow), ticket);
  } catch (const UnreadableFile& error) {
    throw std::system_error(error.code(), "cannot read " + model.string());
  }
}

// Prints the models that contourd would refuse. Returns false if there is none.
bool has_refusals(const std::vector<ModelOutlook>& outlooks, const SubmitOptions& options) {
  bool found = false;
  for (std::size_t i = 0; i < outlooks.size(); ++i) {
    if (outlooks[i].refusal.empty()) continue;
    found = true;
    fmt::print(stderr, "contourctl: {}: contourd would refuse it: {}; nothing was queued\n",
               printable(options.models[i].string()), printable(outlooks[i].refusal));
  }
  return found;
}

// Prints the forecast. Returns false if there is a warning and the user does not agree.
bool is_agreed(const std::vector<ModelOutlook>& outlooks, const SubmitOptions& options) {
  for (const ModelOutlook& each : outlooks)
    for (const std::string& line : each.lines)
      fmt::print("{}\n", line);
  std::fflush(stdout);
  if (options.yes || agreed_to(outlooks)) return true;
  fmt::print("Nothing was queued.\n");
  return false;
}

int submit(const ClientOptions& client, const SubmitOptions& options) {
  const std::string ticket = ticket_of(options);
  const std::vector<std::string> names = models_named_by(ticket);
  for (const fs::path& model : options.models)
    check_model(model, names);
  check_layers(options, ticket, names);
  const fs::path spool = find_spool(client, options.spool);
  const SpoolPrinter printer = printer_of(spool, options.printer);
  check_overrides(options, ticket, printer);
  const std::vector<ModelOutlook> outlooks = outlooks_of({options.models, ticket, printer});
  if (has_refusals(outlooks, options)) return kBadData;
  if (!client.json && !is_agreed(outlooks, options)) return kFailed;
  const SpoolSubmission submission(spool);
  std::vector<std::string> jobs;
  for (std::size_t i = 0; i < options.models.size(); ++i) {
    jobs.push_back(put(submission, options.models[i], ticket));
    tell_submitted(client, options.models[i], jobs.back(), outlooks[i].json);
  }
  int result = kOk;
  if (!options.wait) return result;
  for (const std::string& job : jobs) {
    const std::optional<int> code = watch(client, job);
    if (!code) break;
    result = std::max(result, *code);
  }
  return result;
}

}  // namespace

void tell_submitted(const ClientOptions& client, const fs::path& model, const std::string& job,
                    const Json& outlook) {
  if (client.json) {
    Json line{{"file", model.string()}, {"job", job}};
    if (!outlook.is_null()) line["outlook"] = outlook;
    fmt::print("{}\n", line.dump(-1, ' ', true, Json::error_handler_t::replace));
  } else {
    fmt::print("{}: job {}\n", printable(model.string()), printable(job));
  }
  std::fflush(stdout);
}

void add_submit(Command& program) {
  Command& command = program.add("submit", "Add models to the queue");
  auto& options = command.arguments<SubmitOptions>();
  command.option("FILE", options.models, "Model files").required().allow_empty();
  const Option& ticket = command.option("--ticket", options.ticket, "Ticket for all models");
  const auto add = [&](const char* name, auto& variable, const char* help) -> Option& {
    return command.option(name, variable, help).excludes(ticket);
  };
  add("--resin", options.resin, "Name of the resin profile").suggests(resins);
  add("--layer-height-um", options.layer_height_um, "Layer height, um");
  add("--exposure-ms", options.exposure_ms,
      "Exposure of a normal layer, ms, within the resin's ticket_limits");
  add("--bottom-exposure-ms", options.bottom_exposure_ms,
      "Exposure of a bottom layer, ms, within the resin's ticket_limits");
  add("--exposure-from", options.exposure_from, "Exposures of a sliced archive: the resin's, or the file's")
      .one_of({"resin", "file"});
  add("--lift-mm", options.lift_mm, "Lift after an exposure, mm, within the resin's ticket_limits");
  add("--settle-ms", options.settle_ms, "Wait before the exposure, ms, within the resin's ticket_limits");
  add("--rest-ms", options.rest_ms, "Wait after the exposure, ms, within the resin's ticket_limits");
  add("--undersides", options.undersides, kUndersidesHelp).one_of({"plain", "dose"});
  add("--mode", options.mode, "Print layered, or continuous: the plate never stops")
      .one_of({"layered", "continuous"});
  add("--model", options.entries, "Model or folder to print of a ZIP archive; may be repeated");
  add("--copies", options.copies, "Number of copies of each model");
  add("--dry", options.dry, "Dry run: all moves and masks, but no light");
  add("--up", options.up, kUpHelp).suggests(up_presets);
  add("--supports", options.supports,
      "Supports: auto, on, off, or \"in the file\": the model carries them (default: as configured)")
      .one_of({"auto", "on", "off", "in the file"});
  add("--unit", options.unit, kUnitHelp).suggests(unit_names);
  const Option& scale = add("--scale", options.scale, kScaleHelp);
  add("--fit", options.fit, "Scale the model to fill the display").excludes(scale);
  add("--hollow", options.hollow_mm, kHollowHelp);
  command.option("--printer", options.printer,
                 "Forecast and check the print with this printer configuration");
  command.option("--spool", options.spool, kSpoolHelp);
  command.option("--wait", options.wait, "Wait until all jobs have ended");
  command.option("--yes", options.yes, "Do not ask for confirmation of warnings");
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &options] { return submit(client, options); };
}

}  // namespace contourd::ctl
