// Tests that the functions of core/continuous check their requirements.
#include <cstdint>
#include <string>

#include "core/continuous/rise_laws.hpp"
#include "core/continuous/rise_plan.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace {

RisePoint reached(std::int64_t height_nm, double speed_mm_s) {
  return {Nanometers{height_nm}, MillimetersPerSecond{speed_mm_s}, RiseLimit::Machine};
}

}  // namespace

TEST_CASE("The duration of a rise requires a plan from rest to rest") {
  const std::string rest = "a plan rises from rest to rest";
  CHECK(contract_broken_by([] { (void)duration({{reached(0, 0), reached(1, 1), reached(2, 0)}}); }).empty());
  CHECK(contract_broken_by([] { (void)duration({{reached(0, 0), reached(2, 0)}}); }) == rest);
  CHECK(contract_broken_by([] { (void)duration({{reached(0, 1), reached(1, 1), reached(2, 0)}}); }) == rest);
  CHECK(contract_broken_by([] { (void)duration({{reached(0, 0), reached(1, 1), reached(1, 0)}}); }) == rest);
}

TEST_CASE("The laws of a rise require quantities that can be") {
  const LitResin resin{{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{4}, Micrometers{30}};
  const std::string lit = "lit resin has a working curve, light and a dead zone";
  const std::string above_1 = "a margin is above 1";
  CHECK(contract_broken_by([&] { (void)gel_gap(resin, 4); }).empty());
  CHECK(contract_broken_by([] { (void)cure_speed({}, 4); }) == lit);
  CHECK(contract_broken_by([&] { (void)cure_speed(resin, 1); }) == above_1);
  CHECK(contract_broken_by([] { (void)margin_at({}, MillimetersPerSecond{1}); }) == lit);
  CHECK(contract_broken_by([&] { (void)margin_at(resin, MillimetersPerSecond{-1}); }) ==
        "a rise has a speed");
  CHECK(contract_broken_by([] { (void)gel_gap({}, 4); }) == lit);
  CHECK(contract_broken_by([&] { (void)gel_gap(resin, 1); }) == above_1);
  CHECK(contract_broken_by([&] { (void)print_through(resin.curve, 1); }) == above_1);
  const std::string flows = "resin flows by pressure through a gap";
  const RefillingResin refill{0.2, 50};
  CHECK(contract_broken_by([] { (void)refill_speed({}, Micrometers{30}, Millimeters{1}); }) == flows);
  CHECK(contract_broken_by([&] { (void)refill_speed(refill, Micrometers{30}, Millimeters{-1}); }) == flows);
  CHECK(contract_broken_by([&] {
          (void)steady_refill_speed(refill, resin, Millimeters{1}, MillimetersPerSecond{1});
        }) == "resin cures at the fastest speed");
  CHECK(contract_broken_by([] { (void)machine_speed({}); }) == "a machine makes masks and steps");
}
