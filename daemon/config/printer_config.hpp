// One printer as its owner describes it: machine, folders, resin. Value types; thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/exposure_correction.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/config/wear_part.hpp"
#include "daemon/json/config_error.hpp"
#include "hw/real_machine_config.hpp"
#include "hw/simulated_printer_config.hpp"

namespace contourd {

enum class Pace {
  Realtime,
  Fast,  // as fast as the processor goes
};

// Bounds of what is done by hand.
struct ManualConfig {
  Duration light_limit{};  // the longest light
  Nanometers vat_depth{};  // below this height the plate may be in the resin
};

// Paths are absolute. What the file leaves out has the schema's default (config/contourd.schema.json), which
// is the only place that says it.
struct PrinterConfig {
  std::string name;
  std::filesystem::path spool_folder;  // has incoming, printing, done and failed in it
  std::filesystem::path control_socket;
  std::filesystem::path job_ended_socket;
  std::optional<std::filesystem::path> metrics_file{};
  std::filesystem::path resins_folder;
  bool wait_for_plate_cleared = true;
  std::uintmax_t min_free_disk_bytes = 0;
  std::optional<std::uint64_t> memory_limit_bytes{};  // of the process; nothing: by what is available
  Duration mask_budget{};                             // for the computation of one mask
  std::string resin;  // name of the profile for jobs that name none; good when the file was read

  Nanometers travel;
  MillimetersPerSecond travel_speed, homing_speed;
  std::optional<MillimetersPerSecond> top_speed;

  Pixels display_width;
  Pixels display_height;
  Micrometers pixel_pitch;
  bool mirror_x = false;
  bool mirror_y = false;
  bool anti_aliasing = true;
  ToneCurve tone;
  std::optional<Mask> uniformity;  // as large as the display

  double irradiance_mw_cm2 = 0.0;  // of a white pixel, on the film

  ManualConfig manual;
  ReminderConfig reminders;

  Pace pace = Pace::Realtime;
  SimulatedPrinterConfig simulated;
  std::optional<RealMachineConfig> real;     // nothing when the machine is simulated
  std::vector<Violation> warnings;           // what is allowed but implausible, by its place
  std::vector<std::filesystem::path> files;  // that were read for it, its own first
  std::string
      light_record;  // what is to be left for `--light-off`; see light_config.hpp. Real machines' only

  std::vector<std::string>
      ask_before{};                     // findings of which a job's owner is asked; see preprint_analysis.hpp
  double tiny_first_layer_percent = 0;  // of the largest layer's area: a first layer below that is one
  SupportPolicy supports = SupportPolicy::Off;  // of jobs whose tickets say nothing of it
};

// Whether the printer is this computer's, so that its folders must be possible here.
enum class Places { Here, Elsewhere };

// Throws ConfigError with everything that is wrong with the file and with the resin profile it names.
[[nodiscard]] PrinterConfig load_printer_config(const std::filesystem::path& path,
                                                Places places = Places::Here);

// Reads the profile of that name, checked against the printer. Throws ConfigError with what is wrong with it,
// or with the profiles there are when there is none of that name. The name may come from anywhere.
[[nodiscard]] ResinProfile find_resin(const PrinterConfig& printer, std::string_view name);

// What is wrong with the profiles that a ticket may name, or implausible.
[[nodiscard]] std::vector<Violation> implausible_in_other_resins(const PrinterConfig& printer);

}  // namespace contourd
