#include "daemon/config/printer_config.hpp"

#include <cmath>
#include <utility>

#include "daemon/config/display_memory.hpp"
#include "daemon/config/hardware_config.hpp"
#include "daemon/config/light_config.hpp"
#include "daemon/config/plausibility.hpp"
#include "daemon/config/printer_places.hpp"
#include "daemon/config/projector_config.hpp"
#include "daemon/config/projector_table.hpp"
#include "daemon/config/uniformity_mask.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/json_section.hpp"
#include "daemon/json/profile_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kBytesPerMb = 1'000'000;

// Rejects a memory limit that leaves no room for a model.
void check_memory_limit(JsonDocument& document) {
  const auto limit = document.valid_number("/memory_limit_mb");
  const auto width = document.valid_number("/display/width_px"),
             height = document.valid_number("/display/height_px");
  if (!limit || !width || !height) return;
  const auto pixels = [](double count) { return Pixels{static_cast<std::int32_t>(count)}; };
  const std::uint64_t least = kProgramBytes + memory_for_display(pixels(*width), pixels(*height));
  if (*limit * static_cast<double>(kBytesPerMb) >= static_cast<double>(least)) return;
  document.add_violation("/memory_limit_mb", std::to_string(std::llround(*limit)) +
                                                 " MB leave no room for a model: contourd and the masks of "
                                                 "this display take " +
                                                 std::to_string(least / kBytesPerMb + 1) + " MB");
}

void check_socket_path(JsonDocument& document, const fs::path& folder, const char* key) {
  constexpr std::size_t kLongestSocketPath = 107;  // unix(7): sun_path has 108 bytes, one for the NUL
  const auto socket = document.valid_text(key);
  if (!socket) return;
  const std::size_t length = resolved(folder, *socket).string().size();
  if (length <= kLongestSocketPath) return;
  document.add_violation(key, "the absolute path is " + std::to_string(length) +
                                  " bytes long; the limit for a socket is " +
                                  std::to_string(kLongestSocketPath));
}

// Checks the widths against the pixel's, up to which light is computed.
void check_pixel_light(JsonDocument& document) {
  const auto pitch = document.valid_number("/display/pixel_pitch_um");
  for (const char* index : {"0", "1"}) {
    const std::string place = std::string("/display/pixel_light/") + index + "/sigma_um";
    const auto sigma = document.valid_number(place);
    if (!pitch || !sigma || *sigma <= PixelLight::kWidestPixels * *pitch) continue;
    document.add_violation(place, decimal(*sigma) + " um are more than 16 pixels of " + decimal(*pitch) +
                                      " um, the widest light that is computed");
  }
}

void check_rules(JsonDocument& document, const fs::path& folder) {
  check_pixel_light(document);
  const auto start = document.valid_number("/simulation/start_height_mm");
  const auto travel = document.valid_number("/z_axis/travel_mm");
  // The start height of a real axis does not matter.
  if (document.valid_text("/hardware") == "simulated" && start && travel && *start > *travel) {
    document.add_violation("/simulation/start_height_mm", nlohmann::json(*start).dump() +
                                                              " is more than z_axis/travel_mm, " +
                                                              nlohmann::json(*travel).dump() + " mm");
  }
  const nlohmann::json::json_pointer at("/z_axis/homes_upwards");
  const bool upwards = document.value().contains(at) && document.value().at(at) == true;
  if (document.valid_text("/after_power_cut") == "resume" && !upwards)
    document.add_violation(
        "/after_power_cut",
        "\"resume\" needs z_axis/homes_upwards: an axis whose limit switch is at the bottom "
        "would crush the part that hangs on the plate");
  check_memory_limit(document);
  for (const char* key : {"/control_socket", "/job_ended_socket", "/camera/socket"})
    check_socket_path(document, folder, key);
}

struct LoadedResin {
  fs::path file;
  ResinProfile profile;
};

