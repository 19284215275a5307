#include "daemon/placement/job_settings.hpp"

#include <fmt/format.h>

#include <exception>
#include <utility>

#include "daemon/config/ticket_overrides.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

JobTicket ticket_of(const JobFiles& files) {
  if (files.plate) return load_plate_ticket(files.model / kPlateTicket, files.links);
  return files.ticket ? load_job_ticket(*files.ticket, files.links) : JobTicket{};
}

// Returns the first mistake in the profile and the number of others.
std::string in_one_line(const std::string& resin, const ConfigError& error) {
  const std::size_t others = error.violations().size() - 1;
  return fmt::format("the resin profile {} cannot be used: {}{}", in_quotes(resin),
                     ConfigError({error.violations().front()}).what(),
                     others > 0 ? fmt::format(", and {} more", others) : "");
}

ResinProfile resin_for(const JobTicket& ticket, const PrinterConfig& printer) {
  using Fault = ProfileTrouble::Fault;
  const std::string& name = ticket.resin ? *ticket.resin : printer.resin;
  try {
    return find_resin(printer, name);
  } catch (const ConfigError& error) {
    const auto is_there = [&](const std::string& resin) {
      return profile_file(printer.resins_folder, resin).has_value();
    };
    // If the printer's own profile is missing too, the folder is missing, and the ticket is not at fault.
    const bool unknown = ticket.resin && !is_there(name) && is_there(printer.resin);
    const std::string sentence = in_one_line(name, error);
    if (!unknown) throw ProfileTrouble(Fault::Profile, sentence, sentence);
    throw ProfileTrouble(Fault::Ticket, fmt::format("the job ticket is wrong: {}", error.in_one_line()),
                         sentence);
  }
}

std::string ticket_file(const JobFiles& files) {
  if (files.plate) return (files.model / kPlateTicket).string();
  return files.ticket ? files.ticket->string() : "";
}

}  // namespace

JobSettings settings_by(JobTicket ticket, const std::string& file, const PrinterConfig& printer) {
  ResinProfile resin = resin_for(ticket, printer);
  const OverrideFiles files{file, printer.resins_folder / (resin.name + ".json")};
  OverriddenSettings overridden = override_settings(resin, ticket, printer.irradiance_mw_cm2, files);
  const SupportPolicy supports = ticket.supports ? ticket.supports->policy : printer.supports;
  return {std::move(ticket), std::move(resin), std::move(overridden), supports};
}

JobSettings read_settings(const JobFiles& files, const PrinterConfig& printer) {
  try {
    return settings_by(ticket_of(files), ticket_file(files), printer);
  } catch (const JobRefused&) {
    throw;
  } catch (const ConfigError& error) {
    throw JobRefused(fmt::format("the job ticket is wrong: {}", error.in_one_line()));
  } catch (const std::exception& error) {
    throw JobRefused(fmt::format("the job ticket cannot be used: {}", printable(error.what())));
  }
}

}  // namespace contourd
