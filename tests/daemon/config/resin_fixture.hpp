// Resin profiles for tests. Not thread-safe.
#pragma once

#include <nlohmann/json.hpp>

#include "daemon/config/resin_profile.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd::testing {

inline constexpr double kIrradianceMwCm2 = 5.0;

// Returns the profile with a working curve instead of its exposures. At kIrradianceMwCm2 and 50 um, the
// exposures are e and e^2 seconds.
inline nlohmann::json with_working_curve(nlohmann::json resin) {
  resin.erase("exposure_ms");
  resin.erase("bottom_exposure_ms");
  resin["working_curve"] = {{"penetration_depth_um", 100},
                            {"critical_energy_mj_cm2", 5},
                            {"overcure_um", 50},
                            {"bottom_overcure_um", 150}};
  return resin;
}

// Loads the profile as "grey", for a printer with a travel of 160 mm and kIrradianceMwCm2.
inline ResinProfile load_resin(const nlohmann::json& resin) {
  const ConfigFolder folder;
  return load_resin_profile(folder.write_json("grey.json", resin),
                            {.travel = Nanometers{160'000'000}, .irradiance_mw_cm2 = kIrradianceMwCm2});
}

inline Complaints resin_complaints(const nlohmann::json& resin) {
  return complaints_of([&] { (void)load_resin(resin); });
}

}  // namespace contourd::testing