// Loads the default resin, as far as the printer's file is valid enough to find and check it. Adds the
// profile's own violations to `violations`; a missing profile is a violation of the printer's file.
std::optional<LoadedResin> load_default_resin(JsonDocument& printer, const fs::path& folder,
                                              std::vector<Violation>& violations) {
  const auto resins = printer.valid_text("/resins_folder");
  const auto name = printer.valid_text("/resin");
  if (!resins || !name) return std::nullopt;
  const fs::path resins_folder = resolved(folder, *resins);
  const auto file = profile_file(resins_folder, *name);
  if (!file) {
    printer.add_violation("/resin", no_such_profile("resin profile", resins_folder, *name));
    return std::nullopt;
  }
  ResinMachine machine{.travel = {},
                       .irradiance_mw_cm2 = printer.valid_number("/projector/irradiance_mw_cm2"),
                       .top_speed = {}};
  if (const auto travel = printer.valid_number("/z_axis/travel_mm"))
    machine.travel = to_nanometers(Millimeters{*travel});
  if (const auto speed = printer.valid_number("/z_axis/top_speed_mm_s"))
    machine.top_speed = MillimetersPerSecond{*speed};
  try {
    return LoadedResin{*file, load_resin_profile(*file, machine)};
  } catch (const ConfigError& error) {
    violations.insert(violations.end(), error.violations().begin(), error.violations().end());
    return std::nullopt;
  }
}

// Loads the projector's table, with the same treatment of violations as load_default_resin().
std::optional<JsonDocument> load_table(JsonDocument& printer, const fs::path& folder,
                                       std::vector<Violation>& violations) {
  try {
    std::optional<JsonDocument> table = named_table(printer, folder);
    if (!table) return std::nullopt;
    check_table(*table);
    table->throw_if_violated();
    check_projector_table(printer, read_projector_table(JsonSection(*table)));
    return table;
  } catch (const ConfigError& error) {
    violations.insert(violations.end(), error.violations().begin(), error.violations().end());
    return std::nullopt;
  }
}

SimulatedAxisConfig::Switch read_limit_switch(const std::string& word) {
  if (word == "stuck_open") return SimulatedAxisConfig::Switch::StuckOpen;
  if (word == "stuck_closed") return SimulatedAxisConfig::Switch::StuckClosed;
  return SimulatedAxisConfig::Switch::Works;
}

std::optional<fs::path> read_path(const JsonSection& section, std::string_view key, const fs::path& folder) {
  return section.has(key) ? std::optional(resolved(folder, section.text(key))) : std::nullopt;
}

std::optional<CameraConfig> read_camera(const JsonSection& root, const fs::path& folder) {
  if (!root.has("camera")) return std::nullopt;
  const JsonSection camera = root.section("camera");
  return CameraConfig{.socket = resolved(folder, camera.text("socket")),
                      .every_layers = camera.integer<std::int32_t>("every_layers"),
                      .time_limit = camera.duration("time_limit_s")};
}

std::optional<ForcePolicy> read_force(const JsonSection& z_axis) {
  if (!z_axis.has("force")) return std::nullopt;
  const JsonSection force = z_axis.section("force");
  return ForcePolicy{.contact_from = force.length("contact_from_mm"),
                     .resistance_fails = force.text("resistance") == "fail",
                     .least_peel_area_mm2 = force.number("least_peel_area_mm2"),
                     .pauses_without_peel = force.text("no_peel") == "pause"};
}

// Returns the simulated force on the plate, if there is a force line.
std::optional<SimulatedForceConfig> read_simulated_force(const JsonSection& root) {
  const std::optional<ForcePolicy> policy = read_force(root.section("z_axis"));
  if (!policy) return std::nullopt;
  using Line = SimulatedForceConfig::Line;
  const JsonSection simulation = root.section("simulation");
  const std::string line = simulation.text("force_line");
  return SimulatedForceConfig{
      .contact_from = policy->contact_from,
      .pixel_mm = root.section("display").number("pixel_pitch_um") / 1000,
      .peel_kpa = simulation.number("peel_kpa"),
      .part_lost_after_lifts = simulation.find("part_lost_after_lifts", &JsonSection::integer<int>),
      .obstruction = simulation.find("obstruction_mm", &JsonSection::length),
      .obstruction_after_lifts = simulation.integer<int>("obstruction_after_lifts"),
      .line = line == "works"          ? Line::Works
              : line == "stuck_active" ? Line::StuckActive
                                       : Line::StuckInactive};
}

