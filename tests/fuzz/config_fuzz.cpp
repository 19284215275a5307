// Fuzz target: any bytes as a printer's file, a resin profile or a projector table, chosen by the first byte
// (c, r, t). The file is refused in printable sentences, the same each time, or its figures are possible on a
// machine. Every good printer's file says how to turn the light off, and that reads back from the record that
// the daemon keeps of it.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "daemon/config/light_config.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/projector_table.hpp"
#include "daemon/config/resin_profile.hpp"
#include "tests/fuzz/told.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::fuzz {
namespace {

namespace fs = std::filesystem;

// A folder with a printer's file and the profiles of config/.
class ConfigFolder {
 public:
  ConfigFolder() {
    for (const char* folder : {"resins", "projectors"})
      fs::copy(fs::path(CONTOURD_CONFIG_DIR) / folder, folder_.path() / folder, fs::copy_options::recursive);
  }
  [[nodiscard]] fs::path file(std::string_view text) const { return folder_.write("fuzzed.json", text); }

 private:
  testing::TemporaryFolder folder_;
};

void demand_exposures(const ResinProfile& resin, double irradiance) {
  demand(layer_height_problems(resin, resin.layer_height, irradiance).empty(),
         "a profile refuses its own layer height");
  for (const int layer : {0, resin.bottom_layers, resin.bottom_layers + resin.fade_layers}) {
    const Duration light = exposure_time(resin, resin.layer_height, layer, irradiance);
    demand(light >= kShortestExposure && light <= kLongestExposure, "an exposure is out of bounds");
  }
}

void check(const ResinProfile& resin) {
  demand(resin.layer_height_min <= resin.layer_height && resin.layer_height <= resin.layer_height_max,
         "a layer height is out of its profile's range");
  const LayerMotion& motion = resin.motion;
  for (const MillimetersPerSecond speed :
       {motion.lift_speed, motion.second_lift_speed, motion.retract_speed, motion.slow_retract_speed})
    demand(speed.count() > 0, "the plate does not move");
  demand(motion.slow_retract <= motion.whole_lift(), "the plate comes down slowly from above its lift");
  demand(resin.motion.settle >= Duration{0} && resin.motion.rest >= Duration{0}, "a wait is negative");
  demand(resin.bottom_layers >= 0 && resin.fade_layers >= 0, "a number of layers is negative");
}

void demand_asked(const ProjectorCommand& command) {
  demand(!command.bytes.empty(), "a command sends nothing");
  demand(command.timeout > Duration{0}, "a reply has no time");
}

void check(const ProjectorTable& table) {
  demand(table.baud > 0 && table.retries >= 0 && table.gap >= Duration{0}, "a line without a speed");
  demand_asked(table.power_on);
  demand_asked(table.power_off);
  demand(!table.light_on || table.light_off, "a light can be turned on but not off");
  if (table.brightness) {
    const BrightnessCommand& brightness = *table.brightness;
    demand(brightness.least <= brightness.most, "a brightness without a range");
    for (const std::int32_t number : {brightness.least, brightness.most})
      demand_asked(brightness.with(number));
  }
  for (const auto& command : {table.light_off, table.light, table.power}) {
    if (!command) continue;
    demand_asked(*command);
    for (const auto& [meaning, pattern] : command->replies) {
      const bool says_dark = meaning == ReplyMeaning::Off || meaning == ReplyMeaning::Accepted;
      demand(!says_dark || !pattern.fits_noise(), "noise counts as a report of darkness");
    }
  }
}

void check_light(const PrinterConfig& printer, const fs::path& file, const ConfigFolder& folder) {
  const FoundLight found = find_light(file);
  demand(found.problems.empty(), "--light-off finds a problem in a file that is good");
  if (!printer.real) return;
  demand(found.light.line || found.light.projector, "--light-off finds nothing to turn off");
  const LightConfig left = read_light_record(folder.file(printer.light_record));
  demand(left.line.has_value() == found.light.line.has_value(), "the light line does not read back");
  demand(left.projector.has_value() == found.light.projector.has_value(),
         "the light's projector does not read back");
  demand(read_light_record(folder.file(left_dark(printer.light_record))).left_dark,
         "darkness does not read back");
}

void check(const PrinterConfig& printer, const fs::path& file, const ConfigFolder& folder) {
  demand(printer.display_width.count() > 0 && printer.display_height.count() > 0, "a display without pixels");
  demand(std::isfinite(printer.pixel_pitch.count()) && printer.pixel_pitch.count() > 0,
         "pixels without a size");
  demand(printer.travel.count() > 0, "an axis without travel");
  demand(printer.homing_speed.count() > 0 && printer.travel_speed.count() > 0, "an axis does not move");
  demand(std::isfinite(printer.irradiance_mw_cm2) && printer.irradiance_mw_cm2 > 0,
         "a projector without light");
  demand(printer.spool_folder.is_absolute() && printer.control_socket.is_absolute(),
         "a path is not absolute");
  for (const Violation& warning : printer.warnings)
    demand_sentence(warning_line(warning));
  demand_exposures(find_resin(printer, printer.resin), printer.irradiance_mw_cm2);
  check_light(printer, file, folder);
}

void read(char kind, std::string_view text, const ConfigFolder& folder) {
  const fs::path file = folder.file(text);
  if (kind == 'c') {
    check(load_printer_config(file, Places::Elsewhere), file, folder);
  } else if (kind == 'r') {
    const ResinMachine machine{.travel = Nanometers{150'000'000}, .irradiance_mw_cm2 = 10.0};
    const ResinProfile resin = load_resin_profile(file, machine);
    check(resin);
    demand_exposures(resin, *machine.irradiance_mw_cm2);
  } else if (kind == 't') {
    check(load_projector_table(file));
  }
}

std::string refusal_of(char kind, std::string_view text, const ConfigFolder& folder) {
  try {
    read(kind, text, folder);
    return "";
  } catch (const ConfigError& error) {
    demand_told(error);
    return error.what();
  }
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace contourd::fuzz;
  static const ConfigFolder folder;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string refusal = refusal_of(text.front(), text.substr(1), folder);
  demand(refusal_of(text.front(), text.substr(1), folder) == refusal,
         "the same file gives a different refusal");
  return 0;
}
