#include "daemon/config/resin_plausibility.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

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

std::vector<Violation> implausible_values(const ResinProfile& resin, const std::filesystem::path& file,
                                          double irradiance_mw_cm2) {
  expects(irradiance_mw_cm2 > 0, "there is light");
  Warnings warnings(file.string());
  check_exposures(resin, irradiance_mw_cm2, warnings);
  warnings.add_outside("/layer_height_um", to_millimeters(resin.layer_height).count() * 1000, kThinnestUm,
                       kThickestUm, "um are implausible: layers of 25 to 100 um are usual");
  warnings.add_outside("/lift_mm", to_millimeters(resin.lift).count(), kMinLiftMm, kMaxLiftMm,
                       "mm are implausible: lifts of 2 to 10 mm are usual");
  for (const auto& [pointer, speed] : {std::pair("/lift_speed_mm_s", resin.lift_speed),
                                       std::pair("/retract_speed_mm_s", resin.retract_speed)})
    warnings.add_outside(pointer, speed.count(), 0, kMaxSpeedMmS,
                         "mm/s are implausible: 1 to 5 mm/s (60 to 300 mm/min) are usual");
  if (const auto* curve = std::get_if<WorkingCurve>(&resin.exposure);
      curve != nullptr && curve->overcure.count() == 0)
    warnings.add(
        "/working_curve/overcure_um", 0,
        "um are implausible: a layer that cures no deeper than its thickness does not bond to the one below");
  return warnings.take();
}

}  // namespace contourd