SimulatedPrinterConfig read_simulated(const JsonSection& root, const fs::path& folder) {
  const JsonSection z_axis = root.section("z_axis");
  const JsonSection display = root.section("display");
  const JsonSection projector = root.section("projector");
  const JsonSection simulation = root.section("simulation");
  SimulatedPrinterConfig config;
  config.axis.travel = z_axis.length("travel_mm");
  config.axis.microsteps_per_mm = z_axis.number("microsteps_per_mm");
  config.axis.homing_speed = MillimetersPerSecond{z_axis.number("homing_speed_mm_s")};
  config.axis.acceleration = MillimetersPerSecondSquared{z_axis.number("acceleration_mm_s2")};
  config.axis.homes_upwards = z_axis.boolean("homes_upwards");
  config.axis.start_height = simulation.length("start_height_mm");
  config.axis.limit_switch = read_limit_switch(simulation.text("limit_switch"));
  config.axis.force = read_simulated_force(root);
  config.display.width = Pixels{display.integer<std::int32_t>("width_px")};
  config.display.height = Pixels{display.integer<std::int32_t>("height_px")};
  config.display.frame = Duration{std::llround(1e9 / display.number("refresh_hz"))};
  config.display.masks = read_path(simulation, "masks_folder", folder);
  config.display.lost_after_frames = simulation.find("display_lost_after_frames", &JsonSection::integer<int>);
  config.display.back_after = simulation.find("display_back_after_s", &JsonSection::duration);
  config.lid_opened_after_light = simulation.find("lid_opened_after_light_s", &JsonSection::duration);
  config.lid_open_for = simulation.duration("lid_open_s");
  config.projector.warm_up = projector.duration("warm_up_s");
  config.projector.reply = simulation.duration("projector_reply_ms");
  config.projector.timeout = projector.duration("reply_timeout_s");
  config.projector.silent_after_commands =
      simulation.find("projector_silent_after_commands", &JsonSection::integer<int>);
  return config;
}

std::optional<MillimetersPerSecond> read_top_speed(const JsonSection& z_axis) {
  if (!z_axis.has("top_speed_mm_s")) return std::nullopt;
  return MillimetersPerSecond{z_axis.number("top_speed_mm_s")};
}

std::optional<std::uint64_t> read_memory_limit(const JsonSection& root) {
  if (!root.has("memory_limit_mb")) return std::nullopt;
  return kBytesPerMb * root.integer<std::uint64_t>("memory_limit_mb");
}

PixelLight read_pixel_light(const JsonSection& display) {
  PixelLight light;
  if (!display.has("pixel_light")) return light;
  for (const JsonSection& gaussian : display.sections("pixel_light"))
    light.gaussians.push_back(
        {gaussian.number("sigma_um") / display.number("pixel_pitch_um"), gaussian.number("share")});
  return light;
}

std::optional<ResinTemperature> read_resin_temperature(const JsonSection& root) {
  if (!root.has("resin_temperature")) return std::nullopt;
  const JsonSection temperature = root.section("resin_temperature");
  if (temperature.has("celsius")) return temperature.number("celsius");
  return fs::path(temperature.text("sensor"));
}

WearLimits read_wear_limits(const JsonSection& reminders, std::string_view part) {
  if (!reminders.has(part)) return {};
  const JsonSection limits = reminders.section(part);
  return {.lamp_h = limits.find("lamp_h", &JsonSection::number),
          .layers = limits.find("layers", &JsonSection::integer<std::int64_t>),
          .prints = limits.find("prints", &JsonSection::integer<std::int64_t>)};
}

