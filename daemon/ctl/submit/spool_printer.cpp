#include "daemon/ctl/submit/spool_printer.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "daemon/client/control_defaults.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {

namespace fs = std::filesystem;

SpoolPrinter printer_of(const fs::path& spool, const std::optional<fs::path>& given) {
  if (given) return {load_printer_config(*given, Places::Elsewhere), ""};
  std::string why = fmt::format("{} is for another spool", kDefaultConfig);
  try {
    PrinterConfig config = load_printer_config(kDefaultConfig, Places::Elsewhere);
    std::error_code ignored;
    if (fs::equivalent(config.spool_folder, spool, ignored)) return {std::move(config), ""};
  } catch (const ConfigError& error) {
    why = error.violations().empty() ? "its configuration is not valid"
                                     : ConfigError({error.violations().front()}).what();
  } catch (const std::exception& error) {
    why = error.what();
  }
  return {std::nullopt,
          fmt::format("the printer is unknown: {}; specify it by --printer FILE", printable(why))};
}

}  // namespace contourd::ctl
