#include "daemon/config/resin_plausibility.hpp"

#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

using namespace contourd;

namespace {

// The shipped resin with these changes, at 5 mW/cm2: the places that are implausible.
std::vector<std::string> implausible(const nlohmann::json& changes = nlohmann::json::object()) {
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

using Places = std::vector<std::string>;

}  // namespace

TEST_CASE("the shipped resin and figures that printers have are not implausible") {
  CHECK(implausible().empty());
  // As hosts give them for 25 and 100 um, and a strong lamp's.
  CHECK(implausible({{"layer_height_um", 25}, {"exposure_ms", 2500}, {"bottom_exposure_ms", 5000}}).empty());
  CHECK(
      implausible({{"layer_height_um", 100}, {"exposure_ms", 14000}, {"bottom_exposure_ms", 35000}}).empty());
  CHECK(implausible({{"exposure_ms", 500}, {"bottom_exposure_ms", 1000}}).empty());
  CHECK(implausible(
            {{"bottom_layers", 0}, {"fade_layers", 0}, {"exposure_ms", 800}, {"bottom_exposure_ms", 900}})
            .empty());
}

TEST_CASE("seconds that were taken for milliseconds are implausible, whichever figure they are in") {
  CHECK(implausible({{"exposure_ms", 3}}) == Places{"/exposure_ms"});
  CHECK(implausible({{"exposure_ms", 3}, {"bottom_exposure_ms", 30}}) ==
        Places{"/exposure_ms", "/bottom_exposure_ms"});
  CHECK(implausible({{"exposure_ms", 120}}) == Places{"/exposure_ms"});
  CHECK(implausible({{"exposure_ms", 90000}, {"bottom_exposure_ms", 90000}}) == Places{"/exposure_ms"});
}

TEST_CASE("an exposure that is right for another thickness is implausible") {
  const nlohmann::json thick{{"layer_height_um", 200}, {"layer_height_max_um", 200}, {"exposure_ms", 1000}};
  CHECK(implausible(thick) == Places{"/exposure_ms"});
  const nlohmann::json thin{{"layer_height_um", 12}, {"layer_height_min_um", 10}, {"exposure_ms", 15000}};
  CHECK(implausible(thin) == Places{"/exposure_ms"});
}

TEST_CASE("exposures that a working curve comes to are implausible as those that are given") {
  const auto curve = [](double ec, double overcure) {
    return nlohmann::json{{"exposure_ms", nullptr},
                          {"bottom_exposure_ms", nullptr},
                          {"working_curve",
                           {{"penetration_depth_um", 150},
                            {"critical_energy_mj_cm2", ec},
                            {"overcure_um", overcure},
                            {"bottom_overcure_um", 300}}}};
  };
  CHECK(implausible(curve(9, 60)).empty());
  CHECK(implausible(curve(0.09, 60)) == Places{"/working_curve", "/working_curve"});
  CHECK(implausible(curve(9, 0)) == Places{"/working_curve/overcure_um"});
}

TEST_CASE("layers and moves that no printer makes are implausible") {
  CHECK(implausible({{"layer_height_um", 5}, {"layer_height_min_um", 5}, {"exposure_ms", 1000}}) ==
        Places{"/layer_height_um"});
  CHECK(implausible({{"lift_mm", 0.5}}) == Places{"/lift_mm"});
  CHECK(implausible({{"lift_mm", 60}}) == Places{"/lift_mm"});
  CHECK(implausible({{"lift_speed_mm_s", 40}, {"retract_speed_mm_s", 45}}) ==
        Places{"/lift_speed_mm_s", "/retract_speed_mm_s"});
}