ReminderConfig read_reminders(const JsonSection& reminders) {
  return {.lamp = read_wear_limits(reminders, "lamp"),
          .film = read_wear_limits(reminders, "film"),
          .vat = read_wear_limits(reminders, "vat")};
}

// The files that the printer's file refers to.
struct Companions {
  std::optional<LoadedResin> resin;
  std::optional<UniformityMask> uniformity;
  std::optional<JsonDocument> table;
  std::optional<ProjectorConfig> projector;  // with the table
};

void warn_of_light(JsonDocument& document, const Companions& companions) {
  const ResinProfile& resin = companions.resin->profile;
  const auto irradiance = document.valid_number("/projector/irradiance_mw_cm2");
  const int first_normal_layer = resin.bottom_layers + resin.fade_layers;
  warn_of_implausible_light(document, *companions.projector, resin.tolerance,
                            exposure_time(resin, resin.layer_height, first_normal_layer, irradiance.value()));
}

// Returns the paths of all files that were read.
std::vector<fs::path> files_of(const JsonDocument& document, const fs::path& folder,
                               const Companions& companions) {
  std::vector<fs::path> files{folder / fs::path(document.file()).filename(), companions.resin->file};
  if (companions.table) files.emplace_back(companions.table->file());
  if (companions.uniformity) files.push_back(companions.uniformity->file);
  return files;
}

// Returns the printer's warnings, then the resin's.
std::vector<Violation> warnings_of(const JsonDocument& document, const LoadedResin& resin) {
  std::vector<Violation> warnings = document.warnings();
  const double irradiance = document.valid_number("/projector/irradiance_mw_cm2").value();
  for (Violation& warning : implausible_values(resin.profile, resin.file, irradiance))
    warnings.push_back(std::move(warning));
  return warnings;
}

PrinterConfig read_printer(const JsonDocument& document, const fs::path& folder, Companions companions) {
  const JsonSection root(document);
  const JsonSection display = root.section("display");
  const bool real = root.text("hardware") == "real";
  std::vector<fs::path> files = files_of(document, folder, companions);
  PrinterConfig config{
      .name = root.text("name"),
      .spool_folder = resolved(folder, root.text("spool_folder")),
      .control_socket = resolved(folder, root.text("control_socket")),
      .job_ended_socket = resolved(folder, root.text("job_ended_socket")),
      .metrics_file = read_path(root, "metrics_file", folder),
      .camera = read_camera(root, folder),
      .resins_folder = resolved(folder, root.text("resins_folder")),
      .wait_for_plate_cleared = root.boolean("wait_for_plate_cleared"),
      .resumes_after_power_cut = root.text("after_power_cut") == "resume",
      .min_free_disk_bytes = kBytesPerMb * root.integer<std::uintmax_t>("min_free_disk_mb"),
      .memory_limit_bytes = read_memory_limit(root),
      .mask_budget = root.duration("mask_budget_ms"),
      .resin = root.text("resin"),
      .travel = root.section("z_axis").length("travel_mm"),
      .travel_speed = MillimetersPerSecond{root.section("z_axis").number("travel_speed_mm_s")},
      .homing_speed = MillimetersPerSecond{root.section("z_axis").number("homing_speed_mm_s")},
      .top_speed = read_top_speed(root.section("z_axis")),
      .stiffness_n_mm = root.section("z_axis").number("stiffness_n_mm"),
      .force = read_force(root.section("z_axis")),
      .display_width = Pixels{display.integer<std::int32_t>("width_px")},
      .display_height = Pixels{display.integer<std::int32_t>("height_px")},
      .pixel_pitch = Micrometers{display.number("pixel_pitch_um")},
      .mirror_x = display.boolean("mirror_x"),
      .mirror_y = display.boolean("mirror_y"),
      .anti_aliasing = display.boolean("anti_aliasing"),
      .tone = {.gamma = display.number("gamma"), .threshold = display.integer<std::uint8_t>("threshold")},
      .gamma_of_light = display.text("gamma_of") == "light",
      .pixel_light = read_pixel_light(display),
      .grey_bits = display.integer<int>("grey_bits"),
      .uniformity =
          companions.uniformity ? std::optional(std::move(companions.uniformity->mask)) : std::nullopt,
      .irradiance_mw_cm2 = root.section("projector").number("irradiance_mw_cm2"),
      .resin_temperature = read_resin_temperature(root),
      .manual = {.light_limit = root.section("manual").duration("light_limit_s"),
                 .vat_depth = root.section("manual").length("vat_depth_mm")},
      .reminders = read_reminders(root.section("reminders")),
      .pace = !real && root.section("simulation").text("pace") == "fast" ? Pace::Fast : Pace::Realtime,
      .simulated = read_simulated(root, folder),
      .real = {},
      .warnings = warnings_of(document, *companions.resin),
      .files = std::move(files),
      .light_record = {},
      .ask_before = root.texts("ask_before"),
      .tiny_first_layer_percent = root.number("tiny_first_layer_percent"),
      .supports = support_policy(root.text("supports")),
  };
  if (real) {
    config.light_record = light_record(document, companions.table);
    config.real = read_real_machine(root, std::move(companions.projector));
  }
  return config;
}

