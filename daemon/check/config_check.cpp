#include "daemon/check/config_check.hpp"

#include <fmt/format.h>

#include <vector>

#include "daemon/check/service_user.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

void check_config(const std::filesystem::path& file) {
  const PrinterConfig config = load_printer_config(file);
  std::vector<Violation> warnings = config.warnings;
  const auto add = [&warnings](const std::vector<Violation>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  add(implausible_in_other_resins(config));
  if (const auto user = service_user()) add(out_of_reach(*user, config));
  for (const Violation& warning : warnings)
    fmt::print("{}\n", warning_line(warning));
  fmt::print("{}: good\n", printable(file.string()));
}

}  // namespace contourd
