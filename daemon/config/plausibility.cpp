#include "daemon/config/plausibility.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

std::string ms_text(Duration duration) {
  return std::to_string(std::llround(in_ms(duration))) + " ms";
}

// Projectors' pictures are wider than high: 5:4 to 21:9.
constexpr double kMinAspect = 1.2, kMaxAspect = 2.4;
// Projectors focused on a film have pixels of 47 to 100 um.
constexpr double kMinPitchUm = 10, kMaxPitchUm = 200;

std::string whole_number(double whole) {
  return std::to_string(std::llround(whole));
}

struct Input {
  const char* pointer;
  const char* consequence;  // the effect of a broken wire that goes unnoticed
};

constexpr std::array kInputs{
    Input{"/z_axis/limit_switch", "homing drives the plate on against its end"},
    Input{"/z_axis/second_switch", "a move runs on against the end"},
    Input{"/z_axis/emergency_stop", "pressing it stops nothing"},
    Input{"/z_axis/lid", "the light stays on under an open lid"},
    Input{"/z_axis/power_fail", "a failing supply is found out by the power cut"},
    Input{"/z_axis/force", "resistance does not stop the plate"},
};

// Returns why a broken wire would go unnoticed, as the start of a sentence that the consequence completes;
// empty if it would be noticed.
std::string warning(const std::string& contact, const std::string& bias, bool active_low) {
  if (contact == "normally_open")
    return "the contact is normally open, so a broken wire goes unnoticed: then ";
  const std::string good = active_low ? "pull_up" : "pull_down", bad = active_low ? "pull_down" : "pull_up";
  if (bias == good) return {};
  if (bias == bad) {
    return "the bias " + in_quotes(bias) +
           " pulls the line to its level at rest, so a broken wire goes unnoticed: then ";
  }
  return "the bias " + in_quotes(bias) +
         " leaves a broken wire's level to chance where no resistor is fitted (" + in_quotes(good) +
         " would make it noticed): at worst ";
}

// Plausible exposures. Seconds entered as milliseconds, and most numbers with a digit too few, are below
// these minima. Other hosts use 2.5 to 14 s for a layer and 5 to 35 s for a bottom layer; the limits of one
// of them are 1 to 60 s and 10 to 120 s. A fifth of that minimum, and a tenth for bottom layers, leave room
// for strong lamps.
constexpr double kMinExposureMs = 200, kMaxExposureMs = 60'000, kMinBottomExposureMs = 1'000;
// Other hosts use 60 to 160 ms per micrometre of thickness; a factor of six on either side leaves room.
constexpr double kMinMsPerUm = 10, kMaxMsPerUm = 1'000;
// Printers with projectors use layers of 25 to 100 um.
constexpr double kThinnestUm = 10, kThickestUm = 200;
// Lifts are 2 to 10 mm high, at 1 to 5 mm/s.
constexpr double kMinLiftMm = 1, kMaxLiftMm = 20, kMaxSpeedMmS = 10;

class Warnings {
 public:
  explicit Warnings(std::string file) : file_(std::move(file)) {}

  void add(const char* pointer, double value, const std::string& warning) {
    found_.push_back({file_, pointer, nlohmann::json(value).dump() + " " + warning});
  }
  void add_outside(const char* pointer, double value, double least, double most, const std::string& warning) {
    if (value < least || value > most) add(pointer, value, warning);
  }
  [[nodiscard]] std::vector<Violation> take() { return std::move(found_); }

 private:
  std::string file_;
  std::vector<Violation> found_;
};

void check_exposures(const ResinProfile& resin, double irradiance_mw_cm2, Warnings& warnings) {
  const bool fixed = std::holds_alternative<FixedExposure>(resin.exposure);
  const double um = to_millimeters(resin.layer_height).count() * 1000;
  const int first_normal_layer = resin.bottom_layers + resin.fade_layers;
  const double ms = in_ms(exposure_time(resin, resin.layer_height, first_normal_layer, irradiance_mw_cm2));
  const char* const exposure = fixed ? "/exposure_ms" : "/working_curve";
  if (ms < kMinExposureMs || ms > kMaxExposureMs) {
    warnings.add(exposure, ms, "ms of light on a layer are implausible: 1000 to 60000 are usual");
  } else if (fixed) {
    warnings.add_outside(exposure, ms, kMinMsPerUm * um, kMaxMsPerUm * um,
                         "ms of light are implausible for a layer of " + nlohmann::json(um).dump() +
                             " um: 60 to 160 ms a um are usual");
  }
  if (resin.bottom_layers == 0) return;
  const double bottom_ms = in_ms(exposure_time(resin, resin.layer_height, 0, irradiance_mw_cm2));
  if (bottom_ms < kMinBottomExposureMs)
    warnings.add(fixed ? "/bottom_exposure_ms" : "/working_curve", bottom_ms,
                 "ms of light on a bottom layer are implausible: 5000 to 35000 are usual");
}

}  // namespace