PrinterConfig checked_config(JsonDocument document, const fs::path& folder, Places places) {
  printer_schema().check(document);
  check_rules(document, folder);
  if (places == Places::Here) check_places(document, folder);
  check_hardware_rules(document);
  warn_of_implausible_contacts(document);
  warn_of_implausible_display(document);
  std::vector<Violation> elsewhere;
  Companions companions;
  companions.resin = load_default_resin(document, folder, elsewhere);
  companions.uniformity = load_uniformity_mask(document, folder);
  companions.table = load_table(document, folder, elsewhere);

  std::vector<Violation> violations = document.violations();
  violations.insert(violations.end(), elsewhere.begin(), elsewhere.end());
  if (!violations.empty()) throw ConfigError(std::move(violations));
  companions.projector = read_projector(JsonSection(document).section("projector"),
                                        std::optional<JsonSection>(companions.table));
  if (companions.projector) warn_of_light(document, companions);
  return read_printer(document, folder, std::move(companions));
}

}  // namespace

PrinterConfig load_printer_config(const fs::path& path, Places places) {
  return checked_config(JsonDocument::from_file(path), folder_of(path), places);
}

PrinterConfig read_printer_config(std::string_view text, const fs::path& path, Places places) {
  return checked_config(JsonDocument::from_text(text, path.string()), folder_of(path), places);
}

ResinProfile find_resin(const PrinterConfig& printer, std::string_view name) {
  const auto file = profile_file(printer.resins_folder, name);
  if (!file) {
    throw ConfigError({{printer.resins_folder.string(), "",
                        no_such_profile("resin profile", printer.resins_folder, name)}});
  }
  return load_resin_profile(*file, resin_machine(printer));
}

ToneCurve tone_for(const PrinterConfig& printer, const ResinProfile& resin) {
  ToneCurve tone = printer.tone;
  if (printer.gamma_of_light && resin.cure_irradiance)
    tone.gamma = std::clamp(tone.gamma * resin.cure_irradiance->exponent, kLeastGamma, kGreatestGamma);
  return tone;
}

ResinMachine resin_machine(const PrinterConfig& printer) {
  return {.travel = printer.travel,
          .irradiance_mw_cm2 = printer.irradiance_mw_cm2,
          .top_speed = printer.top_speed};
}

std::vector<Violation> implausible_in_other_resins(const PrinterConfig& printer) {
  std::vector<Violation> warnings;
  for (const std::string& name : profiles_in(printer.resins_folder)) {
    if (name == printer.resin) continue;
    std::vector<Violation> found;
    try {
      const fs::path file = printer.resins_folder / (name + ".json");
      found = implausible_values(find_resin(printer, name), file, printer.irradiance_mw_cm2);
    } catch (const ConfigError& error) {
      found = error.violations();
    }
    warnings.insert(warnings.end(), found.begin(), found.end());
  }
  return warnings;
}

}  // namespace contourd
