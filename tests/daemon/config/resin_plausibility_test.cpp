#include "daemon/config/resin_plausibility.hpp"

#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

using namespace contourd;

namespace {

// The shipped resin with these changes, at 5 mW/cm2: the places that are doubted.
std::vector<std::string> doubted(const nlohmann::json& changes = nlohmann::json::object()) {
  nlohmann::json profile = testing::shipped("resins/standard.json");
  profile.merge_patch(changes);
  const testing::ConfigFolder folder;
  const auto file = folder.write_json("resin.json", profile);
  std::vector<std::string> places;
  for (const Violation& doubt : doubts_about(load_resin_profile(file, {}), file, 5)) {
    CHECK(doubt.file == file.string());
    places.push_back(doubt.pointer);
  }
  return places;
}

using Places = std::vector<std::string>;

}  // namespace

TEST_CASE("the shipped resin and figures that printers have are not doubted") {
  CHECK(doubted().empty());
  // As hosts give them for 25 and 100 um, and a strong lamp's.
  CHECK(doubted({{"layer_height_um", 25}, {"exposure_ms", 2500}, {"bottom_exposure_ms", 5000}}).empty());
  CHECK(doubted({{"layer_height_um", 100}, {"exposure_ms", 14000}, {"bottom_exposure_ms", 35000}}).empty());
  CHECK(doubted({{"exposure_ms", 500}, {"bottom_exposure_ms", 1000}}).empty());
  CHECK(doubted({{"bottom_layers", 0}, {"fade_layers", 0}, {"exposure_ms", 800}, {"bottom_exposure_ms", 900}})
            .empty());
}

TEST_CASE("seconds that were taken for milliseconds are doubted, whichever figure they are in") {
  CHECK(doubted({{"exposure_ms", 3}}) == Places{"/exposure_ms"});
  CHECK(doubted({{"exposure_ms", 3}, {"bottom_exposure_ms", 30}}) ==
        Places{"/exposure_ms", "/bottom_exposure_ms"});
  CHECK(doubted({{"exposure_ms", 120}}) == Places{"/exposure_ms"});
  CHECK(doubted({{"exposure_ms", 90000}, {"bottom_exposure_ms", 90000}}) == Places{"/exposure_ms"});
}

TEST_CASE("an exposure that is right for another thickness is doubted") {
  const nlohmann::json thick{{"layer_height_um", 200}, {"layer_height_max_um", 200}, {"exposure_ms", 1000}};
  CHECK(doubted(thick) == Places{"/exposure_ms"});
  const nlohmann::json thin{{"layer_height_um", 12}, {"layer_height_min_um", 10}, {"exposure_ms", 15000}};
  CHECK(doubted(thin) == Places{"/exposure_ms"});
}

TEST_CASE("exposures that a working curve comes to are doubted as those that are given") {
  const auto curve = [](double ec, double overcure) {
    return nlohmann::json{{"exposure_ms", nullptr},
                          {"bottom_exposure_ms", nullptr},
                          {"working_curve",
                           {{"penetration_depth_um", 150},
                            {"critical_energy_mj_cm2", ec},
                            {"overcure_um", overcure},
                            {"bottom_overcure_um", 300}}}};
  };
  CHECK(doubted(curve(9, 60)).empty());
  CHECK(doubted(curve(0.09, 60)) == Places{"/working_curve", "/working_curve"});
  CHECK(doubted(curve(9, 0)) == Places{"/working_curve/overcure_um"});
}

TEST_CASE("layers and moves that no printer makes are doubted") {
  CHECK(doubted({{"layer_height_um", 5}, {"layer_height_min_um", 5}, {"exposure_ms", 1000}}) ==
        Places{"/layer_height_um"});
  CHECK(doubted({{"lift_mm", 0.5}}) == Places{"/lift_mm"});
  CHECK(doubted({{"lift_mm", 60}}) == Places{"/lift_mm"});
  CHECK(doubted({{"lift_speed_mm_s", 40}, {"retract_speed_mm_s", 45}}) ==
        Places{"/lift_speed_mm_s", "/retract_speed_mm_s"});
}
