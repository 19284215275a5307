#include "daemon/config/resin_plausibility.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace {

// Returns the pointers of the warnings about the shipped resin with these changes, at 5 mW/cm2.
std::vector<std::string> implausible_in_resin(const nlohmann::json& changes = nlohmann::json::object()) {
  nlohmann::json profile = testing::shipped("resins/standard.json");
  profile.merge_patch(changes);
  const testing::ConfigFolder folder;
  const auto file = folder.write_json("resin.json", profile);
  std::vector<std::string> places;
  for (const Violation& warning : implausible_values(load_resin_profile(file, {}), file, 5)) {
    CHECK(warning.file == file.string());
    places.push_back(warning.pointer);
  }
  return places;
}

using Pointers = std::vector<std::string>;

}  // namespace

TEST_CASE("the shipped resin and the values of existing printers are plausible") {
  CHECK(implausible_in_resin().empty());
  // Other hosts' values for 25 and 100 um, and those of a strong lamp.
  CHECK(implausible_in_resin({{"layer_height_um", 25}, {"exposure_ms", 2500}, {"bottom_exposure_ms", 5000}})
            .empty());
  CHECK(
      implausible_in_resin({{"layer_height_um", 100}, {"exposure_ms", 14000}, {"bottom_exposure_ms", 35000}})
          .empty());
  CHECK(implausible_in_resin({{"exposure_ms", 500}, {"bottom_exposure_ms", 1000}}).empty());
  CHECK(implausible_in_resin(
            {{"bottom_layers", 0}, {"fade_layers", 0}, {"exposure_ms", 800}, {"bottom_exposure_ms", 900}})
            .empty());
}

TEST_CASE("seconds entered as milliseconds are implausible in every exposure") {
  CHECK(implausible_in_resin({{"exposure_ms", 3}}) == Pointers{"/exposure_ms"});
  CHECK(implausible_in_resin({{"exposure_ms", 3}, {"bottom_exposure_ms", 30}}) ==
        Pointers{"/exposure_ms", "/bottom_exposure_ms"});
  CHECK(implausible_in_resin({{"exposure_ms", 120}}) == Pointers{"/exposure_ms"});
  CHECK(implausible_in_resin({{"exposure_ms", 90000}, {"bottom_exposure_ms", 90000}}) ==
        Pointers{"/exposure_ms"});
}

TEST_CASE("an exposure for a different thickness is implausible") {
  const nlohmann::json thick{{"layer_height_um", 200}, {"layer_height_max_um", 200}, {"exposure_ms", 1000}};
  CHECK(implausible_in_resin(thick) == Pointers{"/exposure_ms"});
  const nlohmann::json thin{{"layer_height_um", 12}, {"layer_height_min_um", 10}, {"exposure_ms", 15000}};
  CHECK(implausible_in_resin(thin) == Pointers{"/exposure_ms"});
}

TEST_CASE("exposures from a working curve are checked like given ones") {
  const auto curve = [](double ec, double overcure) {
    return nlohmann::json{{"exposure_ms", nullptr},
                          {"bottom_exposure_ms", nullptr},
                          {"working_curve",
                           {{"penetration_depth_um", 150},
                            {"critical_energy_mj_cm2", ec},
                            {"overcure_um", overcure},
                            {"bottom_overcure_um", 300}}}};
  };
  CHECK(implausible_in_resin(curve(9, 60)).empty());
  CHECK(implausible_in_resin(curve(0.09, 60)) == Pointers{"/working_curve", "/working_curve"});
  CHECK(implausible_in_resin(curve(9, 0)) == Pointers{"/working_curve/overcure_um"});
}

TEST_CASE("layer heights and moves outside those of existing printers are implausible") {
  CHECK(implausible_in_resin({{"layer_height_um", 5}, {"layer_height_min_um", 5}, {"exposure_ms", 1000}}) ==
        Pointers{"/layer_height_um"});
  CHECK(implausible_in_resin({{"lift_mm", 0.5}}) == Pointers{"/lift_mm"});
  CHECK(implausible_in_resin({{"lift_mm", 60}}) == Pointers{"/lift_mm"});
  CHECK(implausible_in_resin({{"lift_speed_mm_s", 40}, {"retract_speed_mm_s", 45}}) ==
        Pointers{"/lift_speed_mm_s", "/retract_speed_mm_s"});
}
