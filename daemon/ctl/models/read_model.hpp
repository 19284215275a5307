// Reading of models, common to all commands.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/model.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/prepare/print_job.hpp"

namespace contourd::ctl {

struct ModelOfFile {
  Model model;
  std::string_view format;  // the name of its format
};

// Reads a model of any format, with the file's name at the start of error messages. `names` chooses a
// model of a ZIP archive; empty: the only one. Refuses a model that needs more memory than there is. Throws
// ModelError, and std::system_error if the file cannot be read.
[[nodiscard]] ModelOfFile read_model(const std::filesystem::path& path,
                                     const std::vector<std::string>& names = {});
// Returns the factor by which the model is enlarged, which parse_size() returns for a file without a unit of
// its own. If --unit is ignored, the model gets a warning.
[[nodiscard]] std::optional<double> size_of(ModelOfFile& read, const SizeArgs& args);
// Prints warnings about a model on stderr, a line each.
void print_warnings(const std::vector<std::string>& warnings);
// Throws the exceptions of read_model() for defects that the beginning of the file shows.
// A ZIP archive may hold several models.
void look_at_models(const std::filesystem::path& path, const std::vector<std::string>& names);
// True if the file holds finished layers instead of a model. Throws what look_at_models() throws.
[[nodiscard]] bool holds_layers(const std::filesystem::path& path, const std::vector<std::string>& names);
// Returns the names of models in a ZIP archive that the text of a ticket has; empty if there are none, or if
// the ticket is wrong.
[[nodiscard]] std::vector<std::string> models_named_by(std::string_view ticket);
// Does the same for a ticket's file, if there is one.
[[nodiscard]] std::vector<std::string> models_named_in(const std::optional<std::filesystem::path>& ticket);

// Settings that override the job's ticket.
struct AskedOfJob {
  std::optional<SupportPolicy> supports{};
  std::optional<Undersides> undersides{};
  std::optional<LengthUnit> unit{};
  std::optional<double> scale{};
  std::optional<Millimeters> hollow_wall{};  // least thickness of the walls of a hollow model
  std::optional<PrintWay> mode{};
};

// Prepares a job as contourd does with this configuration and the job's ticket, if it has one. Throws
// ModelError for problems with the job or its ticket, and ProfileTrouble for problems with the printer's own
// resin.
[[nodiscard]] PreparedJob prepare_model(const JobFiles& files, const PrinterConfig& printer,
                                        const AskedOfJob& asked = {});

}  // namespace contourd::ctl
