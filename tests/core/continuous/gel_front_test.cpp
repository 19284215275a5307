#include "core/continuous/gel_front.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/cure/cured_layers.hpp"
#include "tests/catch.hpp"

namespace {

using contourd::testing::Approx;

LitResin resin_of(double depth_um, double critical_mj, double irradiance, double dead_zone_um) {
  return {{Micrometers{depth_um}, MillijoulesPerCm2{critical_mj}},
          MilliwattsPerCm2{irradiance},
          Micrometers{dead_zone_um}};
}

const std::vector<LitResin> kResins{resin_of(150, 8, 4, 30), resin_of(150, 8, 25, 0),
                                    resin_of(60, 15, 10, 80), resin_of(400, 5, 3, 10)};
constexpr double kFrame = 1.0 / 60;
constexpr MillimetersPerSecond kMasks{0.5};
constexpr Nanometers kSolid{2'000'000};

Nanometers um(double um) {
  return Nanometers{std::llround(um * 1000)};
}
double in_um(Nanometers height) {
  return in_mm(height) * 1000;
}

// A refresh of a rise.
struct Refresh {
  Nanometers plate;  // at its end
  GelFront::Light light;
};

// Returns a rise of 1 mm in the light whose speed and light change, by laws of their own.
std::vector<Refresh> uneven_rise(const LitResin& resin, std::mt19937& random) {
  std::uniform_real_distribution<double> part;
  std::vector<Refresh> rise;
  double plate_um = in_um(kSolid), speed_um_s = 0, share = 1, until_um = 0;
  while (plate_um < in_um(kSolid) + 1000) {
    if (plate_um >= until_um) {
      share = part(random) < 0.5 ? 1 : 0.3 + 0.7 * part(random);
      const double margin = 1.3 + 12 * part(random);
      speed_um_s = std::min(1000 * cure_speed(resin, margin).count() * share, 120.0);
      until_um = plate_um + 20 + 200 * part(random);
    }
    plate_um += speed_um_s * kFrame;
    rise.push_back({um(plate_um), {std::chrono::duration<double>(kFrame), share}});
  }
  return rise;
}

// Returns the dose of resin at a height after some refreshes, over Ec, summed from its definition.
double dose_at(double z_um, std::span<const Refresh> rise, const LitResin& resin) {
  const double depth = resin.curve.penetration_depth.count();
  constexpr int kParts = 20;
  double plate_um = in_um(kSolid), dose = 0;
  for (const Refresh& refresh : rise) {
    const double way_um = in_um(refresh.plate) - plate_um;
    for (int part = 0; part < kParts; ++part) {
      const double x = plate_um + way_um * (part + 0.5) / kParts;
      if (x >= z_um + resin.dead_zone.count())
        dose += refresh.light.time.count() * refresh.light.share / kParts * std::exp(-(x - z_um) / depth);
    }
    plate_um += way_um;
  }
  return dose * resin.irradiance.count() / resin.curve.critical_dose.count();
}

// Returns the top of a column that is lit while the front is beneath `top`, with the plate's heights and
// doses of a rise, in um.
double cured_top_um(const LitResin& resin, std::span<const Refresh> rise, double top_um) {
  GelFront front(resin, kSolid, kMasks);
  std::vector<LayerDose> layers;
  std::vector<float> light;
  Nanometers beneath = kSolid;
  for (const Refresh& refresh : rise) {
    light.push_back(in_um(front.height()) < top_um ? 1.F : 0.F);
    layers.push_back(
        {std::max(refresh.plate, beneath + Nanometers{1}),
         {},
         refresh.light.time.count() * refresh.light.share * resin.irradiance.count() * MillijoulesPerCm2{1},
         false});
    layers.back().thickness = layers.back().top - std::exchange(beneath, layers.back().top);
    front.add(refresh.plate, refresh.light);
  }
  CuredLayers cured({.curve = resin.curve, .dead_zone = resin.dead_zone}, 1);
  for (std::size_t i = layers.size(); i-- > 0;) {
    const float dose = cured.add_layer(layers[i], std::span(&light[i], 1))[0];
    if (cured.solid_thickness(layers[i], dose).count() > 0) return cured.solid_top(layers[i]).count() * 1000;
  }
  return 0;
}

}  // namespace

