// That each header of daemon checks what it requires.
#include <unistd.h>

#include <string>
#include <utility>

#include "daemon/html_page.hpp"
#include "daemon/light_histogram.hpp"
#include "daemon/manual_process.hpp"
#include "daemon/print_process.hpp"
#include "daemon/print_queue.hpp"
#include "daemon/printer_control.hpp"
#include "daemon/service_user.hpp"
#include "daemon/state_times.hpp"
#include "daemon/unfiled_jobs.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/current_job_fixture.hpp"

using namespace contourd;
using testing::contract_broken_by;

namespace {

const std::string kPrint = "a print is under way", kJob = "there is a job", kWaits = "a job waits";

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

TEST_CASE("CurrentJob begins one job at a time, and ends one that there is") {
  testing::CurrentJobFixture desk;
  CHECK(contract_broken_by([&] { desk.job.cancel(); }) == kJob);
  CHECK(contract_broken_by([&] { (void)desk.job.name(); }) == kJob);
  CHECK(contract_broken_by([&] { desk.job.give_back(); }) == "there is a job that has not begun");
  desk.begin();
  CHECK(contract_broken_by([&] { desk.begin("other.stl"); }) == "there is no job yet");
  REQUIRE(desk.run_until([&] { return desk.job.print().state() != PrintState::Idle; }));
  CHECK(contract_broken_by([&] { desk.job.give_back(); }) == "there is a job that has not begun");
}

TEST_CASE("PrintQueue has a first job while one waits") {
  EventLoop loop;
  testing::LogText log{loop};
  PrintQueue queue(log.log, {.check = [](const std::string&, JobReader::Keep, const auto&) {},
                             .forget = [](const std::string&) {},
                             .reject = [](const std::string&, const std::string&, const auto&) {},
                             .changed = [] {},
                             .refused = [](const std::string&, const std::string&) {},
                             .removed = [](const std::string&, const std::string&) {},
                             .keep_order = [](const QueueOrder::Names&, const auto&) {}});
  CHECK(contract_broken_by([&] { (void)queue.first_may_begin(); }) == kWaits);
  CHECK(contract_broken_by([&] { queue.keep_first_waiting(); }) == kWaits);
  CHECK(contract_broken_by([&] { (void)queue.take_first(); }) == kWaits);
  CHECK(contract_broken_by([&] { queue.refuse_first("no"); }) == kWaits);
  CHECK(contract_broken_by([&] { queue.remove("part.stl", "no"); }) == "the job waits");
  CHECK(contract_broken_by([&] { queue.move("part.stl", 0); }) == "the job waits");
  queue.arrived("part.stl");
  CHECK(contract_broken_by([&] { queue.move("part.stl", 0); }).empty());
  CHECK(contract_broken_by([&] { (void)queue.take_first(); }).empty());
  queue.remove("part.stl", "no");
  CHECK(contract_broken_by([&] { queue.remove("part.stl", "no"); }) == "the job waits");
}

TEST_CASE("UnfiledJobs has a last job while there is one") {
  testing::PrinterFixture desk;
  const UnfiledJobs jobs(desk.spool, desk.log.log, nullptr);
  CHECK(contract_broken_by([&] { (void)jobs.last(); }) == kJob);
}

TEST_CASE("A plot's heights rise") {
  if (testing::costly_checks_are_off()) return;
  const PlotPoint rising[] = {{1, 5}, {1, 6}, {2, 4}}, falling[] = {{1, 5}, {0.5, 6}};
  CHECK(contract_broken_by([&] { (void)svg_plot("area", rising); }).empty());
  CHECK(contract_broken_by([&] { (void)svg_plot("area", falling); }) == "heights rise");
}

TEST_CASE("Only root looks what another user can reach") {
  CHECK(contract_broken_by([] {
          if (::geteuid() == 0 && ::seteuid(65534) != 0) return;
          (void)out_of_reach({}, {});
        }) == "this process is root's");
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

TEST_CASE("StateTimes goes forwards only") {
  const TimePoint start{std::chrono::hours(1)};
  StateTimes times(start);
  CHECK(contract_broken_by([&] { times.enter(PrintState::Homing, start - std::chrono::nanoseconds(1)); }) ==
        "times do not fall");
  CHECK(contract_broken_by([&] { times.enter(PrintState::Homing, start); }).empty());
}

TEST_CASE("A histogram of light is drawn when it has bins") {
  CHECK(contract_broken_by([] { (void)svg_of(LightHistogram{}); }) == "a histogram has bins");
}
