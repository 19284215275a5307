#include "daemon/report/rise_forecast_text.hpp"

#include <array>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/daemon/print/rise_fixture.hpp"

namespace contourd {
namespace {

using contourd::testing::Approx;
using contourd::testing::kWindowPrinter;
using contourd::testing::mm;
using contourd::testing::window_resin;

const MillimetersPerSecond kCure = cure_speed(rise_bounds(window_resin(), kWindowPrinter).lit, 4);

TEST_CASE("The forecast of a continuous print is a few lines, and JSON") {
  const ContinuousForecast forecast{rise_bounds(window_resin(), kWindowPrinter),
                                    {{.bottom = {}, .top = mm(1), .time = 100s},
                                     {.bottom = mm(1),
                                      .top = mm(18),
                                      .limit = RiseLimit::Cure,
                                      .slowest = kCure,
                                      .fastest = kCure,
                                      .time = 1100s,
                                      .rest = 2min},
                                     {.bottom = mm(18),
                                      .top = mm(20),
                                      .limit = RiseLimit::Refill,
                                      .slowest = kCure / 2,
                                      .fastest = kCure,
                                      .time = 300s}}};
  CHECK(forecast.time() == 1620s);
  CHECK(continuous_line(forecast) ==
        "27 min 00 s: 23 min 20 s rising, 1 min 40 s in layers, 1 rest, 2 min 00 s");
  // At half the speed, the margin is 8.
  CHECK(gel_line(forecast) == "50 to 73.2 um wide, cured 208 to 312 um through undersides (margin 4 to 8)");
  CHECK(range_lines(forecast) ==
        std::vector<std::string>{
            "    0.00 to     1.00 mm  layers                         1 min 40 s",
            "    1.00 to    18.00 mm  cure     55.3 mm/h             18 min 20 s, then a rest of 2 min 00 s; "
            "margin 4, cured 208 um through",
            "   18.00 to    20.00 mm  refill   27.6 to 55.3 mm/h     5 min 00 s; margin 4 to 8, cured 208 to "
            "312 um through"});
  const nlohmann::ordered_json json = continuous_json(forecast);
  CHECK(json["time_s"] == 1620);
  CHECK(json["rests"] == 1);
  CHECK(json["margin"][1].get<double>() == Approx(8));
  CHECK(json["ranges"].size() == 3);
  CHECK(json["ranges"][0]["limit"].is_null());
  CHECK(json["ranges"][1]["limit"] == "cure");
  CHECK(json["ranges"][1]["rest_s"] == 120);
  CHECK(json["rests_s"] == 120);
  CHECK_FALSE(json["ranges"][0].contains("margin"));
  CHECK(json["ranges"][2]["margin"][1].get<double>() == Approx(8));
  CHECK(json["ranges"][2]["gel_gap_um"][0].get<double>() == Approx(50.03).epsilon(1e-3));
  CHECK(json["ranges"][2]["print_through_um"][1].get<double>() == Approx(311.9).epsilon(1e-3));
  CHECK(ranges_table(forecast).find(
            "<td>refill</td><td>27.6 to 55.3</td><td>4 to 8</td><td>50 to 73.2</td><td>208 to 312</td>") !=
        std::string::npos);
  CHECK(json["ranges"][2]["speed_mm_h"][0].get<double>() == Approx(27.63).epsilon(1e-3));
}

TEST_CASE("A print without a rise says so") {
  const ContinuousForecast forecast{rise_bounds(window_resin(), kWindowPrinter),
                                    {{.bottom = {}, .top = mm(1), .time = 5s}}};
  CHECK(gel_line(forecast) == "none: nowhere can the plate rise a millimetre at 5 mm/h or faster");
  CHECK(continuous_line(forecast) == "5.0 s: 0.0 s rising, 5.0 s in layers");
}

TEST_CASE("Ranges beyond the first are counted") {
  ContinuousForecast forecast;
  forecast.ranges.resize(30);
  CHECK(range_lines(forecast).size() == 26);
  CHECK(range_lines(forecast).back() == "and 5 more; --json has all");
}

}  // namespace
}  // namespace contourd
