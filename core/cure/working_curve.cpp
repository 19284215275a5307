#include "core/cure/working_curve.hpp"

#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr double kGasConstant = 8.314462618;  // J/(mol K), CODATA 2018
constexpr double kZeroCelsius = 273.15;       // K

void expect_curve(const WorkingCurve& curve) {
  expects(curve.penetration_depth.count() > 0 && curve.critical_dose.count() > 0,
          "a working curve has a positive penetration depth and critical dose");
}

}  // namespace

Micrometers WorkingCurve::depth_of(MillijoulesPerCm2 dose) const {
  expect_curve(*this);
  expects(dose.count() >= 0, "a dose is not negative");
  return penetration_depth * std::log(dose / critical_dose);
}

MillijoulesPerCm2 WorkingCurve::dose_for(Micrometers depth) const {
  expect_curve(*this);
  return critical_dose * std::exp(depth / penetration_depth);
}

WorkingCurve curve_of_ingredients(double absorptivity, double initiator_mol_l, MillijoulesPerCm2 gel_dose) {
  expects(absorptivity > 0 && initiator_mol_l > 0 && gel_dose.count() > 0,
          "absorptivity, concentration and dose are positive");
  constexpr double kMicrometersPerCm = 1e4;
  const double depth_cm = 2 / (2.303 * absorptivity * initiator_mol_l);
  return {Micrometers{depth_cm * kMicrometersPerCm}, gel_dose / std::sqrt(initiator_mol_l)};
}

WorkingCurve at_temperature(const WorkingCurve& curve, const CureTemperature& measured,
                            double temperature_c) {
  expects(measured.measured_at_c > -kZeroCelsius && temperature_c > -kZeroCelsius,
          "temperatures are above absolute zero");
  const double inverse_kelvin =
      1 / (temperature_c + kZeroCelsius) - 1 / (measured.measured_at_c + kZeroCelsius);
  const double factor = std::exp(measured.activation_energy_kj_mol * 1000 / kGasConstant * inverse_kelvin);
  return {curve.penetration_depth, curve.critical_dose * factor};
}

WorkingCurve at_irradiance(const WorkingCurve& curve, const CureIrradiance& measured,
                           MilliwattsPerCm2 irradiance) {
  expects(measured.measured_at.count() > 0 && irradiance.count() > 0, "irradiances are positive");
  return {curve.penetration_depth,
          curve.critical_dose * std::pow(irradiance / measured.measured_at, 1 - measured.exponent)};
}

Micrometers dead_zone_at(Micrometers measured, MilliwattsPerCm2 measured_at, MilliwattsPerCm2 irradiance) {
  expects(measured_at.count() > 0 && irradiance.count() > 0, "irradiances are positive");
  return measured * std::sqrt(measured_at / irradiance);
}

}  // namespace contourd
