// Tests that the functions of core/continuous check their requirements.
#include <cstdint>
#include <string>

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