void warn_of_implausible_light(JsonDocument& printer, const ProjectorConfig& projector,
                               const ExposureTolerance& tolerance, Duration exposure) {
  const auto* const serial = std::get_if<SerialProjectorConfig>(&projector);
  if (serial == nullptr || !serial->table.switches_light()) return;
  const ProjectorTable& table = serial->table;
  const auto warn = [&printer](const std::string& what) { printer.add_warning("/projector/table", what); };
  const std::string tolerated = "the resin's exposure_tolerance_ms is " + ms_text(tolerance.bounds) +
                                (tolerance.policy == ExposureTolerance::Policy::Interrupt
                                     ? ", so every layer will wait for the operator"
                                     : ", so every layer will cause a warning");
  const Duration commands = table.wire_time(*table.light_on) + table.wire_time(*table.light_off);
  if (commands > tolerance.bounds) {
    warn("light_on and light_off alone take " + ms_text(commands) + " at " + std::to_string(table.baud) +
         " baud: " + tolerated);
  }
  if (table.latency > tolerance.bounds) {
    warn("its latency_ms is " + ms_text(table.latency) +
         ", and light_off is hardly faster than light_on: " + tolerated);
  }
  const Duration soonest = table.wire_time(*table.light_on) + table.gap;
  if (soonest > exposure) {
    warn("its gap_ms is " + ms_text(table.gap) + ": light_off comes " + ms_text(soonest) +
         " after light_on at the soonest, but the resin's exposure is " + ms_text(exposure) +
         ": layers with this exposure get more light");
  }
  if (table.light_on->timeout >= exposure) {
    warn("the reply to light_on may take " + ms_text(table.light_on->timeout) +
         ", but the resin's exposure is " + ms_text(exposure) +
         ": a lost reply is noticed only after the exposure, and then it is unknown whether there was light");
  }
}

void warn_of_implausible_display(JsonDocument& printer) {
  const auto width = printer.valid_number("/display/width_px"),
             height = printer.valid_number("/display/height_px");
  if (width && height && *height > *width) {
    printer.add_warning("/display/height_px",
                        whole_number(*height) + " is more than width_px, " + whole_number(*width) +
                            ": projectors' pictures are wider than high; are the two swapped?");
  } else if (width && height && (*width < kMinAspect * *height || *width > kMaxAspect * *height)) {
    printer.add_warning("/display/width_px",
                        whole_number(*width) + " by " + whole_number(*height) +
                            " pixels is a shape that no projector's picture has: 5:4 to 21:9 are usual");
  }
  const auto pitch = printer.valid_number("/display/pixel_pitch_um");
  if (pitch && (*pitch < kMinPitchUm || *pitch > kMaxPitchUm)) {
    printer.add_warning(
        "/display/pixel_pitch_um",
        nlohmann::json(*pitch).dump() + " um are implausible: pixels of 30 to 100 um are usual");
  }
}

void warn_of_implausible_contacts(JsonDocument& printer) {
  if (printer.valid_text("/hardware") != "real") return;
  for (const Input& input : kInputs) {
    const std::string place = input.pointer;
    const auto contact = printer.valid_text(place + "/contact"), bias = printer.valid_text(place + "/bias");
    const auto active_low = printer.valid_boolean(place + "/active_low");
    if (!contact || !bias || !active_low) continue;
    const std::string what = warning(*contact, *bias, *active_low);
    if (!what.empty()) printer.add_warning(place, what + input.consequence);
  }
}

std::vector<Violation> implausible_values(const ResinProfile& resin, const std::filesystem::path& file,
                                          double irradiance_mw_cm2) {
  expects(irradiance_mw_cm2 > 0, "there is light");
  Warnings warnings(file.string());
  check_exposures(resin, irradiance_mw_cm2, warnings);
  warnings.add_outside("/layer_height_um", to_millimeters(resin.layer_height).count() * 1000, kThinnestUm,
                       kThickestUm, "um are implausible: layers of 25 to 100 um are usual");
  warnings.add_outside("/lift_mm", to_millimeters(resin.motion.whole_lift()).count(), kMinLiftMm, kMaxLiftMm,
                       "mm are implausible: lifts of 2 to 10 mm are usual");
  for (const auto& [pointer, speed] :
       {std::pair("/lift_speed_mm_s", resin.motion.lift_speed),
        std::pair("/second_lift_speed_mm_s", resin.motion.second_lift_speed),
        std::pair("/retract_speed_mm_s", resin.motion.retract_speed),
        std::pair("/slow_retract_speed_mm_s", resin.motion.slow_retract_speed)})
    warnings.add_outside(pointer, speed.count(), 0, kMaxSpeedMmS,
                         "mm/s are implausible: 1 to 5 mm/s (60 to 300 mm/min) are usual");
  if (const auto* curve = std::get_if<CurveExposure>(&resin.exposure);
      curve != nullptr && curve->overcure.count() == 0)
    warnings.add(
        "/working_curve/overcure_um", 0,
        "um are implausible: a layer that cures no deeper than its thickness does not bond to the one below");
  return warnings.take();
}

}  // namespace contourd
