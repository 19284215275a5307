// A model as every command reads it.
#pragma once

#include <filesystem>
#include <optional>

#include "core/model/model.hpp"
#include "daemon/prepare/print_job.hpp"

namespace contourd::ctl {

// read_model_file(), with the file's name in front of what is wrong with it; what needs more memory than
// there is is not read. Throws as that does.
[[nodiscard]] Model read_model(const std::filesystem::path& path);
// Throws as that does, as far as the file's beginning shows what is wrong.
void look_at_model(const std::filesystem::path& path);

// What is asked for beside a job's ticket.
struct AskedOfJob {
  std::optional<SupportPolicy> supports{};
  std::optional<double> scale{};  // in the place of the ticket's
};

// As contourd with that configuration makes it ready to be printed, by its ticket if it has one. Throws
// ModelError with what is wrong with the job, its ticket included, and ProfileTrouble with what is wrong with
// the printer's own resin.
[[nodiscard]] PreparedJob prepare_model(const JobFiles& files, const PrinterConfig& printer,
                                        const AskedOfJob& asked = {});

}  // namespace contourd::ctl
