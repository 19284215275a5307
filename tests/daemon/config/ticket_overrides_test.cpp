#include "daemon/config/ticket_overrides.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/resin_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

json limited_profile() {
  json resin = shipped("resins/standard.json");
  resin["ticket_limits"] = {{"exposure_ms", {2000, 8000}},
                            {"bottom_exposure_ms", {5000, 60000}},
                            {"lift_mm", {1, 9.5}},
                            {"settle_ms", {0, 5000}},
                            {"rest_ms", {500, 500}}};
  return resin;
}

json limited_curve_profile() {
  return testing::with_working_curve(limited_profile());
}

// A resin with a ticket's overrides applied.
struct Printed {
  ResinProfile resin;
  OverriddenSettings overridden;
};

Printed printed(const json& profile, const json& ticket) {
  Printed job{load_resin(profile), {}};
  job.overridden = override_settings(job.resin, parse_job_ticket(ticket.dump(), "part.json"),
                                     kIrradianceMwCm2, {"part.json", "/resins/grey.json"});
  return job;
}

Complaints refusals_of(const json& profile, const json& ticket) {
  return complaints_of([&] { (void)printed(profile, ticket); });
}

TEST_CASE("a ticket within the limits sets all five settings and no other setting of the resin") {
  const ResinProfile before = load_resin(limited_profile());
  const auto [resin, overridden] = printed(limited_profile(), {{"exposure_ms", 4000.5},
                                                               {"bottom_exposure_ms", 20000},
                                                               {"lift_mm", 8},
                                                               {"settle_ms", 0},
                                                               {"rest_ms", 500}});
  CHECK(std::get<FixedExposure>(resin.exposure) ==
        FixedExposure{std::chrono::microseconds{4'000'500}, milliseconds{20000}});
  CHECK(resin.motion.lift == Nanometers{8'000'000});
  CHECK(resin.motion.settle == milliseconds{0});
  CHECK(resin.motion.rest == milliseconds{500});
  CHECK(overridden == OverriddenSettings{{"exposure_ms", 4000.5, 3000},
                                         {"bottom_exposure_ms", 20000, 30000},
                                         {"lift_mm", 8, 2},
                                         {"settle_ms", 0, 200},
                                         {"rest_ms", 500, 500}});
  ResinProfile back = resin;
  back.exposure = before.exposure;
  back.motion.lift = before.motion.lift;
  back.motion.settle = before.motion.settle;
  back.motion.rest = before.motion.rest;
  CHECK(back == before);
}

TEST_CASE("a ticket without overrides leaves the resin unchanged") {
  CHECK(printed(limited_profile(), {{"copies", 2}}).resin == load_resin(limited_profile()));
  CHECK(printed(limited_curve_profile(), {{"copies", 2}}).resin == load_resin(limited_curve_profile()));
  CHECK(printed(limited_profile(), json::object()).overridden.empty());
}

TEST_CASE("a ticket's values for supports need no limits and are reported with the resin's own") {
  const Printed job =
      printed(shipped("resins/standard.json"), {{"supports", {{"lift_mm", 8}, {"spacing_mm", 2}}}});
  CHECK(job.resin.supports.lift == Millimeters{8});
  CHECK(job.resin.supports.spacing == Millimeters{2});
  CHECK(job.overridden == OverriddenSettings{{"supports.lift_mm", 8, 5}, {"supports.spacing_mm", 2, 3.2}});
  CHECK(printed(shipped("resins/standard.json"), {{"supports", "auto"}}).overridden.empty());
  CHECK(refusals_of(shipped("resins/standard.json"), {{"supports", {{"tip_diameter_mm", 2}}}}) ==
        Complaints{"/supports/tip_diameter_mm: 2 mm is more than pillar_diameter_mm, 1 mm: a tip is no "
                   "thicker than its pillar"});
}

