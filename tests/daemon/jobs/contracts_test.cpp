// Each header of daemon/jobs checks what it requires.

#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/unfiled_jobs.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"

namespace {

const std::string kJob = "there is a job", kWaits = "a job waits";

}  // namespace

TEST_CASE("CurrentJob begins one job at a time, and ends or returns only a job that it has") {
  testing::CurrentJobFixture fixture;
  CHECK(contract_broken_by([&] { fixture.job.cancel(); }) == kJob);
  CHECK(contract_broken_by([&] { (void)fixture.job.name(); }) == kJob);
  CHECK(contract_broken_by([&] { fixture.job.give_back(); }) == "there is a job that has not begun");
  fixture.begin();
  CHECK(contract_broken_by([&] { fixture.begin("other.stl"); }) == "there is no job yet");
  REQUIRE(fixture.run_until([&] { return fixture.job.print().under_way(); }));
  CHECK(contract_broken_by([&] { fixture.job.give_back(); }) == "there is a job that has not begun");
}

TEST_CASE("PrintQueue has a next job only while a job waits") {
  EventLoop loop;
  testing::LogText log{loop};
  PrinterConfig config;
  testing::FakeChecks work;
  testing::FakeQueueObserver observer;
  PrintQueue queue(config, work, observer, log.log);
  CHECK(contract_broken_by([&] { (void)queue.first_may_begin(); }) == kWaits);
  CHECK(contract_broken_by([&] { (void)queue.next(); }) == kWaits);
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

TEST_CASE("UnfiledJobs has a last job only if it has any") {
  testing::PrinterFixture fixture;
  testing::FakePrinter printer;
  const UnfiledJobs jobs(fixture.log.log, printer);
  CHECK(contract_broken_by([&] { (void)jobs.last(); }) == kJob);
}
