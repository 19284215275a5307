// Tests that the functions of core/continuous check their requirements.
#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "core/continuous/gel_front.hpp"
#include "core/continuous/refill_distance.hpp"
#include "core/continuous/rise_laws.hpp"
#include "core/continuous/rise_plan.hpp"
#include "core/continuous/rise_planner.hpp"
#include "core/continuous/slab_sweep.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"

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

TEST_CASE("A front of gelled resin requires lit resin, and a speed of masks") {
  const LitResin resin{{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{4}, Micrometers{30}};
  const std::string lit = "lit resin has a working curve, light and a dead zone, and masks a speed";
  CHECK(contract_broken_by([&] { (void)GelFront(resin, {}, MillimetersPerSecond{1}); }).empty());
  CHECK(contract_broken_by([] { (void)GelFront({}, {}, MillimetersPerSecond{1}); }) == lit);
  CHECK(contract_broken_by([&] { (void)GelFront(resin, {}, {}); }) == lit);
}

TEST_CASE("Slabs require lengths, the same cells each, and are not too many") {
  CHECK(contract_broken_by([] { (void)slab_thickness({}, kCoarseLayer, Micrometers{1}); }) ==
        "slabs are of a print");
  RefillDistance distance(Millimeters{0.2});
  const auto dark = [](std::int32_t side) { return LitCells(Mask(Pixels{side}, Pixels{side}), CellRule{}); };
  (void)distance.add_slab(dark(8));
  CHECK(contract_broken_by([&] { (void)distance.add_slab(dark(16)); }) == "slabs have as many cells");
  ContourEngine engine = engine_for(models::cone(1, 1, 8), {kCoarseDisplay});
  StopCheck never;
  const SlabSettings thin{kCoarseDisplay, Nanometers{1'000'000'000}, Nanometers{1}};
  CHECK(contract_broken_by([&] { (void)sweep_slabs(engine, thin, never); }) ==
        "a print has at most 100,000 slabs");
}

TEST_CASE("Cells require a side, and a dark border") {
  const Mask mask(Pixels{8}, Pixels{8});
  CHECK(contract_broken_by([&] { (void)LitCells(mask, CellRule{.side = 0}); }) == "a cell has pixels");
  LitCells cells(mask, CellRule{});
  CHECK(contract_broken_by([&] { cells.light(cells.place(1, 1)); }).empty());
  CHECK(contract_broken_by([&] { cells.light(cells.place(0, 1)); }) == "the border is dark");
  CHECK(contract_broken_by([&] { cells.light(cells.place(1, 3)); }) == "the border is dark");
}

TEST_CASE("A plan of rises requires thick slabs and bounds that can be") {
  RiseBounds bounds{.lit = {{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{4}, Micrometers{30}},
                    .margin = 4,
                    .refill = {0.2, 50},
                    .fastest = MillimetersPerSecond{1},
                    .slowest = MillimetersPerSecond{1},
                    .acceleration = MillimetersPerSecondSquared{1},
                    .window = std::chrono::minutes{1}};
  const std::array slabs{RiseSlab{Nanometers{73'000}, {}}, RiseSlab{Nanometers{173'000}, {}}};
  CHECK(contract_broken_by([&] { (void)plan_rises(slabs, {}, bounds); }) ==
        "slabs are as thick as the gel gap");
  bounds.window = {};
  CHECK(contract_broken_by([&] { (void)plan_rises({}, {}, bounds); }) ==
        "a rise has speeds, an acceleration and a window");
}