TEST_CASE("a ticket's undersides replace the resin's, which need no limits") {
  json dosed = limited_curve_profile();
  dosed["undersides"] = "dose";
  CHECK(printed(dosed, json::object()).resin.undersides == Undersides::Dose);
  CHECK(printed(dosed, {{"undersides", "plain"}}).resin.undersides == Undersides::Plain);
  const json plain = shipped("resins/standard.json");
  CHECK(printed(plain, json::object()).resin.undersides == Undersides::Plain);
  CHECK(printed(plain, {{"undersides", "dose"}}).resin.undersides == Undersides::Dose);
}

TEST_CASE("a ticket's mode replaces the resin's, which needs no limits") {
  json resin = shipped("resins/standard.json");
  CHECK(printed(resin, json::object()).resin.mode == PrintWay::Layered);
  CHECK(printed(resin, {{"mode", "continuous"}}).resin.mode == PrintWay::Continuous);
  resin["mode"] = "continuous";
  CHECK(printed(resin, json::object()).resin.mode == PrintWay::Continuous);
  CHECK(printed(resin, {{"mode", "layered"}}).resin.mode == PrintWay::Layered);
}

TEST_CASE("limits are inclusive, and a value just outside is refused, not clamped") {
  for (const double ms : {2000.0, 8000.0})
    CHECK(refusals_of(limited_profile(), {{"exposure_ms", ms}}).empty());
  CHECK(
      refusals_of(limited_profile(), {{"exposure_ms", 8000.001}}) ==
      Complaints{"/exposure_ms: 8000.001 is asked for, but the resin's profile allows tickets 2000 to 8000: "
                 "/resins/grey.json"});
  CHECK(refusals_of(limited_profile(), {{"exposure_ms", 1999.999}}).size() == 1);
  CHECK(refusals_of(limited_profile(), {{"lift_mm", 9.51}}) ==
        Complaints{"/lift_mm: 9.51 is asked for, but the resin's profile allows tickets 1 to 9.5: "
                   "/resins/grey.json"});
}

TEST_CASE("without limits a ticket cannot set a value, not even the profile's own") {
  const json plain_profile = shipped("resins/standard.json");
  CHECK(refusals_of(plain_profile, {{"exposure_ms", 3000}, {"rest_ms", 1}}) ==
        Complaints{"/exposure_ms: 3000 is asked for, but the resin's profile names no ticket_limits for it: "
                   "/resins/grey.json",
                   "/rest_ms: 1 is asked for, but the resin's profile names no ticket_limits for it: "
                   "/resins/grey.json"});
  json only_lift = plain_profile;
  only_lift["ticket_limits"] = {{"lift_mm", {2, 7}}};
  CHECK(refusals_of(only_lift, {{"lift_mm", 7}}).empty());
  CHECK(refusals_of(only_lift, {{"settle_ms", 1000}}).size() == 1);
}

TEST_CASE("a normal layer never gets more light than a bottom layer, also with overrides") {
  CHECK(refusals_of(limited_profile(), {{"exposure_ms", 6000}, {"bottom_exposure_ms", 5000}}) ==
        Complaints{"/exposure_ms: an exposure of 6000 ms would be more than the bottom exposure, 5000 ms"});
  json resin = limited_profile();
  resin["bottom_exposure_ms"] = 7000;
  CHECK(refusals_of(resin, {{"exposure_ms", 7500}}).size() == 1);
  resin["ticket_limits"]["bottom_exposure_ms"] = {2000, 7000};
  CHECK(refusals_of(resin, {{"bottom_exposure_ms", 2500}}) ==
        Complaints{"/bottom_exposure_ms: an exposure of 3000 ms would be more than the bottom exposure, 2500 "
                   "ms"});
}

