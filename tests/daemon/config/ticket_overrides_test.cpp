#include "daemon/config/ticket_overrides.hpp"

#include <cmath>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using testing::Complaints;
using testing::complaints_of;
using testing::shipped;

constexpr double kIrradianceMwCm2 = 5.0;

json limited_profile() {
  json resin = shipped("resins/standard.json");
  resin["ticket_limits"] = {{"exposure_ms", {2000, 8000}},
                            {"bottom_exposure_ms", {5000, 60000}},
                            {"lift_mm", {4, 9.5}},
                            {"settle_ms", {0, 5000}},
                            {"rest_ms", {500, 500}}};
  return resin;
}

// Its exposures are e and e^2 s at 50 um.
json curve_profile() {
  json resin = limited_profile();
  resin.erase("exposure_ms");
  resin.erase("bottom_exposure_ms");
  resin["working_curve"] = {{"penetration_depth_um", 100},
                            {"critical_energy_mj_cm2", 5},
                            {"overcure_um", 50},
                            {"bottom_overcure_um", 150}};
  return resin;
}

ResinProfile load(const json& resin) {
  const testing::ConfigFolder folder;
  return load_resin_profile(folder.write_json("grey.json", resin),
                            {.travel = Nanometers{160'000'000}, .irradiance_mw_cm2 = kIrradianceMwCm2});
}

Complaints complaints_about(const json& resin) {
  return complaints_of([&] { (void)load(resin); });
}

// A resin as a ticket has it printed.
struct Printed {
  ResinProfile resin;
  OverriddenSettings overridden;
};

Printed printed(const json& profile, const json& ticket) {
  Printed job{load(profile), {}};
  job.overridden = override_settings(job.resin, parse_job_ticket(ticket.dump(), "part.json"),
                                     kIrradianceMwCm2, {"part.json", "/resins/grey.json"});
  return job;
}

Complaints refusals_of(const json& profile, const json& ticket) {
  return complaints_of([&] { (void)printed(profile, ticket); });
}

TEST_CASE("a ticket within the limits sets all five settings, and nothing else of the resin") {
  const ResinProfile before = load(limited_profile());
  const auto [resin, overridden] = printed(limited_profile(), {{"exposure_ms", 4000.5},
                                                               {"bottom_exposure_ms", 20000},
                                                               {"lift_mm", 8},
                                                               {"settle_ms", 0},
                                                               {"rest_ms", 500}});
  CHECK(std::get<FixedExposure>(resin.exposure) ==
        FixedExposure{std::chrono::microseconds{4'000'500}, milliseconds{20000}});
  CHECK(resin.lift == Nanometers{8'000'000});
  CHECK(resin.settle == milliseconds{0});
  CHECK(resin.rest == milliseconds{500});
  CHECK(overridden == OverriddenSettings{{"exposure_ms", 4000.5, 3000},
                                         {"bottom_exposure_ms", 20000, 30000},
                                         {"lift_mm", 8, 6},
                                         {"settle_ms", 0, 1000},
                                         {"rest_ms", 500, 500}});
  ResinProfile back = resin;
  back.exposure = before.exposure;
  back.lift = before.lift;
  back.settle = before.settle;
  back.rest = before.rest;
  CHECK(back == before);
}

TEST_CASE("a ticket that sets none of them leaves the resin as it is") {
  CHECK(printed(limited_profile(), {{"copies", 2}}).resin == load(limited_profile()));
  CHECK(printed(curve_profile(), {{"copies", 2}}).resin == load(curve_profile()));
  CHECK(printed(limited_profile(), json::object()).overridden.empty());
}

