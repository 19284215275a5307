// The configuration of one printer: machine, folders, resin. Value types; thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/cure/pixel_light.hpp"
#include "core/geometry/units.hpp"
#include "core/mask/exposure_correction.hpp"
#include "daemon/config/force_policy.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/config/wear_part.hpp"
#include "daemon/json/config_error.hpp"
#include "hw/real_machine_config.hpp"
#include "hw/simulated_printer_config.hpp"

namespace contourd {

enum class Pace {
  Realtime,
  Fast,  // as fast as the processor allows
};

// Limits of manual control.
struct ManualConfig {
  Duration light_limit{};  // longest time that the light stays on
  Nanometers vat_depth{};  // below this height, the plate may be in the resin
};

// The temperature of the resin: a number of degrees Celsius, or the file of a sensor that contains
// thousandths of a degree (kernel: hwmon/sysfs-interface.rst, w1/slaves/w1_therm.rst).
using ResinTemperature = std::variant<double, std::filesystem::path>;

// The user's camera: see daemon/camera/camera.hpp.
struct CameraConfig {
  std::filesystem::path socket;
  std::int32_t every_layers = 1;
  Duration time_limit{};  // of the command that takes a picture
};

// The content of a printer's file. Paths are absolute. Omitted keys have the schema's defaults; these are
// defined only in config/contourd.schema.json.
struct PrinterConfig {
  std::string name;
  std::filesystem::path spool_folder;  // contains incoming, printing, done and failed
  std::filesystem::path control_socket;
  std::filesystem::path job_ended_socket;
  std::optional<std::filesystem::path> metrics_file{};
  std::optional<CameraConfig> camera{};
  std::filesystem::path resins_folder;
  bool wait_for_plate_cleared = true;
  bool resumes_after_power_cut = false;  // without a user; only with a limit switch at the top
  std::uintmax_t min_free_disk_bytes = 0;
  std::optional<std::uint64_t> memory_limit_bytes{};  // nullopt: the available memory is the limit
  Duration mask_budget{};                             // longest time to compute one mask
  std::string resin;  // profile of jobs that name none; was valid when the file was read

  Nanometers travel;
  MillimetersPerSecond travel_speed, homing_speed;
  std::optional<MillimetersPerSecond> top_speed;
  double stiffness_n_mm = 0;           // stiffness of plate, axis and vat together
  std::optional<ForcePolicy> force{};  // nullopt: there is no force line

  Pixels display_width;
  Pixels display_height;
  Micrometers pixel_pitch;
  bool mirror_x = false;
  bool mirror_y = false;
  bool anti_aliasing = true;
  ToneCurve tone;
  bool gamma_of_light = false;     // true: the tone's gamma was measured by a light meter, not by cured resin
  PixelLight pixel_light{};        // on the film
  int grey_bits = 8;               // of the panel
  std::optional<Mask> uniformity;  // as large as the display

  double irradiance_mw_cm2 = 0.0;  // irradiance of a white pixel on the film
  std::optional<ResinTemperature> resin_temperature{};

  ManualConfig manual;
  ReminderConfig reminders;

  Pace pace = Pace::Realtime;
  SimulatedPrinterConfig simulated;
  std::optional<RealMachineConfig> real;     // nullopt if the machine is simulated
  std::vector<Violation> warnings;           // about values that are allowed but implausible
  std::vector<std::filesystem::path> files;  // all files that were read, the printer's own first
  std::string light_record;  // for `--light-off`, see light_config.hpp; empty unless the machine is real

  std::vector<std::string>
      ask_before{};  // findings that need the user's confirmation; see preprint_analysis.hpp
  double tiny_first_layer_percent = 0;  // percentage of the largest layer; a smaller first layer is a finding
  SupportPolicy supports = SupportPolicy::Off;  // for jobs whose ticket does not set it

  // True if the panel has too few greys for one mask an exposure.
  [[nodiscard]] bool splits_exposures() const { return grey_bits < 8; }
};

// The computer that the printer's file is for. Here: the file's folders must be possible on this computer.
enum class Places { Here, Elsewhere };

// Reads a printer's file. Throws ConfigError with all violations in it and in the files it names: the resin
// profile, the projector's table, the uniformity mask.
[[nodiscard]] PrinterConfig load_printer_config(const std::filesystem::path& path,
                                                Places places = Places::Here);
// Does the same with the text that is to become a printer's file.
[[nodiscard]] PrinterConfig read_printer_config(std::string_view text, const std::filesystem::path& path,
                                                Places places = Places::Here);

// Reads the resin profile of that name and checks it against the printer. Throws ConfigError with its
// violations, or with a list of the existing profiles if there is none of that name. Safe for untrusted
// names.
[[nodiscard]] ResinProfile find_resin(const PrinterConfig& printer, std::string_view name);

// Returns the tone curve by which resin cures: a gamma that was measured by a light meter times the resin's
// reciprocity exponent.
[[nodiscard]] ToneCurve tone_for(const PrinterConfig& printer, const ResinProfile& resin);

// Returns the limits that the printer sets to its resin profiles.
[[nodiscard]] ResinMachine resin_machine(const PrinterConfig& printer);

// Returns the violations of and the warnings about all other resin profiles, which a ticket may name.
[[nodiscard]] std::vector<Violation> implausible_in_other_resins(const PrinterConfig& printer);

}  // namespace contourd
