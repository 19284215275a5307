// contourctl: inspects and slices models with the contour core, and talks to a running contourd.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "core/calibration/line_fit.hpp"
#include "core/formats/model_reader.hpp"
#include "core/layers/layers.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/models/model_commands.hpp"
#include "daemon/ctl/setup/setup_command.hpp"
#include "daemon/ctl/submit/submit_commands.hpp"
#include "daemon/ctl/terminal/command_line.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/watch/watch_command.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

// Commands for one task, under their heading in --help and in the manual page.
struct CommandGroup {
  const char* heading;
  std::vector<void (*)(Command&)> add;
};

// Adds all commands, in the order of --help.
void add_commands(Command& program) {
  const std::vector<CommandGroup> groups{
      {"Printing", {add_submit, add_status, add_watch, add_queue, add_preflight, add_mask, add_offer}},
      {"Control of a print", {add_print_control}},
      {"Models",
       {add_inspect, add_preview, add_analyze, add_cure, add_frames, add_orient, add_support, add_slice}},
      {"Calibration", {add_calibrate, add_fit}},
      {"History and wear", {add_history, add_vat}},
      {"By hand", {add_manual, add_jog, add_switches}},
      {"Setup and diagnosis",
       {add_setup, add_level, add_config, add_export, add_web, add_diagnose, add_logs}},
      {"Help", {add_help, add_description}}};
  for (const auto& [heading, add] : groups) {
    for (const auto add_command : add)
      add_command(program);
    for (Command& each : program.commands)
      if (each.group.empty()) each.group = heading;
  }
}

// Prints the error as one line, even if a file's name contains line breaks. Returns the exit code.
int complain(int code, const char* why) {
  std::string line = why;
  std::ranges::replace(line, '\n', ' ');
  fmt::print(stderr, "contourctl: {}\n", printable(line));
  return code;
}

}  // namespace
}  // namespace contourd::ctl

int main(int argc, char** argv) {
  using namespace contourd::ctl;
  Command program{.name = "contourctl",
                  .help = "Inspects and slices models, and controls contourd, the daemon of a resin printer.",
                  .version = CONTOURD_VERSION};
  add_commands(program);
  try {
    return contourd::print_whole([&] { return run_command_line(program, argc, argv); });
  } catch (const UsageError& error) {
    return complain(contourd::kBadUsage, error.what());
  } catch (const contourd::ModelError& error) {
    return complain(kBadData, error.what());
  } catch (const contourd::CalibrationRefused& error) {
    return complain(kBadData, error.what());
  } catch (const contourd::TooManyLayers& error) {
    return complain(kBadData, error.what());
  } catch (const contourd::OutputError& error) {
    return complain(contourd::kCannotCreate, error.what());
  } catch (const contourd::ConfigError& error) {
    return complain(kBadConfig, error.what());
  } catch (const contourd::ProfileTrouble& error) {
    return complain(kBadConfig, error.sentence().c_str());
  } catch (const contourd::DaemonError& error) {
    return complain(kUnavailable, error.what());
  } catch (const std::system_error& error) {
    return complain(kNoInput, error.what());
  } catch (const std::bad_alloc&) {
    return complain(kBadData, "the model does not fit into this machine's memory");
  } catch (const std::exception& error) {
    return complain(kFailed, error.what());
  }
}