TEST_CASE("At a constant speed, the front is the gel gap below the plate") {
  for (const LitResin& resin : kResins) {
    for (const double margin : {1.2, 2.0, 4.0, 10.0}) {
      CAPTURE(resin.curve.penetration_depth.count(), resin.dead_zone.count(), margin);
      const double gap_um = gel_gap(resin, margin).count();
      const double speed_um_s = 1000 * cure_speed(resin, margin).count();
      GelFront front(resin, kSolid, MillimetersPerSecond{1});
      double plate_um = in_um(kSolid);
      while (plate_um < in_um(kSolid) + gap_um + 500) {
        plate_um += speed_um_s * kFrame;
        front.add(um(plate_um), {std::chrono::duration<double>(kFrame)});
      }
      CHECK(plate_um - in_um(front.height()) == Approx(gap_um).margin(0.5));  // the shortest stretch, 0.25 um
      const double next_um = plate_um + speed_um_s * kFrame * 1.5;
      CHECK(next_um - in_um(front.ahead(um(next_um), {std::chrono::duration<double>(kFrame * 1.5)})) ==
            Approx(gap_um).margin(0.5));
    }
  }
}

TEST_CASE("Resin at the front has its critical dose, however speed and light change") {
  std::mt19937 random(7);
  for (const LitResin& resin : kResins) {
    for (int print = 0; print < 5; ++print) {
      const std::vector<Refresh> rise = uneven_rise(resin, random);
      GelFront front(resin, kSolid, MillimetersPerSecond{10});
      for (std::size_t i = 0; i < rise.size(); ++i) {
        const Nanometers before = front.height();
        front.add(rise[i].plate, rise[i].light);
        REQUIRE(front.height() >= before);
        if (i % 97 != 0 || front.height() == kSolid) continue;
        CAPTURE(resin.curve.penetration_depth.count(), print, i, in_um(front.height()));
        // The plate's way of half a um, at the least margin, is the dose of 0.3 um in the depth of 60.
        const std::span so_far(rise.data(), i + 1);
        CHECK(dose_at(in_um(front.height()) - 1, so_far, resin) > 1);
        CHECK(dose_at(in_um(front.height()) + 1, so_far, resin) < 1);
      }
      CHECK(front.height() > kSolid + um(300));
    }
  }
}

TEST_CASE("A column that is lit until the front reaches its top ends there, however speed and light change") {
  std::mt19937 random(11);
  for (const LitResin& resin : kResins) {
    for (int print = 0; print < 10; ++print) {
      const std::vector<Refresh> rise = uneven_rise(resin, random);
      for (const double above_um : {150.0, 333.0, 500.0}) {
        CAPTURE(resin.curve.penetration_depth.count(), resin.dead_zone.count(), print, above_um);
        const double top_um = in_um(kSolid) + above_um;
        // A mask stays for a refresh, in which the front may rise by more than the plate's 2 um.
        CHECK(cured_top_um(resin, rise, top_um) == Approx(top_um).margin(6));
      }
    }
  }
}

TEST_CASE(
    "A front rises no faster than masks can follow, and comes up to the dead zone where the plate stands") {
  const LitResin& resin = kResins[0];
  GelFront front(resin, kSolid, MillimetersPerSecond{0.012});
  front.add(kSolid, {});
  front.add(kSolid + um(200), {std::chrono::duration<double>(12)});
  for (int refresh = 0; refresh < 1000; ++refresh) {
    const Nanometers before = front.height();
    front.add(kSolid + um(200), {std::chrono::duration<double>(kFrame)});
    REQUIRE(in_um(front.height() - before) <= 0.2 + 1e-3);
  }
  CHECK(in_um(kSolid + um(200) - front.height()) == Approx(30).margin(0.5));
}

TEST_CASE("Liquid that is stirred in the dark loses its dose, and what has gelled stays") {
  const LitResin& resin = kResins[0];
  const double speed_um_s = 1000 * cure_speed(resin, 4).count(), gap_um = gel_gap(resin, 4).count();
  GelFront front(resin, kSolid, kMasks);
  double plate_um = in_um(kSolid);
  const auto rise = [&](double way_um) {
    for (const double end = plate_um + way_um; plate_um < end; plate_um += speed_um_s * kFrame)
      front.add(um(plate_um), {std::chrono::duration<double>(kFrame)});
  };
  rise(300);
  const Nanometers gelled = front.height();
  front.forget();
  CHECK(front.height() == gelled);
  rise(20);
  CHECK(front.height() == gelled);
  rise(200);
  CHECK(plate_um - in_um(front.height()) == Approx(gap_um).margin(1));
}
