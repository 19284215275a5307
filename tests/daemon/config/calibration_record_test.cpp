#include "daemon/config/calibration_record.hpp"

#include <optional>
#include <string>

#include "tests/catch.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

// A profile with fixed exposures, and a calibration that replaces them by a curve.
const std::string kFixed = R"({"layer_height_um": 50, "exposure_ms": 3000, "lift_mm": 6})";

Calibration curve_calibration(double depth_um) {
  return {.kind = "curve",
          .date = "2026-11-27",
          .lamp_hours = 120,
          .values = {{"/exposure_ms", nullptr},
                     {"/working_curve/penetration_depth_um", depth_um, 3.9},
                     {"/working_curve/overcure_um", 50.0}}};
}

TEST_CASE("A calibration's values are set, and kept with what was there before") {
  CHECK(Json::parse(with_calibration(kFixed, curve_calibration(148.2))) == Json::parse(R"({
    "layer_height_um": 50, "lift_mm": 6,
    "working_curve": {"penetration_depth_um": 148.2, "overcure_um": 50.0},
    "calibrations": [{"kind": "curve", "date": "2026-11-27", "lamp_hours": 120.0, "values": [
      {"key": "/exposure_ms", "before": 3000},
      {"key": "/working_curve/penetration_depth_um", "after": 148.2, "uncertainty": 3.9},
      {"key": "/working_curve/overcure_um", "after": 50.0}]}]})"));
}

TEST_CASE("Calibrations are undone one by one, from the last, back to the first text") {
  const std::string once = with_calibration(kFixed, curve_calibration(148.2));
  const Calibration second{
      .kind = "curve", .date = "2026-11-28", .values = {{"/working_curve/penetration_depth_um", 151.0, 2.0}}};
  const UndoneCalibration undone = without_last_calibration(with_calibration(once, second));
  CHECK(undone.text == once);
  CHECK(undone.kind == "curve");
  CHECK(undone.date == "2026-11-28");
  CHECK(nlohmann::json::parse(without_last_calibration(once).text) == nlohmann::json::parse(kFixed));
}

TEST_CASE("A calibration may set the name of a file, and its undoing brings the previous name back") {
  const std::string printer = R"({"display": {"uniformity_mask": "old.png", "width_px": 9}})";
  const auto lamp = [](const char* file) {
    return Calibration{.kind = "lamp", .date = "2026-11-28", .values = {{"/display/uniformity_mask", file}}};
  };
  const std::string once = with_calibration(printer, lamp("new.png"));
  CHECK(Json::parse(once)["calibrations"][0]["values"][0] ==
        Json::parse(R"({"key": "/display/uniformity_mask", "before": "old.png", "after": "new.png"})"));
  CHECK(Json::parse(without_last_calibration(once).text) == Json::parse(printer));
  const std::string first = with_calibration(R"({"display": {"width_px": 9}})", lamp("new.png"));
  CHECK_FALSE(Json::parse(without_last_calibration(first).text)["display"].contains("uniformity_mask"));
}

TEST_CASE("Other values may change between a calibration and its undoing") {
  Json changed = Json::parse(with_calibration(kFixed, curve_calibration(148.2)));
  changed["lift_mm"] = 8;
  CHECK(Json::parse(without_last_calibration(changed.dump()).text)["lift_mm"] == 8);
}

TEST_CASE("A calibration that cannot be undone is refused, with the reason") {
  CHECK_THROWS_WITH(without_last_calibration(kFixed),
                    "there is no calibration to undo: contourctl fit --accept has written none");
  Json changed = Json::parse(with_calibration(kFixed, curve_calibration(148.2)));
  changed["working_curve"]["penetration_depth_um"] = 160;
  CHECK_THROWS_WITH(without_last_calibration(changed.dump()),
                    "/working_curve/penetration_depth_um is 160, not 148.2 as the last calibration set it: "
                    "undo it by hand");
  changed["working_curve"].erase("penetration_depth_um");
  CHECK_THROWS_WITH(without_last_calibration(changed.dump()),
                    "/working_curve/penetration_depth_um is absent, not 148.2 as the last calibration set "
                    "it: undo it by hand");
}

TEST_CASE("The uncertainty of a value is known while it is as the last calibration set it") {
  const char* const depth = "/working_curve/penetration_depth_um";
  CHECK_FALSE(calibrated_error(kFixed, depth));
  const std::string once = with_calibration(kFixed, curve_calibration(148.2));
  const std::optional<CalibratedError> error = calibrated_error(once, depth);
  REQUIRE(error);
  CHECK(error->uncertainty == 3.9);
  CHECK(error->correlation == 0);
  CHECK_FALSE(calibrated_error(once, "/working_curve/overcure_um"));
  Json changed = Json::parse(once);
  changed["working_curve"]["penetration_depth_um"] = 160;
  CHECK_FALSE(calibrated_error(changed.dump(), depth));
  const std::string twice =
      with_calibration(once, {.kind = "curve", .date = "2026-11-28", .values = {{depth, 148.2}}});
  CHECK_FALSE(calibrated_error(twice, depth));
}

TEST_CASE("The correlation of a value's error is kept with it") {
  const char* const energy = "/working_curve/critical_energy_mj_cm2";
  const std::string text =
      with_calibration(kFixed, {.kind = "curve", .date = "2026-11-27", .values = {{energy, 8, 0.4, 0.9}}});
  CHECK(Json::parse(text)["calibrations"][0]["values"][0]["correlation"] == 0.9);
  const std::optional<CalibratedError> error = calibrated_error(text, energy);
  REQUIRE(error);
  CHECK(error->correlation == 0.9);
}

TEST_CASE("A hundred calibrations are kept") {
  std::string text = kFixed;
  for (int i = 0; i < 101; ++i)
    text = with_calibration(text, {.kind = "memory", .date = std::to_string(i), .values = {{"/x", i}}});
  const Json kept = Json::parse(text)["calibrations"];
  REQUIRE(kept.size() == 100);
  CHECK(kept.front()["date"] == "1");
  CHECK(kept.back()["date"] == "100");
}

}  // namespace
}  // namespace contourd
