// contourd: starts the light watchdog or the daemon, and prints the reason why it cannot run.
#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <string>

#include "daemon/app/start_program.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"
#include "hw/watchdog/light_watchdog_process.hpp"

int main(int argc, char** argv) {
  // First, so that the watchdog process takes little memory and time. The option is internal.
  if (argc == 3 && std::strcmp(argv[1], contourd::kLightWatchdogOption) == 0)
    return contourd::serve_light_watchdog(std::atoi(argv[2]));
  const auto complain = [](int code, const std::string& why) {
    fmt::print(stderr, "{}\n", why);
    return code;
  };
  try {
    return contourd::print_whole([&] { return contourd::start_program(argc, argv); });
  } catch (const contourd::ConfigError& error) {
    return complain(contourd::kBadConfig, error.what());
  } catch (const contourd::OutputError& error) {
    return complain(contourd::kCannotCreate, std::string("contourd: ") + error.what());
  } catch (const std::exception& error) {
    return complain(contourd::kFailed, "contourd: " + contourd::printable(error.what()));
  }
}
