#include "core/continuous/rise_laws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

void expect_resin(const LitResin& resin) {
  expects(resin.curve.penetration_depth > Micrometers{} && resin.curve.critical_dose > MillijoulesPerCm2{} &&
              resin.irradiance > MilliwattsPerCm2{} && resin.dead_zone >= Micrometers{},
          "lit resin has a working curve, light and a dead zone");
}

// Returns the product of speed and margin: I Dp / Ec exp(-dead zone / Dp). mW over mJ is 1/s.
MillimetersPerSecond speed_times_margin(const LitResin& resin) {
  const double depth_mm = to_millimeters(resin.curve.penetration_depth).count();
  return MillimetersPerSecond{resin.irradiance.count() * depth_mm / resin.curve.critical_dose.count() *
                              std::exp(-(resin.dead_zone / resin.curve.penetration_depth))};
}

}  // namespace

MillimetersPerSecond cure_speed(const LitResin& resin, double margin) {
  expect_resin(resin);
  expects(margin > 1, "a margin is above 1");
  return speed_times_margin(resin) / margin;
}

double margin_at(const LitResin& resin, MillimetersPerSecond speed) {
  expect_resin(resin);
  expects(speed >= MillimetersPerSecond{}, "a rise has a speed");
  if (speed == MillimetersPerSecond{}) return std::numeric_limits<double>::infinity();
  return speed_times_margin(resin) / speed;
}

Micrometers gel_gap(const LitResin& resin, double margin) {
  expect_resin(resin);
  expects(margin > 1, "a margin is above 1");
  // ln(M / (M - 1)), also right for infinite margins.
  return resin.dead_zone - resin.curve.penetration_depth * std::log1p(-1 / margin);
}

Micrometers print_through(const WorkingCurve& curve, double margin) {
  expects(curve.penetration_depth > Micrometers{} && margin > 1, "a margin is above 1");
  return curve.penetration_depth * std::log(margin);
}

MillimetersPerSecond refill_speed(const RefillingResin& resin, Micrometers gap, Millimeters distance) {
  expects(
      resin.viscosity_pa_s > 0 && resin.pressure_kpa > 0 && gap >= Micrometers{} && distance >= Millimeters{},
      "resin flows by pressure through a gap");
  const double gap_mm = to_millimeters(gap).count();
  const double square_mm2 = distance.count() * distance.count();
  if (square_mm2 == 0) return MillimetersPerSecond{std::numeric_limits<double>::infinity()};
  // kPa / (Pa s) is 1000 / s.
  return MillimetersPerSecond{1000 * resin.pressure_kpa * gap_mm * gap_mm * gap_mm /
                              (6 * resin.viscosity_pa_s * square_mm2)};
}

MillimetersPerSecond steady_refill_speed(const RefillingResin& resin, const LitResin& lit,
                                         Millimeters distance, MillimetersPerSecond most) {
  expects(margin_at(lit, most) > 1, "resin cures at the fastest speed");
  // From rest on, each step goes to the speed that the gap of the last one allows. The speeds rise towards
  // the first at which both agree, and every one of them is safe.
  constexpr int kSteps = 200;
  constexpr double kEnough = 1.0001;  // growth that is worth another step
  MillimetersPerSecond speed = std::min(most, refill_speed(resin, lit.dead_zone, distance));
  for (int step = 0; step < kSteps && speed < most; ++step) {
    const MillimetersPerSecond next =
        std::min(most, refill_speed(resin, gel_gap(lit, margin_at(lit, speed)), distance));
    if (!(next > speed * kEnough)) break;
    speed = next;
  }
  return speed;
}

MillimetersPerSecond machine_speed(const RiseMachine& machine) {
  expects(machine.mask_step > Micrometers{} && machine.masks_per_s > 0 && machine.microstep > Micrometers{} &&
              machine.microsteps_per_s > 0,
          "a machine makes masks and steps");
  return MillimetersPerSecond{std::min(to_millimeters(machine.mask_step).count() * machine.masks_per_s,
                                       to_millimeters(machine.microstep).count() * machine.microsteps_per_s)};
}

}  // namespace contourd
