// Finds the printer that prints from a spool, if this program's user can read its configuration.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/config/printer_config.hpp"

namespace contourd::ctl {

struct SpoolPrinter {
  std::optional<PrinterConfig> config;
  std::string unknown;  // if there is none: the reason
};

// Loads the configuration `given`; without it the installed configuration, if it names this spool. Throws
// ConfigError if `given` is not valid.
[[nodiscard]] SpoolPrinter printer_of(const std::filesystem::path& spool,
                                      const std::optional<std::filesystem::path>& given);

}  // namespace contourd::ctl
