// The laws that bound the speed of a plate that rises without a stop while the light stays on. Values and
// pure functions; thread-safe.
//
// Above the window lies resin that oxygen keeps liquid, the dead zone. Resin that rises from there gets the
// dose I Dp / v exp(-dead zone / Dp) in all, its margin M times the critical dose Ec, and gels where its dose
// passes Ec: at the gel gap g = dead zone + Dp ln(M / (M - 1)) above the window. Fresh resin must flow
// through this gap, a flow between plates (Hele-Shaw): div(grad p) = 12 viscosity v / gap^3.
#pragma once

#include "core/cure/working_curve.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// Resin between the window and the part, in the light.
struct LitResin {
  WorkingCurve curve{};
  MilliwattsPerCm2 irradiance{};
  Micrometers dead_zone{};
};

// Returns the speed at which rising resin gets `margin` times its critical dose: the fastest at which it
// cures with this margin. REQUIRES: a curve and an irradiance of positive values, dead_zone >= 0, margin > 1.
[[nodiscard]] MillimetersPerSecond cure_speed(const LitResin& resin, double margin);
// Returns the margin at a speed; infinity at rest. REQUIRES: as above; speed >= 0.
[[nodiscard]] double margin_at(const LitResin& resin, MillimetersPerSecond speed);

// Returns the height above the window at which resin gels. REQUIRES: as above; margin > 1.
[[nodiscard]] Micrometers gel_gap(const LitResin& resin, double margin);
// Returns the depth to which light solidifies resin above a thick part's underside. The thinnest slab that
// holds is gel_gap() - dead_zone thick. REQUIRES: Dp > 0, margin > 1.
[[nodiscard]] Micrometers print_through(const WorkingCurve& curve, double margin);

// Resin that flows into the gap.
struct RefillingResin {
  double viscosity_pa_s = 0;
  double pressure_kpa = 0;  // pressure lost on the way in, less than the air's, because the resin tears
};

// Returns the fastest speed at which resin fills the gap: pressure gap^3 / (6 viscosity distance^2), exact
// for a long strip whose middle is at this distance from its rims. A disc of radius R fills twice as fast, as
// a strip with the distance R / sqrt(2). Infinity for no distance. REQUIRES: positive values, distance >= 0.
[[nodiscard]] MillimetersPerSecond refill_speed(const RefillingResin& resin, Micrometers gap,
                                                Millimeters distance);

// Returns the fastest speed up to `most` at which resin fills its own gel gap, at this and at every slower
// speed: the slower the plate rises, the more dose the resin gets and the narrower the gap becomes.
// REQUIRES: as for the functions above; `most` has a margin above 1.
[[nodiscard]] MillimetersPerSecond steady_refill_speed(const RefillingResin& resin, const LitResin& lit,
                                                       Millimeters distance, MillimetersPerSecond most);

// The machine's work in a second.
struct RiseMachine {
  Micrometers mask_step{};  // travel after which a mask is out of date
  double masks_per_s = 0;
  Micrometers microstep{};
  double microsteps_per_s = 0;
};

// Returns the fastest speed of the machine. REQUIRES: positive values.
[[nodiscard]] MillimetersPerSecond machine_speed(const RiseMachine& machine);

}  // namespace contourd
