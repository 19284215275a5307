// Working curve of a resin: the depth to which a dose of light solidifies it. Values and pure functions;
// thread-safe.
//
// The depth is Cd = Dp ln(E / Ec): Jacobs 1992, thesis equation 2.1. Light falls to 1/e over the penetration
// depth Dp, and resin gels where it has received the critical dose Ec.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd {

struct WorkingCurve {
  Micrometers penetration_depth{};    // Dp
  MillijoulesPerCm2 critical_dose{};  // Ec

  // Returns the depth below the lit surface to which a dose solidifies; negative if it does not even solidify
  // the surface, -infinity for no dose. REQUIRES: dose >= 0; this curve and the following have positive
  // values.
  [[nodiscard]] Micrometers depth_of(MillijoulesPerCm2 dose) const;
  // Returns the dose at the lit surface that solidifies to a depth.
  [[nodiscard]] MillijoulesPerCm2 dose_for(Micrometers depth) const;

  bool operator==(const WorkingCurve&) const = default;
};

// Returns the working curve of a resin by its ingredients: Lee 2001, thesis equations 2.2 to 2.4.
// `absorptivity` is the photoinitiator's molar absorptivity in L/(mol cm), `initiator_mol_l` its
// concentration, `gel_dose` the critical dose at 1 mol/L. Lee's penetration depth is that of the
// polymerization rate, which grows with the square root of the light, and so is twice the light's.
// REQUIRES: positive values.
[[nodiscard]] WorkingCurve curve_of_ingredients(double absorptivity, double initiator_mol_l,
                                                MillijoulesPerCm2 gel_dose);

// The temperature at which a working curve was measured, and how its critical dose changes with temperature.
struct CureTemperature {
  double measured_at_c = 25;
  double activation_energy_kj_mol = 30;  // 15 to 50; estimated for acrylates

  bool operator==(const CureTemperature&) const = default;
};

// Returns the curve at another temperature: Ec follows Arrhenius' law, Dp stays. REQUIRES: both temperatures
// are above absolute zero.
[[nodiscard]] WorkingCurve at_temperature(const WorkingCurve& curve, const CureTemperature& measured,
                                          double temperature_c);

// The irradiance at which a working curve was measured, and how the resin answers to another one.
struct CureIrradiance {
  MilliwattsPerCm2 measured_at{};
  // p: the resin cures by t I^p. 1 if the dose alone counts (reciprocity); below 1, strong light cures less
  // per dose than weak light.
  double exponent = 1;

  bool operator==(const CureIrradiance&) const = default;
};

// Returns the curve at another irradiance: Ec grows by (I / I_measured)^(1 - p), Dp stays. REQUIRES: positive
// irradiances.
[[nodiscard]] WorkingCurve at_irradiance(const WorkingCurve& curve, const CureIrradiance& measured,
                                         MilliwattsPerCm2 irradiance);

// Returns the thickness of the resin next to an oxygen-permeable window that oxygen keeps liquid, at another
// irradiance than the one at which it was measured: it falls with the square root of the light (Tumbleston et
// al. 2015: C sqrt(Dc0 / (Phi0 alpha)), of which only Phi0 changes with the light). REQUIRES: positive
// irradiances.
[[nodiscard]] Micrometers dead_zone_at(Micrometers measured, MilliwattsPerCm2 measured_at,
                                       MilliwattsPerCm2 irradiance);

}  // namespace contourd
