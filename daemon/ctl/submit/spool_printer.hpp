// The printer that prints what is put into a spool, as far as this program's user can read what it is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/config/printer_config.hpp"

namespace contourd::ctl {

struct SpoolPrinter {
  std::optional<PrinterConfig> config;
  std::string unknown;  // why there is none, a sentence
};

// By the configuration in `given`; without it the installed one, where that has this spool. Throws
// ConfigError when `given` cannot be used.
[[nodiscard]] SpoolPrinter printer_of(const std::filesystem::path& spool,
                                      const std::optional<std::filesystem::path>& given);

}  // namespace contourd::ctl