TEST_CASE("a ticket's figures of supports need no limits and are told with the resin's own") {
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

TEST_CASE("both ends of the limits belong to them, and a hair beyond is refused, not clamped") {
  for (const double ms : {2000.0, 8000.0})
    CHECK(refusals_of(limited_profile(), {{"exposure_ms", ms}}).empty());
  CHECK(
      refusals_of(limited_profile(), {{"exposure_ms", 8000.001}}) ==
      Complaints{"/exposure_ms: 8000.001 is asked for, but the resin's profile allows tickets 2000 to 8000: "
                 "/resins/grey.json"});
  CHECK(refusals_of(limited_profile(), {{"exposure_ms", 1999.999}}).size() == 1);
  CHECK(refusals_of(limited_profile(), {{"lift_mm", 9.51}}) ==
        Complaints{"/lift_mm: 9.51 is asked for, but the resin's profile allows tickets 4 to 9.5: "
                   "/resins/grey.json"});
}

TEST_CASE("without limits no ticket may set anything, not even to the profile's own value") {
  const json plain_profile = shipped("resins/standard.json");
  CHECK(refusals_of(plain_profile, {{"exposure_ms", 3000}, {"rest_ms", 1}}) ==
        Complaints{"/exposure_ms: 3000 is asked for, but the resin's profile names no ticket_limits for it: "
                   "/resins/grey.json",
                   "/rest_ms: 1 is asked for, but the resin's profile names no ticket_limits for it: "
                   "/resins/grey.json"});
  json only_lift = plain_profile;
  only_lift["ticket_limits"] = {{"lift_mm", {5, 7}}};
  CHECK(refusals_of(only_lift, {{"lift_mm", 7}}).empty());
  CHECK(refusals_of(only_lift, {{"settle_ms", 1000}}).size() == 1);
}

TEST_CASE("a normal layer gets no more light than a bottom layer, whoever says so") {
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

TEST_CASE("a ticket's exposure stands in the place of what a working curve comes to at its layer height") {
  const auto bottom_at = [](double layer_um) {
    return Duration{std::llround(std::exp((layer_um + 150) / 100) * 1e9)};
  };
  const Printed job = printed(curve_profile(), {{"exposure_ms", 4000}});
  CHECK(std::get<FixedExposure>(job.resin.exposure) == FixedExposure{milliseconds{4000}, bottom_at(50)});
  REQUIRE(job.overridden.size() == 1);
  CHECK(std::fabs(job.overridden[0].profile - 2718.281828) < 1e-5);  // nanoseconds
  const Printed thick = printed(curve_profile(), {{"exposure_ms", 4000}, {"layer_height_um", 100}});
  CHECK(std::get<FixedExposure>(thick.resin.exposure) == FixedExposure{milliseconds{4000}, bottom_at(100)});
  // What is not set goes on to follow the curve.
  CHECK(std::holds_alternative<WorkingCurve>(printed(curve_profile(), {{"lift_mm", 8}}).resin.exposure));
}

TEST_CASE("a layer height that the resin does not print is refused before its exposures are worked out") {
  json resin = curve_profile();
  resin["working_curve"]["penetration_depth_um"] = 20;
  resin["working_curve"]["overcure_um"] = 0;
  resin["working_curve"]["bottom_overcure_um"] = 10;
  resin["ticket_limits"]["exposure_ms"] = {2000, 20000};
  const Complaints refusals = refusals_of(resin, {{"exposure_ms", 4000}, {"layer_height_um", 500}});
  REQUIRE_FALSE(refusals.empty());
  CHECK(refusals[0].find("/layer_height_um: ") == 0);
}

TEST_CASE("limits are a least and a most within what the setting itself may be") {
  json resin = limited_profile();
  CHECK(complaints_about(resin).empty());
  resin["ticket_limits"]["exposure_ms"] = {2000, 120001};
  CHECK(complaints_about(resin) ==
        Complaints{"/ticket_limits/exposure_ms/1: 120001 is more than the limit, 120000 ms"});
  resin["ticket_limits"]["exposure_ms"] = {0, 1e308};
  CHECK(complaints_about(resin).size() == 2);
  resin["ticket_limits"]["exposure_ms"] = {8000, 2000};
  CHECK(complaints_about(resin) ==
        Complaints{"/ticket_limits/exposure_ms: the least, 8000, is more than the most, 2000"});
  for (const json& wrong : {json{2000}, json{2000, 3000, 4000}, json::array(), json(3000), json("NaN"),
                            json{"NaN", 4000}, json{nullptr, 4000}}) {
    resin["ticket_limits"]["exposure_ms"] = wrong;
    CHECK_FALSE(complaints_about(resin).empty());
  }
  resin = limited_profile();
  resin["ticket_limits"]["exposure_s"] = {2000, 8000};
  CHECK(complaints_about(resin) ==
        Complaints{
            "/ticket_limits/exposure_s: there is no key \"exposure_s\" here; did you mean \"exposure_ms\"?"});
}

TEST_CASE("limits hold what the profile itself says, also by a working curve") {
  json resin = limited_profile();
  resin["ticket_limits"]["settle_ms"] = {1500, 5000};
  CHECK(complaints_about(resin) ==
        Complaints{"/ticket_limits/settle_ms: 1500 to 5000 leave out the profile's own settle_ms, 1000"});
  resin = curve_profile();
  CHECK(complaints_about(resin).empty());
  resin["ticket_limits"]["exposure_ms"] = {3000, 8000};
  CHECK(complaints_about(resin) ==
        Complaints{
            "/ticket_limits/exposure_ms: 3000 to 8000 leave out what the working curve comes to, 2718.282"});
}

TEST_CASE("no lift is allowed that the printer's travel has no room for") {
  json resin = limited_profile();
  resin["ticket_limits"]["lift_mm"] = {4, 100};
  CHECK(complaints_about(resin).empty());
  const testing::ConfigFolder folder;
  const auto path = folder.write_json("grey.json", resin);
  CHECK(complaints_of([&] {
          (void)load_resin_profile(path, {.travel = Nanometers{100'000'000}, .irradiance_mw_cm2 = {}});
        }) == Complaints{"/ticket_limits/lift_mm: 100 is not less than the printer's travel, 100 mm"});
}

TEST_CASE("what a ticket may set has the bounds that it has in a profile") {
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
