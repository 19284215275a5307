#include "daemon/config/resin_profile.hpp"

#include "daemon/config/support_figures.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/resin_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

json curve_profile() {
  return testing::with_working_curve(shipped("resins/standard.json"));
}

// True if they differ by less than 1 us: a millionth of the shortest realistic exposure, far above rounding
// to 1 ns.
bool within_a_microsecond(Duration a, double milliseconds_expected) {
  return std::fabs(std::chrono::duration<double, std::milli>(a).count() - milliseconds_expected) < 1e-3;
}

TEST_CASE("every key of a resin profile is read with its unit, and the file gives the name") {
  const ResinProfile resin = load_resin(shipped("resins/standard.json"));
  CHECK(resin.name == "grey");
  CHECK(resin.layer_height == Nanometers{50'000});
  CHECK(resin.layer_height_min == Nanometers{25'000});
  CHECK(resin.layer_height_max == Nanometers{100'000});
  CHECK(std::get<FixedExposure>(resin.exposure).exposure == milliseconds{3000});
  CHECK(std::get<FixedExposure>(resin.exposure).bottom_exposure == milliseconds{30000});
  CHECK(resin.bottom_layers == 5);
  CHECK(resin.fade_layers == 10);
  CHECK(resin.motion.lift == Nanometers{2'000'000});
  CHECK(resin.motion.lift_speed == MillimetersPerSecond{1.5});
  CHECK(resin.motion.second_lift == Nanometers{1'500'000});
  CHECK(resin.motion.second_lift_speed == MillimetersPerSecond{5});
  CHECK(resin.motion.retract_speed == MillimetersPerSecond{5});
  CHECK(resin.motion.slow_retract == Nanometers{300'000});
  CHECK(resin.motion.slow_retract_speed == MillimetersPerSecond{1});
  CHECK(resin.viscosity_mpa_s == 200);
  CHECK(resin.motion.settle == milliseconds{200});
  CHECK(resin.motion.rest == milliseconds{500});

  const ResinProfile by_curve = load_resin(curve_profile());
  const auto exposure = std::get<CurveExposure>(by_curve.exposure);
  CHECK(exposure.overcure == Micrometers{50.0});
  CHECK(exposure.bottom_overcure == Micrometers{150.0});
  REQUIRE(by_curve.cure.has_value());
  CHECK(by_curve.cure->curve == WorkingCurve{Micrometers{100.0}, MillijoulesPerCm2{5.0}});
}

TEST_CASE("a resin's supports have their defaults except for the keys in its profile") {
  json resin = shipped("resins/standard.json");
  CHECK(load_resin(resin).supports == SupportSettings{});
  resin["supports"] = {{"tip_diameter_mm", 0.5}, {"tip_holds_mm2", 8.5}, {"lift_mm", 3}};
  SupportSettings expected;
  expected.tip_diameter = Millimeters{0.5};
  expected.tip_holds_mm2 = 8.5;
  expected.lift = Millimeters{3};
  CHECK(load_resin(resin).supports == expected);
  resin["supports"]["spacing_mm"] = 0.4;
  CHECK(resin_complaints(resin) ==
        Complaints{"/supports/spacing_mm: 0.4 is less than the least allowed, 0.5 mm"});
}

TEST_CASE("each key of a resin's supports sets its own setting") {
  json resin = shipped("resins/standard.json");
  double value = 2;
  for (const SupportFigure& figure : support_figures())
    resin["supports"][std::string(figure.key)] = value += 0.001;
  // The lift must be larger than two of the other values together.
  resin["supports"]["lift_mm"] = 5.5;
  const SupportSettings read = load_resin(resin).supports;
  value = 2;
  for (const SupportFigure& figure : support_figures()) {
    value += 0.001;
    CHECK(figure.get(read) == (figure.key == "lift_mm" ? 5.5 : value));
  }
}

TEST_CASE("contradictory values of supports are reported with both values") {
  const auto complaints = [](const json& supports) {
    json resin = shipped("resins/standard.json");
    resin["supports"] = supports;
    return resin_complaints(resin);
  };
  CHECK(complaints({{"tip_diameter_mm", 1.2}}) ==
        Complaints{"/supports/tip_diameter_mm: 1.2 mm is more than pillar_diameter_mm, 1 mm: a tip is no "
                   "thicker than its pillar"});
  CHECK(complaints({{"foot_diameter_mm", 0.9}}) ==
        Complaints{"/supports/foot_diameter_mm: 0.9 mm is less than pillar_diameter_mm, 1 mm: a foot is no "
                   "thinner than its pillar"});
  CHECK(complaints({{"tip_depth_mm", 1.1}}) ==
        Complaints{"/supports/tip_depth_mm: 1.1 mm is more than tip_length_mm, 1 mm: a tip is not deeper in "
                   "the model than it is long"});
  CHECK(complaints({{"lift_mm", 1.9}}) ==
        Complaints{"/supports/lift_mm: 1.9 mm is less than foot_height_mm and tip_length_mm together, 2 mm: "
                   "there is no room for a support"});
  // Equal values are no contradiction.
  CHECK(complaints({{"tip_diameter_mm", 1}, {"foot_diameter_mm", 1}, {"tip_depth_mm", 1}, {"lift_mm", 2}})
            .empty());
}

TEST_CASE("a resin's shrinkage is read as the factors that compensate it") {
  json resin = shipped("resins/standard.json");
  CHECK(load_resin(resin).shrinkage_factors == Scale{});
  resin["shrinkage_percent"] = {{"x", 20}, {"y", -0.5}};
  const Scale factors = load_resin(resin).shrinkage_factors;
  // 400 pixels shrink to 320: 500 are needed.
  CHECK(factors.x == 1.25);
  CHECK(std::fabs(factors.y - 1 / 1.005) < 1e-15);
  CHECK(factors.z == 1);
  resin["shrinkage_percent"]["z"] = 21;
  CHECK(resin_complaints(resin) == Complaints{"/shrinkage_percent/z: 21 is more than the limit, 20"});
}

TEST_CASE("a resin's orientation weights are read, with contourd's own as defaults") {
  json resin = shipped("resins/standard.json");
  CHECK(load_resin(resin).orientation == OrientationWeights{});
  resin["orientation_weights"] = {{"support", 3}, {"contacts", 0.5}, {"peel", 100},
                                  {"height", 0},  {"standing", 2},   {"keep_clean", 1}};
  CHECK(load_resin(resin).orientation == OrientationWeights{3, 0.5, 100, 0, 2, 1});
  resin["orientation_weights"]["peel"] = 101;
  CHECK(resin_complaints(resin) == Complaints{"/orientation_weights/peel: 101 is more than the limit, 100"});
  resin["orientation_weights"] = {{"speed", 1}};
  CHECK(resin_complaints(resin).size() == 1);
}

TEST_CASE("a fixed exposure starts with the bottom one, fades linearly, then stays") {
  const ResinProfile resin = load_resin(shipped("resins/standard.json"));
  const auto layer = [&](int index) {
    return exposure_time(resin, resin.layer_height, index, kIrradianceMwCm2);
  };
  CHECK(layer(0) == milliseconds{30000});
  CHECK(layer(4) == milliseconds{30000});
  // 10 fade layers cut 27 s into 11 equal steps.
  CHECK(within_a_microsecond(layer(5), 30000.0 - 27000.0 / 11.0));
  CHECK(within_a_microsecond(layer(9), 30000.0 - 27000.0 * 5.0 / 11.0));
  CHECK(within_a_microsecond(layer(14), 3000.0 + 27000.0 / 11.0));
  CHECK(layer(15) == milliseconds{3000});
  CHECK(layer(1'000'000) == milliseconds{3000});
  for (int index = 0; index < 20; ++index)
    CHECK(layer(index + 1) <= layer(index));
  CHECK(exposure_time(resin, Nanometers{25'000}, 15, 1.0) == milliseconds{3000});
}

TEST_CASE("the working curve gives t = Ec / I exp((layer height + overcure) / Dp)") {
  const ResinProfile resin = load_resin(curve_profile());
  const auto layer = [&](double height_um, int index, double irradiance) {
    return exposure_time(resin, Nanometers{std::llround(height_um * 1e3)}, index, irradiance);
  };
  // 5 / 5 exp((50 + 50) / 100) = e s; the bottom: exp((50 + 150) / 100) = e^2 s.
  CHECK(within_a_microsecond(layer(50, 100, 5.0), 2718.281828));
  CHECK(within_a_microsecond(layer(50, 0, 5.0), 7389.056099));
  // Twice the light is half the time; a layer higher by about Dp ln 2 takes twice as long.
  CHECK(within_a_microsecond(layer(50, 100, 10.0), 1359.140914));
  CHECK(within_a_microsecond(layer(119.315, 100, 5.0), 5436.578985));
  CHECK(within_a_microsecond(layer(5, 4, 5.0), 4711.470183));  // exp(1.55)
}

TEST_CASE("without fade layers the exposure changes at once, and without bottom layers it never changes") {
  json profile = shipped("resins/standard.json");
  profile["fade_layers"] = 0;
  const ResinProfile sudden = load_resin(profile);
  CHECK(exposure_time(sudden, sudden.layer_height, 4, 5.0) == milliseconds{30000});
  CHECK(exposure_time(sudden, sudden.layer_height, 5, 5.0) == milliseconds{3000});
  profile["bottom_layers"] = 0;
  CHECK(exposure_time(load_resin(profile), Nanometers{50'000}, 0, 5.0) == milliseconds{3000});
}

TEST_CASE("an exposure too long for a duration throws instead of overflowing") {
  ResinProfile resin = load_resin(curve_profile());
  resin.cure.value().curve.penetration_depth = Micrometers{0.001};
  CHECK_THROWS_AS(exposure_time(resin, Nanometers{50'000}, 100, 5.0), std::range_error);
}

TEST_CASE("a profile has either fixed exposures or a working curve") {
  const std::string choice =
      "give either \"exposure_ms\" and \"bottom_exposure_ms\", or \"working_curve\"; found ";
  json resin = shipped("resins/standard.json");
  resin.erase("bottom_exposure_ms");
  CHECK(resin_complaints(resin) == Complaints{choice + "only \"exposure_ms\""});
  resin.erase("exposure_ms");
  CHECK(resin_complaints(resin) == Complaints{choice + "neither"});
  json both = curve_profile();
  both["exposure_ms"] = 3000;
  CHECK(resin_complaints(both) == Complaints{choice + "\"exposure_ms\" and \"working_curve\""});
  both["bottom_exposure_ms"] = 30000;
  CHECK(resin_complaints(both) ==
        Complaints{choice + "\"exposure_ms\" and \"bottom_exposure_ms\" and \"working_curve\""});
  both["working_curve"]["overcure_um"] = -1;
  CHECK(resin_complaints(both).size() == 2);
}

TEST_CASE("a mistake inside the working curve is reported there and nowhere else") {
  json resin = curve_profile();
  resin["working_curve"]["penetration_depth_um"] = 0;
  resin["working_curve"].erase("overcure_um");
  CHECK(resin_complaints(resin) ==
        Complaints{"/working_curve/overcure_um: this key is missing: Cure depth beyond the layer height, so "
                   "that layers "
                   "bond, in um",
                   "/working_curve/penetration_depth_um: 0 is less than the least allowed, 1 um"});
}

TEST_CASE("critical energy and dead zone follow the printer's irradiance from that of the curve") {
  json resin = curve_profile();
  resin["working_curve"]["dead_zone_um"] = 30;
  resin["working_curve"]["irradiance_mw_cm2"] = 20;  // the printer has 5
  CHECK(load_resin(resin).cure->curve.critical_dose == MillijoulesPerCm2{5});
  CHECK(load_resin(resin).cure->dead_zone == Micrometers{60});
  resin["working_curve"]["reciprocity_exponent"] = 0.5;
  const ResinProfile weak = load_resin(resin);
  CHECK(weak.cure->curve.critical_dose.count() == Approx(2.5));
  CHECK(weak.cure_irradiance == CureIrradiance{MilliwattsPerCm2{20}, 0.5});
  // Exposures follow: of e seconds by the dose alone, a half.
  CHECK(within_a_microsecond(exposure_time(weak, weak.layer_height, 100, testing::kIrradianceMwCm2),
                             500 * std::exp(1)));
  // Without a printer, the curve is the profile's.
  const ConfigFolder folder;
  const ResinProfile alone = load_resin_profile(folder.write_json("grey.json", resin), {});
  CHECK(alone.cure->curve.critical_dose == MillijoulesPerCm2{5});
  CHECK(alone.cure->dead_zone == Micrometers{30});
  resin["working_curve"].erase("irradiance_mw_cm2");
  CHECK(resin_complaints(resin) ==
        Complaints{"/working_curve/reciprocity_exponent: 0.5 needs irradiance_mw_cm2, at which the curve was "
                   "measured"});
}

TEST_CASE("an exposure beyond its limits names the critical energy at the printer's irradiance") {
  json resin = curve_profile();
  resin["working_curve"]["irradiance_mw_cm2"] = 20;
  resin["working_curve"]["reciprocity_exponent"] = 0.5;
  resin["working_curve"]["bottom_overcure_um"] = 600;
  const Complaints complaints = resin_complaints(resin);
  REQUIRE(complaints.size() == 1);
  CHECK_THAT(complaints[0],
             Catch::Matchers::Contains("critical_energy_mj_cm2 2.5 (at this irradiance) and "));
}

TEST_CASE("a curve by the resin's ingredients stands in place of a measured one, but not for undersides") {
  json resin = curve_profile();
  json& curve = resin["working_curve"];
  curve.erase("penetration_depth_um");
  curve.erase("critical_energy_mj_cm2");
  curve.update({{"absorptivity_l_mol_cm", 23000},
                {"initiator_mmol_l", 4},
                {"gel_dose_mj_cm2", 0.5},
                {"peel_memory", 0.9}});
  ResinProfile mixed = load_resin(resin);
  CHECK(mixed.cure->curve == curve_of_ingredients(23000, 0.004, MillijoulesPerCm2{0.5}));
  CHECK_FALSE(mixed.curve_measured);
  CHECK(load_resin(curve_profile()).curve_measured);
  mixed.undersides = Undersides::Dose;
  CHECK_THAT(settle_undersides(mixed), Catch::Matchers::Contains("is computed by its ingredients"));
  CHECK(mixed.undersides == Undersides::Plain);
  curve["initiator_mmol_l"] = 0.01;
  CHECK(
      resin_complaints(resin) ==
      Complaints{"/working_curve/initiator_mmol_l: 0.01 mmol/L give a penetration depth of 3.776e+04 um and "
                 "a critical energy of 158.1 mJ/cm²; they must be 1 to 5000 um and 0.01 to 1000 mJ/cm²"});
  curve["initiator_mmol_l"] = 4;
  curve["critical_energy_mj_cm2"] = 5;
  const Complaints both = resin_complaints(resin);
  REQUIRE(both.size() == 1);
  CHECK_THAT(both[0], Catch::Matchers::StartsWith("/working_curve: give either "));
}

TEST_CASE("minimum, default and maximum layer height must be in order") {
  json resin = shipped("resins/standard.json");
  resin["layer_height_um"] = 110;
  CHECK(resin_complaints(resin) == Complaints{"/layer_height_um: 110 is more than layer_height_max_um, 100"});
  resin["layer_height_um"] = 20;
  CHECK(resin_complaints(resin) == Complaints{"/layer_height_min_um: 25 is more than layer_height_um, 20"});
  resin["layer_height_um"] = 50;
  resin["layer_height_min_um"] = 120;
  CHECK(resin_complaints(resin) ==
        Complaints{"/layer_height_min_um: 120 is more than layer_height_max_um, 100"});
  for (const char* key : {"layer_height_um", "layer_height_min_um", "layer_height_max_um"})
    resin[key] = 50;
  CHECK(resin_complaints(resin).empty());
}

TEST_CASE("bottom layers are exposed at least as long as others, and fading requires bottom layers") {
  json resin = shipped("resins/standard.json");
  resin["bottom_exposure_ms"] = 2000;
  CHECK(resin_complaints(resin) == Complaints{"/exposure_ms: 3000 is more than bottom_exposure_ms, 2000"});
  resin = shipped("resins/standard.json");
  resin["bottom_layers"] = 0;
  CHECK(resin_complaints(resin) == Complaints{"/fade_layers: 10 layers to fade, but bottom_layers is 0: "
                                              "there is no bottom exposure to fade from"});
  resin = curve_profile();
  resin["working_curve"]["overcure_um"] = 151;
  CHECK(resin_complaints(resin) ==
        Complaints{"/working_curve/overcure_um: 151 is more than working_curve/bottom_overcure_um, 150"});
}

TEST_CASE("a resin's compensation is read with its units and is zero by default") {
  json resin = shipped("resins/standard.json");
  CHECK(load_resin(resin).compensation == Compensation{});
  resin["growth_um"] = -12.5;
  resin["elephant_foot_um"] = 80;
  resin["elephant_foot_height_um"] = 400;
  CHECK(load_resin(resin).compensation ==
        Compensation{Micrometers{-12.5}, Micrometers{80}, Nanometers{400'000}});
  resin["growth_um"] = -500.5;
  CHECK(resin_complaints(resin) == Complaints{"/growth_um: -500.5 is less than the least allowed, -500 um"});
}

TEST_CASE(
    "the exposure and area that support a part of a layer are a resin's, by default a quarter of the light "
    "on a hundredth of a mm2") {
  json resin = shipped("resins/standard.json");
  CHECK(load_resin(resin).support == CarryingSupport{.least_grey = 64, .contact_area_mm2 = 0.01});
  resin["support_grey"] = 200;
  resin["support_area_mm2"] = 0.25;
  CHECK(load_resin(resin).support == CarryingSupport{.least_grey = 200, .contact_area_mm2 = 0.25});
  resin["support_grey"] = 0;
  CHECK(resin_complaints(resin) == Complaints{"/support_grey: 0 is less than the least allowed, 1"});
}

TEST_CASE("an elephant foot has both a depth and a height, or neither") {
  json resin = shipped("resins/standard.json");
  resin["elephant_foot_um"] = 80;
  CHECK(resin_complaints(resin) ==
        Complaints{"/elephant_foot_um: 80 um, but elephant_foot_height_um is 0: both are 0 or neither is"});
  resin["elephant_foot_um"] = 0;
  resin["elephant_foot_height_um"] = 300;
  CHECK(resin_complaints(resin) ==
        Complaints{"/elephant_foot_um: 0 um, but elephant_foot_height_um is 300: both are 0 or neither is"});
}

TEST_CASE("a lift and the way down may have a second stage each, the latter no longer than the whole lift") {
  json resin = shipped("resins/standard.json");
  for (const char* key :
       {"second_lift_mm", "second_lift_speed_mm_s", "slow_retract_mm", "slow_retract_speed_mm_s"})
    resin.erase(key);
  CHECK(load_resin(resin).motion.whole_lift() == Nanometers{2'000'000});
  CHECK(load_resin(resin).motion.slow_retract == Nanometers{});
  resin["second_lift_mm"] = 3.5;
  resin["second_lift_speed_mm_s"] = 4.5;
  resin["slow_retract_mm"] = 5.5;
  resin["slow_retract_speed_mm_s"] = 0.8;
  const LayerMotion motion = load_resin(resin).motion;
  CHECK(motion.whole_lift() == Nanometers{5'500'000});
  CHECK(motion.second_lift_speed == MillimetersPerSecond{4.5});
  CHECK(motion.slow_retract == Nanometers{5'500'000});
  CHECK(motion.slow_retract_speed == MillimetersPerSecond{0.8});
  resin["slow_retract_mm"] = 5.6;
  CHECK(resin_complaints(resin) == Complaints{"/slow_retract_mm: 5.6 is more than the whole lift, 5.5 mm"});
}

TEST_CASE("violations of rules and schema are reported together") {
  json resin = shipped("resins/standard.json");
  resin["layer_height_um"] = 110;
  resin["lift_mm"] = "high";
  resin["bottom_layers"] = 2.5;
  CHECK(resin_complaints(resin).size() == 3);
}

TEST_CASE("a working curve with an exposure outside 1 ms to 120 s is refused") {
  json resin = curve_profile();
  resin["working_curve"]["bottom_overcure_um"] = 450;  // exp(5) = 148.4 s
  CHECK(resin_complaints(resin) ==
        Complaints{"/working_curve: a bottom layer of 50 um would last 148.4 s; an exposure must last 1 ms "
                   "to 120 s: it follows from penetration_depth_um 100, critical_energy_mj_cm2 5 and "
                   "bottom_overcure_um 450 of the resin, and irradiance_mw_cm2 5 of the projector: correct "
                   "the one that is wrong, or print thinner layers"});
  resin["working_curve"]["bottom_overcure_um"] = 428;  // exp(4.78) = 119.1 s
  CHECK(resin_complaints(resin).empty());
  resin = curve_profile();
  resin["working_curve"] = {{"penetration_depth_um", 5000},
                            {"critical_energy_mj_cm2", 0.01},
                            {"overcure_um", 0},
                            {"bottom_overcure_um", 2000}};  // 2 ms exp(0.01): fine
  CHECK(resin_complaints(resin).empty());
  resin["working_curve"]["penetration_depth_um"] = 1;  // exp(50), exp(2050)
  const Complaints endless = resin_complaints(resin);
  REQUIRE(endless.size() == 1);
  CHECK(
      endless.front().find("a layer of 50 um would last more than a day, a bottom layer more than a day; ") !=
      std::string::npos);
  CHECK(endless.front().find("penetration_depth_um 1,") != std::string::npos);
}

TEST_CASE("a layer height is checked against the profile's range and its exposures") {
  const ResinProfile resin = load_resin(curve_profile());
  CHECK(layer_height_problems(resin, Nanometers{50'000}, 5.0).empty());
  CHECK(layer_height_problems(resin, Nanometers{25'000}, 5.0).empty());
  CHECK(layer_height_problems(resin, Nanometers{100'000}, 5.0).empty());
  CHECK(layer_height_problems(resin, Nanometers{100'500}, 5.0) ==
        Complaints{"the layer height of 100.5 um is outside what resin \"grey\" allows, 25 um to 100 um"});
  CHECK(layer_height_problems(resin, Nanometers{24'999}, 5.0).size() == 1);
  CHECK(layer_height_problems(resin, Nanometers{50'000}, 0.01).size() == 1);      // 1359 s, 3695 s
  CHECK(layer_height_problems(resin, Nanometers{50'000}, 20'000.0).size() == 1);  // 0.68 ms, 1.85 ms

  ResinProfile dead = resin;
  const double cured_um = 50 + std::get<CurveExposure>(resin.exposure).overcure.count();
  dead.cure->dead_zone = Micrometers{cured_um - 1};
  CHECK(layer_height_problems(dead, Nanometers{50'000}, 5.0).empty());
  dead.cure->dead_zone = Micrometers{cured_um};
  const Complaints problems = layer_height_problems(dead, Nanometers{50'000}, 5.0);
  REQUIRE(problems.size() == 1);
  CHECK(problems.front().find("nothing would harden") != std::string::npos);
}

}  // namespace
}  // namespace contourd
