#include "daemon/config/continuous_resin.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/resin_fixture.hpp"

namespace contourd {
namespace {

using contourd::testing::Approx;
using nlohmann::json;

json continuous_profile(const json& section = {{"window_s", 900}, {"recovery_s", 60.5}}) {
  json resin = testing::with_working_curve(shipped("resins/standard.json"));
  resin["working_curve"]["dead_zone_um"] = 30;
  resin["continuous"] = section;
  return resin;
}

TEST_CASE("The settings for continuous printing are read with their units, or have their defaults") {
  const ResinProfile defaults = load_resin(continuous_profile());
  REQUIRE(defaults.continuous);
  CHECK(defaults.continuous->window == 900s);
  CHECK(defaults.continuous->recovery == 60'500ms);
  CHECK(defaults.continuous->margin == 4);
  CHECK(defaults.continuous->refill_pressure_kpa == 50);
  CHECK(defaults.continuous->layered == Nanometers{1'000'000});
  CHECK(defaults.continuous->mask_step == Micrometers{2});
  CHECK(defaults.continuous->slowest.count() == Approx(5.0 / 3600));
  CHECK(defaults.continuous->fastest.count() == Approx(1000.0 / 3600));
  CHECK(defaults.continuous->missed == MissedMasks::Keep);
  CHECK(missing_for_continuous(defaults).empty());

  const ResinProfile given = load_resin(continuous_profile({{"window_s", 900},
                                                            {"recovery_s", 0},
                                                            {"margin", 2.5},
                                                            {"refill_pressure_kpa", 80},
                                                            {"layered_mm", 0.4},
                                                            {"mask_step_um", 5},
                                                            {"missed_masks", "slow"},
                                                            {"least_speed_mm_h", 36},
                                                            {"most_speed_mm_h", 72}}));
  CHECK(given.continuous->margin == 2.5);
  CHECK(given.continuous->refill_pressure_kpa == 80);
  CHECK(given.continuous->layered == Nanometers{400'000});
  CHECK(given.continuous->mask_step == Micrometers{5});
  CHECK(given.continuous->missed == MissedMasks::Slow);
  CHECK(given.continuous->slowest.count() == Approx(0.01));
  CHECK(given.continuous->fastest.count() == Approx(0.02));
}

TEST_CASE("What a rise does about a missed mask is one of three words") {
  const auto with = [](const char* what) {
    return continuous_profile({{"window_s", 900}, {"recovery_s", 1}, {"missed_masks", what}});
  };
  CHECK(load_resin(with("keep")).continuous->missed == MissedMasks::Keep);
  CHECK(load_resin(with("pause")).continuous->missed == MissedMasks::Pause);
  CHECK(resin_complaints(with("ignore")).size() == 1);
}

TEST_CASE("A profile that cannot be printed continuously is refused with its places") {
  CHECK(resin_complaints(continuous_profile({{"window_s", 900}})).size() == 1);
  CHECK(resin_complaints(continuous_profile({{"window_s", 900}, {"recovery_s", 1}, {"margin", 1}})).size() ==
        1);
  const Complaints swapped = resin_complaints(continuous_profile(
      {{"window_s", 900}, {"recovery_s", 1}, {"least_speed_mm_h", 80}, {"most_speed_mm_h", 40}}));
  REQUIRE(swapped.size() == 1);
  CHECK(lacking(swapped.front(), {"/continuous/least_speed_mm_h", "80 is more than most_speed_mm_h, 40"}) ==
        "");
}

TEST_CASE("What a profile lacks for continuous printing is one sentence") {
  CHECK(missing_for_continuous(load_resin(shipped("resins/standard.json"))) ==
        "the profile of the resin grey lacks what continuous printing needs: working_curve, "
        "working_curve/dead_zone_um above 0, continuous; add it to the profile, or print in layers");
  json resin = continuous_profile();
  resin["working_curve"]["dead_zone_um"] = 0;
  resin.erase("viscosity_mpa_s");
  CHECK(
      missing_for_continuous(load_resin(resin)) ==
      "the profile of the resin grey lacks what continuous printing needs: working_curve/dead_zone_um above "
      "0, viscosity_mpa_s; add it to the profile, or print in layers");
}

}  // namespace
}  // namespace contourd
