// Reading of models, common to all commands.
#pragma once

#include <filesystem>
#include <optional>

#include "core/model/model.hpp"
#include "daemon/prepare/print_job.hpp"

namespace contourd::ctl {

// Reads a model like read_model_file(), with the file's name at the start of error messages. Refuses a model
// that needs more memory than there is. Throws the exceptions of read_model_file().
[[nodiscard]] Model read_model(const std::filesystem::path& path);
// Throws the exceptions of read_model() for defects that the beginning of the file shows.
void look_at_model(const std::filesystem::path& path);

// Settings that override the job's ticket.
struct AskedOfJob {
  std::optional<SupportPolicy> supports{};
  std::optional<Undersides> undersides{};
  std::optional<double> scale{};
  std::optional<PrintWay> mode{};
};

// Prepares a job as contourd does with this configuration and the job's ticket, if it has one. Throws
// ModelError for problems with the job or its ticket, and ProfileTrouble for problems with the printer's own
// resin.
[[nodiscard]] PreparedJob prepare_model(const JobFiles& files, const PrinterConfig& printer,
                                        const AskedOfJob& asked = {});

}  // namespace contourd::ctl
