// Each header of daemon/print checks what it requires.
#include <string>
#include <utility>

#include "daemon/print/manual_process.hpp"
#include "daemon/print/print_process.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"

using namespace contourd;
using testing::contract_broken_by;

namespace {

const std::string kPrint = "a print is under way";

}  // namespace

TEST_CASE("PrintProcess starts a print that has layers and exposures, while none is under way") {
  testing::CurrentJobFixture desk;
  PrintProcess& process = desk.job.print();
  PrintPlan dark;
  dark.layers = PrintLayers(LayerStack{Nanometers{50'000}, 1});
  CHECK(contract_broken_by([&] { process.start({}); }) == "a print has a layer and its exposure");
  CHECK(contract_broken_by([&] { process.start(std::move(dark)); }) ==
        "a print has a layer and its exposure");
  desk.begin();
  REQUIRE(desk.run_until([&] { return process.state() != PrintState::Idle; }));
  CHECK(contract_broken_by([&] { process.start({}); }) == "no print is under way");
  CHECK(contract_broken_by([&] { (void)process.time_left(); }).empty());
}

TEST_CASE("PrintProcess tells of the layer under way while there is one") {
  const testing::CurrentJobFixture desk;
  const PrintProcess& process = desk.job.print();
  CHECK(contract_broken_by([&] { (void)process.layer(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.layer_top(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.layer_thickness(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.next_pause(); }) == kPrint);
  CHECK(contract_broken_by([&] { (void)process.time_left(); }) == kPrint);
}

TEST_CASE("ManualProcess begins one operation at a time, moves from a known height, and shows in the dark") {
  testing::PrinterFixture desk;
  ManualProcess process(desk.machine, desk.clock, [] {});
  const MillimetersPerSecond speed{5};
  const Mask picture(desk.machine.display().width(), desk.machine.display().height());
  CHECK(contract_broken_by([&] { process.move_to(Nanometers{}, speed); }) == "the plate's height is known");
  CHECK(contract_broken_by([&] { process.nudge(Nanometers{2'000'001}, speed); }) == "a nudge is short");
  process.light_on(std::chrono::seconds{1});
  const std::string one = "no operation is under way";
  CHECK(contract_broken_by([&] { process.home(speed); }) == one);
  CHECK(contract_broken_by([&] { process.power_on(); }) == one);
  CHECK(contract_broken_by([&] { process.give_way(); }) == one);
  while (!process.light_may_be_on())
    REQUIRE(desk.clock.run_next());
  CHECK(contract_broken_by([&] { process.show(picture, "white", std::chrono::seconds{1}); }) ==
        "nothing shines while the picture changes");
}
