#include "daemon/ctl/models/read_model.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <utility>

#include "daemon/formats/model_input.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

// Returns how many facets there is memory for.
std::uint64_t most_facets_of(const FileToRead& file) {
  const MemoryRoom room = memory_room(std::nullopt);
  const std::uint64_t needed = memory_to_prepare({&file, 1}, DisplayGeometry{});
  if (needed > room.bytes) throw JobTooLarge({&file, 1}, "", needed, room);
  return most_facets_to_read({&file, 1}, 0, DisplayGeometry{}, room);
}

}  // namespace

ModelOfFile read_model(const std::filesystem::path& path, const std::vector<std::string>& names) {
  try {
    const std::unique_ptr<ModelInput> input = open_model(path, names);
    Model model = input->read(most_facets_of({input->outline()}));
    return {std::move(model), input->outline().format};
  } catch (const ModelError& error) {
    throw ModelError(path.string() + ": " + error.what());
  } catch (const JobTooLarge& error) {
    throw ModelError(path.string() + ": " + error.what());
  }
}

std::optional<double> size_of(ModelOfFile& read, const SizeArgs& args) {
  const ModelUnit unit{parse_unit(args.unit), read.model.unit, applies_unit(read.format)};
  if (!unit.is_applied) return parse_size(args);
  if (std::string conflict = unit_conflict(unit); !conflict.empty())
    read.model.warnings.push_back(std::move(conflict));
  return parse_size({std::nullopt, args.scale});
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings)
    fmt::print(stderr, "contourctl: warning: {}\n", printable(warning));
}

void look_at_models(const std::filesystem::path& path, const std::vector<std::string>& names) {
  (void)holds_layers(path, names);
}

bool holds_layers(const std::filesystem::path& path, const std::vector<std::string>& names) {
  try {
    return open_models(path, {names}).models.front().input->sliced() != nullptr;
  } catch (const ModelError& error) {
    throw ModelError(path.string() + ": " + error.what());
  }
}

std::vector<std::string> models_named_by(std::string_view ticket) {
  if (ticket.empty()) return {};
  try {
    return parse_job_ticket(ticket, "the ticket").models.front().entries;
  } catch (const ConfigError&) {
    return {};  // whoever prepares the job refuses the ticket
  }
}

std::vector<std::string> models_named_in(const std::optional<std::filesystem::path>& ticket) {
  if (!ticket) return {};
  try {
    return load_job_ticket(*ticket).models.front().entries;
  } catch (const ConfigError&) {
    return {};
  }
}

PreparedJob prepare_model(const JobFiles& files, const PrinterConfig& printer, const AskedOfJob& asked) {
  try {
    JobSettings settings = read_settings(files, printer);
    if (asked.supports) settings.supports = *asked.supports;
    settings.resin.undersides = asked.undersides.value_or(settings.resin.undersides);
    settings.resin.mode = asked.mode.value_or(settings.resin.mode);
    if (asked.unit) settings.ticket.models.front().unit = *asked.unit;
    if (asked.scale) {
      settings.ticket.models.front().scale = Scale{*asked.scale};
      settings.ticket.models.front().fit = false;
    }
    if (asked.hollow_wall) {
      std::optional<HollowSettings>& hollow = settings.ticket.models.front().hollow;
      if (!hollow) hollow.emplace();
      hollow->wall = *asked.hollow_wall;
    }
    return prepare_job(files, settings, printer);
  } catch (const ProfileTrouble& trouble) {
    if (trouble.fault() == ProfileTrouble::Fault::Profile) throw;
    throw ModelError(files.model.string() + ": " + trouble.what());
  } catch (const JobRefused& refusal) {
    throw ModelError(files.model.string() + ": " + refusal.what());
  }
}

}  // namespace contourd::ctl
