#include "daemon/prepare/resin_temperature.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "daemon/print/layer_durations.hpp"
#include "daemon/system/readable.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/prepare/print_job_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd {
namespace {

constexpr Nanometers kLayer{50'000};

// A job whose resin was measured at 23 degrees, with Ec 5 mJ/cm² and an activation energy of 30 kJ/mol.
class TemperatureFixture : public testing::PrintJobFixture {
 public:
  TemperatureFixture() {
    resin.exposure = CurveExposure{Micrometers{50}, Micrometers{150}};
    resin.cure = CureSettings{.curve = {Micrometers{170}, MillijoulesPerCm2{5}}};
    resin.cure_temperature = CureTemperature{.measured_at_c = 23, .activation_energy_kj_mol = 30};
  }

  PreparedJob followed(const ResinTemperature& temperature) {
    printer.resin_temperature = temperature;
    PreparedJob job = prepare(testing::kCube);
    follow_temperature(job, printer);
    return job;
  }
  ResinTemperature sensor(const std::string& text) { return folder_.write("sensor", text); }
  // Returns the exposures of a bottom layer and a normal layer over those at 23 degrees.
  std::pair<double, double> light_of(const PreparedJob& job) {
    const auto over = [&](int layer) {
      return milliseconds(job.plan.exposure(layer, kLayer)) /
             milliseconds(exposure_time(resin, kLayer, layer, printer.irradiance_mw_cm2));
    };
    return {over(0), over(100)};
  }

 private:
  TemporaryFolder folder_;
};

// Arrhenius' law: ratio of the critical doses at two temperatures.
double arrhenius(double celsius) {
  return std::exp(30'000 / 8.314462618 * (1 / (celsius + 273.15) - 1 / (23 + 273.15)));
}

TEST_CASE_METHOD(TemperatureFixture, "All exposures follow the resin's temperature by Arrhenius' law") {
  for (const double celsius : {10.0, 23.0, 28.0, 40.0}) {
    CAPTURE(celsius);
    const PreparedJob job = followed(celsius);
    const auto [bottom, normal] = light_of(job);
    CHECK(bottom == Approx(arrhenius(celsius)));
    CHECK(normal == Approx(arrhenius(celsius)));
    REQUIRE(job.summary.temperature);
    CHECK(job.summary.temperature->light == Approx(arrhenius(celsius)));
    CHECK(job.summary.warnings.empty());
    CHECK_THAT(describe_settings(job.summary), Catch::Matchers::Contains("; light for resin of "));
  }
  CHECK(arrhenius(28) == Approx(0.817).margin(0.001));  // 5 degrees more: 18 percent less light
}

TEST_CASE_METHOD(TemperatureFixture, "A sensor's thousandths of a degree are read at the turn of a job") {
  const PreparedJob job = followed(sensor("28125\n"));
  CHECK(job.summary.temperature->resin_c == 28.125);
  CHECK(light_of(job).second == Approx(arrhenius(28.125)));
}

TEST_CASE_METHOD(TemperatureFixture, "The light of a waiting job is replaced by that of its turn") {
  printer.resin_temperature = 60.0;
  PreparedJob job = prepare(testing::kCube);
  follow_temperature(job, printer);
  CHECK(job.summary.warnings.size() == 1);
  printer.resin_temperature = 28.0;
  follow_temperature(job, printer);
  CHECK(light_of(job).second == Approx(arrhenius(28)));
  CHECK(job.summary.warnings.empty());
  printer.resin_temperature = sensor("warm");
  follow_temperature(job, printer);
  CHECK(light_of(job).second == 1);
  CHECK(job.summary.warnings.size() == 1);
  CHECK_FALSE(job.summary.temperature);
}

TEST_CASE_METHOD(TemperatureFixture, "More than 20 degrees of difference are not followed, with a warning") {
  const PreparedJob job = followed(60.0);
  CHECK(light_of(job).second == Approx(arrhenius(43)));
  REQUIRE(job.summary.warnings.size() == 1);
  CHECK(job.summary.warnings[0] ==
        "the resin has 60.0 degrees C, and its working curve was measured at 23: the light is that for 43 "
        "degrees, since more than 20 degrees of difference are not followed");
}

TEST_CASE_METHOD(TemperatureFixture, "Light stays that of the profile where the sensor has no temperature") {
  for (const char* text : {"", "warm\n", "23.5\n", "85000\n", "-1\n", "99999999999999999999\n"}) {
    CAPTURE(text);
    const PreparedJob job = followed(sensor(text));
    CHECK(light_of(job) == std::pair(1.0, 1.0));
    CHECK_FALSE(job.summary.temperature);
    REQUIRE(job.summary.warnings.size() == 1);
    CHECK_THAT(job.summary.warnings[0],
               Catch::Matchers::StartsWith("the light is that for resin of 23 degrees C, and does not follow "
                                           "the temperature: the sensor "));
  }
  const PreparedJob job = followed(std::filesystem::path("/nonexistent/temp1_input"));
  CHECK(light_of(job) == std::pair(1.0, 1.0));
  CHECK(job.summary.warnings.size() == 1);
}

TEST_CASE_METHOD(TemperatureFixture, "Exposures beyond the limits are not followed") {
  printer.irradiance_mw_cm2 = 0.14;  // a bottom layer takes 116 s
  const PreparedJob cold = followed(10.0);
  CHECK(light_of(cold) == std::pair(1.0, 1.0));
  REQUIRE(cold.summary.warnings.size() == 1);
  CHECK_THAT(cold.summary.warnings[0], Catch::Matchers::Contains("an exposure must last 1 ms to 120 s"));
}

// Returns the speed at which a job's first rise is held by the cure.
double cure_speed_of(const PreparedJob& job) {
  const std::vector<RisePoint>& points = job.plan.rises.value().each.front().plan.points;
  return std::ranges::max(points, {}, [](const RisePoint& point) { return point.speed.count(); })
      .speed.count();
}

TEST_CASE_METHOD(TemperatureFixture, "The speed of a rise follows the resin's temperature, too") {
  make_continuous();
  const double at_curve = cure_speed_of(followed(23.0));
  for (const double celsius : {10.0, 28.0}) {
    CAPTURE(celsius);
    const PreparedJob job = followed(celsius);
    CHECK(cure_speed_of(job) == Approx(at_curve / arrhenius(celsius)).epsilon(1e-3));
    const std::vector<Duration> times = layer_durations(job.plan, printer);
    CHECK(std::chrono::abs(job.summary.continuous.value().time() -
                           std::accumulate(times.begin(), times.end(), Duration{})) <
          std::chrono::microseconds{1});
    CHECK(job.summary.warnings.empty());
  }
}

TEST_CASE_METHOD(TemperatureFixture,
                 "A print is layered while the resin is too cold to rise at the least speed") {
  make_continuous();
  resin.continuous->slowest = MillimetersPerSecond{0.65 * cure_speed_of(followed(23.0))};
  PreparedJob job = followed(10.0);
  CHECK_FALSE(job.plan.rises);
  CHECK(job.summary.resin.mode == PrintWay::Layered);
  REQUIRE(job.summary.warnings.size() == 1);
  CHECK_THAT(job.summary.warnings[0],
             Catch::Matchers::StartsWith("the print is layered, not continuous: the resin "));
  printer.resin_temperature = 28.0;
  follow_temperature(job, printer);
  CHECK(job.plan.rises);
  CHECK(job.summary.resin.mode == PrintWay::Continuous);
  CHECK(job.summary.warnings.empty());
}

TEST_CASE_METHOD(TemperatureFixture, "Fixed exposures, and a curve of unknown temperature, do not follow") {
  resin.cure_temperature.reset();
  CHECK_FALSE(followed(30.0).summary.temperature);
  resin.cure_temperature = CureTemperature{};
  resin.exposure = FixedExposure{std::chrono::seconds{2}, std::chrono::seconds{20}};
  const PreparedJob job = followed(30.0);
  CHECK(job.plan.exposure(100, kLayer) == std::chrono::seconds{2});
  CHECK_FALSE(job.summary.temperature);
  CHECK(job.summary.warnings.empty());
}

}  // namespace
}  // namespace contourd
