#include "daemon/config/resin_plausibility.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

namespace contourd {
namespace {

// What is left of seconds that were taken for milliseconds is below the least, and so are slips by a digit.
// Other hosts give a layer 2.5 to 14 s and a bottom layer 5 to 35 s; one of them takes 1 to 60 s and 10 to
// 120 s at all. A fifth of the least, and a tenth of that of bottom layers, leave room for strong lamps.
constexpr double kLeastExposureMs = 200, kMostExposureMs = 60'000, kLeastBottomExposureMs = 1'000;
// 60 to 160 ms a micrometre of thickness is what they give; six times less and more leave room again.
constexpr double kLeastMsPerUm = 10, kMostMsPerUm = 1'000;
// Printers with projectors lay layers of 25 to 100 um.
constexpr double kThinnestUm = 10, kThickestUm = 200;
// Lifts are 2 to 10 mm high, at 1 to 5 mm/s.
constexpr double kLeastLiftMm = 1, kMostLiftMm = 20, kMostSpeedMmS = 10;

class Doubts {
 public:
  explicit Doubts(std::string file) : file_(std::move(file)) {}

  void add(const char* pointer, double value, const std::string& doubt) {
    found_.push_back({file_, pointer, nlohmann::json(value).dump() + " " + doubt});
  }
  void add_outside(const char* pointer, double value, double least, double most, const std::string& doubt) {
    if (value < least || value > most) add(pointer, value, doubt);
  }
  [[nodiscard]] std::vector<Violation> take() { return std::move(found_); }

 private:
  std::string file_;
  std::vector<Violation> found_;
};

double in_ms(Duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

void doubt_exposures(const ResinProfile& resin, double irradiance_mw_cm2, Doubts& doubts) {
  const bool fixed = std::holds_alternative<FixedExposure>(resin.exposure);
  const double um = to_millimeters(resin.layer_height).count() * 1000;
  const int behind_fade = resin.bottom_layers + resin.fade_layers;
  const double ms = in_ms(exposure_time(resin, resin.layer_height, behind_fade, irradiance_mw_cm2));
  const char* const exposure = fixed ? "/exposure_ms" : "/working_curve";
  if (ms < kLeastExposureMs || ms > kMostExposureMs) {
    doubts.add(exposure, ms, "ms of light on a layer are hardly meant: 1000 to 60000 are usual");
  } else if (fixed) {
    doubts.add_outside(exposure, ms, kLeastMsPerUm * um, kMostMsPerUm * um,
                       "ms of light are hardly meant for a layer of " + nlohmann::json(um).dump() +
                           " um: 60 to 160 ms a um are usual");
  }
  if (resin.bottom_layers == 0) return;
  const double bottom_ms = in_ms(exposure_time(resin, resin.layer_height, 0, irradiance_mw_cm2));
  if (bottom_ms < kLeastBottomExposureMs)
    doubts.add(fixed ? "/bottom_exposure_ms" : "/working_curve", bottom_ms,
               "ms of light on a bottom layer are hardly meant: 5000 to 35000 are usual");
}

}  // namespace

std::vector<Violation> doubts_about(const ResinProfile& resin, const std::filesystem::path& file,
                                    double irradiance_mw_cm2) {
  Doubts doubts(file.string());
  doubt_exposures(resin, irradiance_mw_cm2, doubts);
  doubts.add_outside("/layer_height_um", to_millimeters(resin.layer_height).count() * 1000, kThinnestUm,
                     kThickestUm, "um are hardly meant: layers of 25 to 100 um are usual");
  doubts.add_outside("/lift_mm", to_millimeters(resin.lift).count(), kLeastLiftMm, kMostLiftMm,
                     "mm are hardly meant: lifts of 2 to 10 mm are usual");
  for (const auto& [pointer, speed] : {std::pair("/lift_speed_mm_s", resin.lift_speed),
                                       std::pair("/retract_speed_mm_s", resin.retract_speed)})
    doubts.add_outside(pointer, speed.count(), 0, kMostSpeedMmS,
                       "mm/s are hardly meant: 1 to 5 mm/s (60 to 300 mm/min) are usual");
  if (const auto* curve = std::get_if<WorkingCurve>(&resin.exposure);
      curve != nullptr && curve->overcure.count() == 0)
    doubts.add("/working_curve/overcure_um", 0,
               "um are hardly meant: a layer that cures no deeper than it is thick bonds to none");
  return doubts.take();
}

}  // namespace contourd
