#include "daemon/control/setting_bounds.hpp"

#include <chrono>

#include "tests/catch.hpp"

using namespace std::chrono_literals;

namespace {

JobSummary summary_of(Duration exposure, Duration bottom) {
  JobSummary job;
  job.resin.exposure = FixedExposure{exposure, bottom};
  job.resin.bottom_layers = 2;
  job.resin.motion.lift = Nanometers{6'000'000};
  job.irradiance_mw_cm2 = 5;
  job.layers = {.count = 20, .thinnest = Nanometers{50'000}, .thickest = Nanometers{50'000}, .adaptive = {}};
  return job;
}

}  // namespace

TEST_CASE("The exposure's bounds keep every layer to come within 1 ms to 120 s") {
  const JobSummary job = summary_of(4s, 40s);
  CHECK(setting_bounds("exposure", job, {}, 1) == Limits<double>{1, 300});
  CHECK(setting_bounds("exposure", job, {}, 2) == Limits<double>{1, 1000});
  CHECK(setting_bounds("exposure", summary_of(5ms, 5ms), {}, 2) == Limits<double>{20, 1000});
  JobSummary stepped = summary_of(4s, 40s);
  stepped.resin.exposure = FixedExposure{4s, 40s, {{Nanometers{500'000}, 60s}}};
  CHECK(setting_bounds("exposure", stepped, {}, 2) == Limits<double>{1, 200});
}

TEST_CASE("A profile's ticket_limits bound what is set while it prints") {
  JobSummary job = summary_of(3s, 30s);
  job.resin.limits.exposure = Limits<Duration>{2s, 5s};
  job.resin.limits.rest = Limits<Duration>{100ms, 700ms};
  job.resin.limits.lift = Limits<Nanometers>{Nanometers{2'000'000}, Nanometers{8'000'000}};
  CHECK(setting_bounds("exposure", job, {}, 2) == Limits<double>{66.7, 166.6});
  CHECK(setting_bounds("rest", job, {}, 2) == Limits<double>{100, 700});
  CHECK(setting_bounds("lift", job, {}, 2) == Limits<double>{2, 8});
}

TEST_CASE("The machine's travel and top speed bound what is set while it prints") {
  JobSummary job = summary_of(3s, 30s);
  job.resin.motion.second_lift = Nanometers{4'000'000};
  job.resin.motion.slow_retract = Nanometers{5'000'000};
  const ResinMachine machine{
      .travel = Nanometers{50'000'000}, .irradiance_mw_cm2 = {}, .top_speed = MillimetersPerSecond{20}};
  CHECK(setting_bounds("lift", job, machine, 2) == Limits<double>{1, 45.999});
  CHECK(setting_bounds("lift-speed", job, machine, 2) == Limits<double>{0.01, 20});
  CHECK(setting_bounds("retract-speed", job, {}, 2) == Limits<double>{0.01, 50});
}

TEST_CASE("The settings of rises keep the plate at the slowest speed or faster") {
  JobSummary job = summary_of(4s, 40s);
  // At a margin of 4, the cure allows 55.26 mm/h.
  job.continuous.emplace().bounds = {
      .lit = {{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{4}, Micrometers{30}},
      .margin = 4,
      .fastest = MillimetersPerSecond{0.12},
      .slowest = MillimetersPerSecond{5.0 / 3600}};
  const Limits<double> speed = setting_bounds("speed", job, {}, 2);
  CHECK(speed.least == Approx(5));
  CHECK(speed.most == Approx(432));
  const Limits<double> margin = setting_bounds("margin", job, {}, 2);
  CHECK(margin.least == 1.1);
  CHECK(margin.most == Approx(4 * 55.26 / 5).epsilon(1e-3));
  CHECK(setting_bounds("light", job, {}, 2) == Limits<double>{10, 100});
}
