// Tests the working curve against the figures that papers and data sheets give; see the sources in the
// header.
#include "core/cure/working_curve.hpp"

#include <array>
#include <cmath>

#include "tests/catch.hpp"

namespace {

WorkingCurve curve(double depth_um, double dose) {
  return {Micrometers{depth_um}, MillijoulesPerCm2{dose}};
}

double depth_um(const WorkingCurve& of, double dose) {
  return of.depth_of(MillijoulesPerCm2{dose}).count();
}

}  // namespace

TEST_CASE("A dose e times the critical one solidifies down to the penetration depth") {
  CHECK(depth_um(curve(150, 8), 8 * std::exp(1.0)) == Approx(150));
  CHECK(depth_um(curve(150, 8), 8) == Approx(0).margin(1e-9));
  CHECK(depth_um(curve(150, 8), 4) < 0);
  CHECK(std::isinf(depth_um(curve(150, 8), 0)));
}

TEST_CASE("The dose for a depth solidifies to this depth") {
  for (const double depth : {-40.0, 0.0, 1.0, 50.0, 333.3})
    CHECK(depth_um(curve(69.3, 17.9), curve(69.3, 17.9).dose_for(Micrometers{depth}).count()) ==
          Approx(depth).margin(1e-9));
}

TEST_CASE("Lee's penetration depths follow from the concentration of the photoinitiator") {
  constexpr double kAbsorptivity = 23000;  // Lee 2001, DBMP at 325 nm
  constexpr std::array concentrations{0.34e-3, 1e-3, 10e-3, 99.7e-3};
  constexpr std::array depths_um{1110.0, 378.0, 38.0, 3.8};
  for (std::size_t i = 0; i < concentrations.size(); ++i) {
    const WorkingCurve of = curve_of_ingredients(kAbsorptivity, concentrations[i], MillijoulesPerCm2{1});
    CHECK(of.penetration_depth.count() == Approx(depths_um[i]).epsilon(0.01));  // as rounded there
  }
}

TEST_CASE("Lee's cure depth is greatest at e (gel dose / dose)^2, where it is half the penetration depth") {
  constexpr double kDose = 100, kGelDose = 4;
  const double best = std::exp(1.0) * (kGelDose / kDose) * (kGelDose / kDose);
  const auto depth = [](double concentration) {
    return depth_um(curve_of_ingredients(23000, concentration, MillijoulesPerCm2{kGelDose}), kDose);
  };
  CHECK(depth(best) > depth(best * 1.01));
  CHECK(depth(best) > depth(best / 1.01));
  CHECK(depth(best) ==
        Approx(curve_of_ingredients(23000, best, MillijoulesPerCm2{kGelDose}).penetration_depth.count() / 2));
}

TEST_CASE("Resin cures deeper when it is warm") {
  // Dp 170 um, Ec 5 mJ/cm2, dose 10 mJ/cm2.
  constexpr std::array temperatures_c{23.0, 25.0, 30.0, 40.0};
  constexpr std::array depths_um{104.0, 118.0, 152.0, 217.0};
  for (std::size_t i = 0; i < temperatures_c.size(); ++i)
    CHECK(std::round(depth_um(at_temperature(curve(170, 5), {}, temperatures_c[i]), 10)) ==
          Approx(depths_um[i]).margin(1));  // rounded there to 1 um
}

TEST_CASE("A warmer resin of 5 degrees has a critical dose that is 18 % less") {
  CHECK(at_temperature(curve(150, 8), {}, 30).critical_dose.count() / 8 == Approx(0.82).margin(0.005));
  CHECK(at_temperature(curve(150, 8), {}, 30).penetration_depth.count() == 150);
}

TEST_CASE("The dead zone falls with the square root of the light") {
  const auto at = [](double irradiance) {
    return dead_zone_at(Micrometers{30}, MilliwattsPerCm2{5}, MilliwattsPerCm2{irradiance}).count();
  };
  CHECK(at(5) == Approx(30));
  CHECK(at(20) == Approx(15));
  CHECK(at(1.25) == Approx(60));
}

TEST_CASE(
    "A resin with reciprocity has one curve, and one with an exponent below 1 cures less in strong light") {
  const auto critical = [](double exponent, double irradiance) {
    const WorkingCurve of =
        at_irradiance(curve(150, 8), {MilliwattsPerCm2{5}, exponent}, MilliwattsPerCm2{irradiance});
    CHECK(of.penetration_depth.count() == 150);
    return of.critical_dose.count();
  };
  CHECK(critical(1, 20) == 8);
  CHECK(critical(0.5, 5) == Approx(8));
  CHECK(critical(0.5, 20) == Approx(16));
  // The time t for a depth follows t I^p.
  CHECK(critical(0.8, 20) / 20 * std::pow(20, 0.8) == Approx(critical(0.8, 2) / 2 * std::pow(2, 0.8)));
}
