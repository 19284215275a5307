#include "daemon/ctl/submit/spool_printer.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "daemon/client/control_defaults.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {

namespace fs = std::filesystem;

// The installed one only if it is that of who prints from this spool.
SpoolPrinter printer_of(const fs::path& spool, const std::optional<fs::path>& given) {
  if (given) return {load_printer_config(*given, Places::Elsewhere), ""};
  std::string why = fmt::format("{} is of another spool", kDefaultConfig);
  try {
    PrinterConfig config = load_printer_config(kDefaultConfig, Places::Elsewhere);
    std::error_code ignored;
    if (fs::equivalent(config.spool_folder, spool, ignored)) return {std::move(config), ""};
  } catch (const ConfigError& error) {
    why = error.violations().empty() ? "its file is wrong" : ConfigError({error.violations().front()}).what();
  } catch (const std::exception& error) {
    why = error.what();
  }
  return {std::nullopt, fmt::format("the printer is not known: {}; --printer FILE says it", printable(why))};
}

}  // namespace contourd::ctl
