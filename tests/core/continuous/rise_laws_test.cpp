#include "core/continuous/rise_laws.hpp"

#include <cmath>
#include <numbers>

#include "tests/catch.hpp"
#include "tests/core/continuous/rise_fixture.hpp"

namespace {

using contourd::testing::Approx;

LitResin lit_resin(double irradiance, double depth_um, double dose, double dead_zone_um = 30) {
  return {{Micrometers{depth_um}, MillijoulesPerCm2{dose}},
          MilliwattsPerCm2{irradiance},
          Micrometers{dead_zone_um}};
}

constexpr RefillingResin kThinResin{.viscosity_pa_s = 0.2, .pressure_kpa = 50};

}  // namespace

TEST_CASE("The speed at a margin, its gel gap and its print-through are those of the literature") {
  struct Row {
    LitResin resin;
    double margin, speed_mm_h, gap_um, through_um;
  };
  const LitResin common = lit_resin(4, 150, 8), bright = lit_resin(20, 100, 8), pr48 = lit_resin(20, 53, 6.3);
  for (const auto& [resin, margin, speed_mm_h, gap_um, through_um] :
       {Row{common, 2, 111, 134, 104}, Row{common, 4, 55, 73, 208}, Row{common, 8, 28, 50, 312},
        Row{bright, 2, 333, 99, 69}, Row{bright, 4, 167, 59, 139}, Row{bright, 8, 83, 43, 208},
        Row{pr48, 2, 172, 67, 37}, Row{pr48, 4, 86, 45, 73}, Row{pr48, 8, 43, 37, 110}}) {
    CAPTURE(resin.irradiance.count(), resin.curve.penetration_depth.count(), margin);
    // The table has whole millimetres and micrometres.
    CHECK(mm_h(cure_speed(resin, margin)) == Approx(speed_mm_h).margin(0.5).epsilon(0));
    CHECK(gel_gap(resin, margin).count() == Approx(gap_um).margin(0.55).epsilon(0));
    CHECK(print_through(resin.curve, margin).count() == Approx(through_um).margin(0.55).epsilon(0));
    CHECK(margin_at(resin, cure_speed(resin, margin)) == Approx(margin));
  }
}

TEST_CASE("Resin gels where the dose on its way up passes the critical one") {
  const LitResin resin = lit_resin(4, 150, 8);
  const double margin = 3, speed_um_s = cure_speed(resin, margin).count() * 1000;
  double dose = 0, height_um = resin.dead_zone.count();
  for (const double step_um = 0.001; dose < 8; height_um += step_um)
    dose += 4 * std::exp(-height_um / 150) * step_um / speed_um_s;
  CHECK(gel_gap(resin, margin).count() == Approx(height_um).margin(0.01));
}

TEST_CASE("A plate at rest has an infinite margin, and only the dead zone below it") {
  const LitResin resin = lit_resin(4, 150, 8);
  CHECK(std::isinf(margin_at(resin, MillimetersPerSecond{0})));
  CHECK(gel_gap(resin, margin_at(resin, MillimetersPerSecond{0})).count() == 30);
}

TEST_CASE("Discs fill as fast as the literature has it") {
  struct Row {
    double gap_um, radius_mm, speed_mm_h;
  };
  for (const auto& [gap_um, radius_mm, speed_mm_h] :
       {Row{30, 5, 324}, Row{30, 10, 81}, Row{30, 20, 20}, Row{30, 40, 5}, Row{50, 5, 1500}, Row{50, 10, 375},
        Row{50, 20, 94}, Row{50, 40, 23}}) {
    CAPTURE(gap_um, radius_mm);
    const Millimeters distance{radius_mm / std::numbers::sqrt2};
    CHECK(mm_h(refill_speed(kThinResin, Micrometers{gap_um}, distance)) ==
          Approx(speed_mm_h).margin(0.5).epsilon(0));
  }
}

TEST_CASE("A long strip fills half as fast as a disc of its width") {
  CHECK(mm_h(refill_speed(kThinResin, Micrometers{30}, Millimeters{10})) == Approx(40.5));
  CHECK(std::isinf(refill_speed(kThinResin, Micrometers{30}, Millimeters{0}).count()));
}

TEST_CASE(
    "Resin fills its own gap at the steady speed and at every slower one, and tears a little above it") {
  const LitResin lit = lit_resin(4, 150, 8);
  const MillimetersPerSecond most = cure_speed(lit, 4);
  const auto fills = [&](double distance_mm, MillimetersPerSecond speed) {
    return speed <= refill_speed(kThinResin, gel_gap(lit, margin_at(lit, speed)), Millimeters{distance_mm});
  };
  for (const double distance_mm : {1.0, 10.0, 20.0, 25.0, 28.0, 40.0, 100.0}) {
    CAPTURE(distance_mm);
    const MillimetersPerSecond speed = steady_refill_speed(kThinResin, lit, Millimeters{distance_mm}, most);
    for (int part = 1; part <= 100; ++part)
      CHECK(fills(distance_mm, speed * (part / 100.0)));
    const bool is_cure_limited = speed == most;
    CHECK(is_cure_limited == distance_mm < 26);
    if (!is_cure_limited) CHECK_FALSE(fills(distance_mm, speed * 1.01));
  }
}

TEST_CASE("A machine is as fast as its masks and steps") {
  const RiseMachine machine{Micrometers{2}, 60, Micrometers{2.5}, 10'000};
  CHECK(machine_speed(machine).count() == Approx(0.12));
  CHECK(machine_speed({Micrometers{2}, 60, Micrometers{0.01}, 10'000}).count() == Approx(0.1));
}
