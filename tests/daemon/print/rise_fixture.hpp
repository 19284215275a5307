// A resin and a printer for continuous prints.
#pragma once

#include <chrono>

#include "daemon/print/rise_forecast.hpp"

namespace contourd::testing {

inline ResinProfile window_resin() {
  ResinProfile resin;
  resin.name = "clear";
  resin.cure = CureSettings{.curve = {Micrometers{150}, MillijoulesPerCm2{8}}, .dead_zone = Micrometers{30}};
  resin.viscosity_mpa_s = 200;
  resin.continuous = ContinuousResin{.margin = 4,
                                     .refill_pressure_kpa = 50,
                                     .window = std::chrono::minutes{20},
                                     .recovery = std::chrono::minutes{2},
                                     .layered = Nanometers{940'000},
                                     .mask_step = Micrometers{2},
                                     .slowest = MillimetersPerSecond{5.0 / 3600},
                                     .fastest = MillimetersPerSecond{1000.0 / 3600}};
  return resin;
}

inline constexpr ContinuousMachine kWindowPrinter{.irradiance_mw_cm2 = 4,
                                                  .masks_per_s = 60,
                                                  .microstep = Micrometers{1.25},
                                                  .acceleration = MillimetersPerSecondSquared{25},
                                                  .mask_budget = std::chrono::seconds{1}};

}  // namespace contourd::testing