TEST_CASE("a ticket's steps set the exposure of normal layers by the height of their middles") {
  const auto steps =
      json::array({{{"from_mm", 0.8}, {"exposure_ms", 4000}}, {{"from_mm", 1.025}, {"exposure_ms", 2000}}});
  json profile = limited_profile();
  profile["bottom_layers"] = profile["fade_layers"] = 1;
  const auto [resin, overridden] = printed(profile, {{"exposure_steps", steps}});
  CHECK(overridden == OverriddenSettings{{kExposureSteps, 4000, 3000}, {kExposureSteps, 2000, 3000}});
  const auto exposure_ms = [&resin = resin](int layer) {
    return figure_of(exposure_time(resin, Nanometers{50'000}, layer, kIrradianceMwCm2));
  };
  CHECK(exposure_ms(0) == 30000);
  CHECK(exposure_ms(2) == 3000);
  CHECK(exposure_ms(15) == 3000);  // from 0.75 to 0.8 mm
  CHECK(exposure_ms(16) == 4000);
  CHECK(exposure_ms(19) == 4000);
  CHECK(exposure_ms(20) == 2000);  // its middle is at 1.025 mm
  CHECK(exposure_ms(400) == 2000);
  // In a bottom layer, and in the fade, which leads to the step's exposure.
  const ResinProfile low =
      printed(profile, {{"exposure_steps", {{{"from_mm", 0}, {"exposure_ms", 4000}}}}}).resin;
  CHECK(exposure_time(low, Nanometers{50'000}, 0, kIrradianceMwCm2) == milliseconds{30'000});
  CHECK(exposure_time(low, Nanometers{50'000}, 1, kIrradianceMwCm2) == milliseconds{17'000});
}

TEST_CASE("a ticket's steps replace the working curve, beside an exposure of its own") {
  const json steps{{{"from_mm", 1}, {"exposure_ms", 2500}}};
  const ResinProfile resin =
      printed(limited_curve_profile(), {{"exposure_ms", 4000}, {"exposure_steps", steps}}).resin;
  CHECK(exposure_time(resin, Nanometers{50'000}, 19, kIrradianceMwCm2) == milliseconds{4000});
  CHECK(exposure_time(resin, Nanometers{50'000}, 20, kIrradianceMwCm2) == milliseconds{2500});
  CHECK(printed(limited_curve_profile(), {{"exposure_steps", steps}}).overridden.size() == 1);
}

TEST_CASE("every step is within the profile's limits for the exposure") {
  const auto steps = json::array({{{"from_mm", 1}, {"exposure_ms", 8001}},
                                  {{"from_mm", 2}, {"exposure_ms", 3000}},
                                  {{"from_mm", 3}, {"exposure_ms", 1}}});
  CHECK(refusals_of(limited_profile(), {{"exposure_steps", steps}}) ==
        Complaints{
            "/exposure_steps/0/exposure_ms: 8001 is asked for, but the resin's profile allows tickets 2000 "
            "to 8000: /resins/grey.json",
            "/exposure_steps/2/exposure_ms: 1 is asked for, but the resin's profile allows tickets 2000 to "
            "8000: /resins/grey.json"});
  CHECK(refusals_of(shipped("resins/standard.json"),
                    {{"exposure_steps", {{{"from_mm", 1}, {"exposure_ms", 3000}}}}})
            .size() == 1);
}

TEST_CASE("a ticket's exposure replaces the working curve's exposure at its layer height") {
  const auto bottom_at = [](double layer_um) {
    return Duration{std::llround(std::exp((layer_um + 150) / 100) * 1e9)};
  };
  const Printed job = printed(limited_curve_profile(), {{"exposure_ms", 4000}});
  CHECK(std::get<FixedExposure>(job.resin.exposure) == FixedExposure{milliseconds{4000}, bottom_at(50)});
  REQUIRE(job.overridden.size() == 1);
  CHECK(std::fabs(job.overridden[0].profile - 2718.281828) < 1e-5);  // nanoseconds
  const Printed thick = printed(limited_curve_profile(), {{"exposure_ms", 4000}, {"layer_height_um", 100}});
  CHECK(std::get<FixedExposure>(thick.resin.exposure) == FixedExposure{milliseconds{4000}, bottom_at(100)});
  // Without an exposure in the ticket, the curve still applies.
  CHECK(std::holds_alternative<CurveExposure>(
      printed(limited_curve_profile(), {{"lift_mm", 8}}).resin.exposure));
}

TEST_CASE("a layer height that the resin does not allow is refused before its exposures are computed") {
  json resin = limited_curve_profile();
  resin["working_curve"]["penetration_depth_um"] = 20;
  resin["working_curve"]["overcure_um"] = 0;
  resin["working_curve"]["bottom_overcure_um"] = 10;
  resin["ticket_limits"]["exposure_ms"] = {2000, 20000};
  const Complaints refusals = refusals_of(resin, {{"exposure_ms", 4000}, {"layer_height_um", 500}});
  REQUIRE_FALSE(refusals.empty());
  CHECK(refusals[0].find("/layer_height_um: ") == 0);
}

TEST_CASE("limits are a minimum and a maximum within the bounds of the setting itself") {
  json resin = limited_profile();
  CHECK(resin_complaints(resin).empty());
  resin["ticket_limits"]["exposure_ms"] = {2000, 120001};
  CHECK(resin_complaints(resin) ==
        Complaints{"/ticket_limits/exposure_ms/1: 120001 is more than the limit, 120000 ms"});
  resin["ticket_limits"]["exposure_ms"] = {0, 1e308};
  CHECK(resin_complaints(resin).size() == 2);
  resin["ticket_limits"]["exposure_ms"] = {8000, 2000};
  CHECK(resin_complaints(resin) ==
        Complaints{"/ticket_limits/exposure_ms: the least, 8000, is more than the most, 2000"});
  for (const json& wrong : {json{2000}, json{2000, 3000, 4000}, json::array(), json(3000), json("NaN"),
                            json{"NaN", 4000}, json{nullptr, 4000}}) {
    resin["ticket_limits"]["exposure_ms"] = wrong;
    CHECK_FALSE(resin_complaints(resin).empty());
  }
  resin = limited_profile();
  resin["ticket_limits"]["exposure_s"] = {2000, 8000};
  CHECK(resin_complaints(resin) ==
        Complaints{
            "/ticket_limits/exposure_s: there is no key \"exposure_s\" here; did you mean \"exposure_ms\"?"});
}

TEST_CASE("limits must include the profile's own value, also that of a working curve") {
  json resin = limited_profile();
  resin["ticket_limits"]["settle_ms"] = {1500, 5000};
  CHECK(resin_complaints(resin) ==
        Complaints{"/ticket_limits/settle_ms: 1500 to 5000 exclude the profile's own settle_ms, 200"});
  resin = limited_curve_profile();
  CHECK(resin_complaints(resin).empty());
  resin["ticket_limits"]["exposure_ms"] = {3000, 8000};
  CHECK(resin_complaints(resin) ==
        Complaints{
            "/ticket_limits/exposure_ms: 3000 to 8000 exclude the exposure by the working curve, 2718.282"});
}

TEST_CASE("limits allow no lift beyond the printer's travel") {
  json resin = limited_profile();
  resin["ticket_limits"]["lift_mm"] = {1, 100};
  CHECK(resin_complaints(resin).empty());
  const testing::ConfigFolder folder;
  const auto path = folder.write_json("grey.json", resin);
  CHECK(complaints_of([&] {
          (void)load_resin_profile(path, {.travel = Nanometers{100'000'000}, .irradiance_mw_cm2 = {}});
        }) == Complaints{"/ticket_limits/lift_mm: 100 and second_lift_mm, 1.5, are not less than the "
                         "printer's travel, 100 mm"});
}

TEST_CASE("a ticket's settings have the same bounds as in a profile") {
  const json resin = shipped("resin.schema.json")["properties"],
             ticket = shipped("ticket.schema.json")["properties"];
  const json& limits = resin["ticket_limits"]["properties"];
  CHECK(limits.size() == kTicketSettings.size());
  for (const std::string_view key : kTicketSettings) {
    const std::string name(key);
    INFO(name);
    for (const char* bound : {"minimum", "maximum"})
      CHECK(ticket[name][bound] == resin[name][bound]);
    CHECK(limits[name]["items"]["$ref"] == "#/properties/" + name);
  }
}

}  // namespace
}  // namespace contourd
