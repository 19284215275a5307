// Tests of the contract checks in daemon/print.

#include "daemon/print/layer_durations.hpp"
#include "daemon/print/manual_process.hpp"
#include "daemon/print/mask_ahead.hpp"
#include "daemon/print/print_mode.hpp"
#include "daemon/print/rise_progress.hpp"
#include "daemon/print/split_exposure.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"
#include "tests/daemon/print/box_print.hpp"

namespace {

const std::string kPrint = "a print is under way";

}  // namespace

TEST_CASE("PrintMode::start requires a plan with layers and exposures, and that no print is under way") {
  testing::CurrentJobFixture fixture;
  PrintMode& process = fixture.job.print();
  PrintPlan dark;
  dark.layers = PrintLayers(LayerStack{Nanometers{50'000}, 1});
  CHECK(contract_broken_by([&] { process.start({}); }) == "a print has a layer and its exposure");
  CHECK(contract_broken_by([&] { process.start(std::move(dark)); }) ==
        "a print has a layer and its exposure");
  fixture.begin();
  REQUIRE(fixture.run_until([&] { return process.under_way(); }));
  CHECK(contract_broken_by([&] { process.start({}); }) == "no print is under way");
  CHECK(contract_broken_by([&] { (void)process.time_left(); }).empty());
}

TEST_CASE("A setting of a print is one of those that can be changed") {
  CHECK(contract_broken_by([] { (void)unit_of("colour"); }) == "a print has this setting");
}

TEST_CASE(
    "Rises require a layer beneath them, an order, a plan, and masks that are neither dimmed nor split") {
  testing::CurrentJobFixture fixture;
  PrintMode& process = fixture.job.print();
  const std::string why = "rises follow at least one layer, with masks as they are";
  const auto rise = [](std::int64_t bottom, std::int32_t first_layer) {
    const auto point = [&](std::int64_t height, double speed) {
      return RisePoint{Nanometers{height}, MillimetersPerSecond{speed}, RiseLimit::Cure};
    };
    return PlannedRise{
        {{point(bottom, 0), point(bottom + 20'000, 1), point(bottom + 50'000, 0)}}, first_layer, {}};
  };
  const auto start = [&](std::vector<PlannedRise> rises, bool split = false) {
    PrintPlan plan = testing::box_plan(4);
    plan.rises.emplace().each = std::move(rises);
    if (split) plan.split = std::make_unique<SplitExposure>(PanelTone{1, 1}, Pixels{4}, Pixels{3});
    return contract_broken_by([&] { process.start(std::move(plan)); });
  };
  CHECK(start({}) == why);
  CHECK(start({PlannedRise{}}) == why);
  CHECK(start({rise(0, 0)}) == why);
  CHECK(start({rise(100'000, 2), rise(50'000, 1)}) == why);
  CHECK(start({rise(200'000, 4)}) == why);  // above the print
  CHECK(start({rise(50'000, 1)}, true) == why);
}

TEST_CASE("The parts of a print follow each other: a rise begins once it is reached, and has a rest") {
  RiseProgress none;
  CHECK(contract_broken_by([&] { (void)none.current(); }) == "a rise is left");
  CHECK(contract_broken_by([&] { none.reach(); }) == "a rise is left");
  CHECK(contract_broken_by([&] { (void)none.rest_until({}); }) == "a rise is left");
  CHECK(contract_broken_by([&] { none.begin(); }) == "a rise is next");
  CHECK(contract_broken_by([&] { (void)none.rest(); }) == "a rise is under way");
  CHECK(contract_broken_by([&] { none.stop_at({}); }) == "a rise is under way");
  CHECK(contract_broken_by([&] { (void)none.longest({}); }) == "a rise is under way");
  CHECK(contract_broken_by([&] { none.slow_down({}, {}, {}); }) == "a rise is under way");
}

TEST_CASE("MaskAhead cuts one mask at a time, and each is taken once") {
  const VirtualClock clock;
  PrintPlan plan = testing::box_plan(3);
  MaskAhead masks(*plan.engine, clock, std::chrono::seconds{100});
  CHECK(contract_broken_by([&] { (void)masks.take(); }) == "a mask is ready");
  masks.begin(Nanometers{25'000});
  CHECK(masks.take().height == Nanometers{25'000});
  CHECK(contract_broken_by([&] { (void)masks.take(); }) == "a mask is ready");
}

TEST_CASE("The duration of a print requires a layer") {
  CHECK(contract_broken_by([] { (void)forecast_of({}, {}); }) == "a print has a layer");
}

TEST_CASE("The functions of PrintMode for a print under way require that a print is under way") {
  const testing::CurrentJobFixture fixture;
  const PrintMode& process = fixture.job.print();
  CHECK(contract_broken_by([&] { (void)process.layer(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.layer_top(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.layer_thickness(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.next_pause(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.can_cancel(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.why_it_ends(); }) == kPrint);
  testing::CurrentJobFixture other;
  CHECK(contract_broken_by([&] { other.job.print().pause_at(1); }) == kPrint);
  CHECK(contract_broken_by([&] { other.job.print().set({}); }) == kPrint);
  CHECK(contract_broken_by([&] { other.job.set("rest", 1); }) == kPrint);
  CHECK(contract_broken_by([&] { other.job.print().exclude({}); }) == kPrint);
  CHECK(contract_broken_by([&] { other.job.exclude(0); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.settings(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.why_fixed("lift"); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.time_left(); }) == kPrint);
}

TEST_CASE(
    "ManualProcess requires one operation at a time, a known height for a move, and darkness for a picture") {
  testing::PrinterFixture fixture;
  ManualProcess process(fixture.machine, fixture.clock, [] {});
  const MillimetersPerSecond speed{5};
  const Mask picture(fixture.machine.display().width(), fixture.machine.display().height());
  CHECK(contract_broken_by([&] { process.move_to(Nanometers{}, speed); }) == "the plate's height is known");
  CHECK(contract_broken_by([&] { process.nudge(Nanometers{2'000'001}, speed); }) == "a nudge is short");
  for (const Nanometers way : {Nanometers{-1}, fixture.machine.z_axis().travel() + Nanometers{1}})
    CHECK(contract_broken_by([&] { process.raise(way, speed); }) == "the plate rises within its travel");
  process.light_on(std::chrono::seconds{1});
  const std::string idle = "no operation is under way";
  CHECK(contract_broken_by([&] { process.home(speed); }) == idle);
  CHECK(contract_broken_by([&] { process.power_on(); }) == idle);
  CHECK(contract_broken_by([&] { process.give_way(); }) == idle);
  while (!process.light_may_be_on())
    REQUIRE(fixture.clock.run_next());
  CHECK(contract_broken_by([&] { process.show(picture, "white", std::chrono::seconds{1}); }) ==
        "nothing shines while the picture changes");
}

TEST_CASE("SplitExposure requires a mask of the display's size, a time, and a picture to follow") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{3});
  const Mask light(Pixels{4}, Pixels{3}), other(Pixels{4}, Pixels{2});
  const Duration second = std::chrono::seconds{1}, frame = second / 60;
  CHECK(contract_broken_by([&] {
          split.begin(other, {second, {}, frame});
        }) == "the mask has the display's size");
  CHECK(contract_broken_by([&] { split.begin(light, {{}, {}, frame}); }) == "the exposure has a time");
  split.begin(light, {second, {}, frame});
  CHECK(contract_broken_by([&] { (void)split.next(); }) == "the next picture is drawn");
  CHECK(contract_broken_by([&] { split.shown({}); }) == "the next picture is drawn");
}
