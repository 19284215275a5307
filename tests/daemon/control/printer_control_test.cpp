#include "daemon/control/printer_control.hpp"

#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"

using namespace contourd;
using Json = PrinterControl::Json;

namespace {

class Desk : public testing::CurrentJobFixture {
 public:
  // Why the method is refused; empty when it is not.
  std::string refusal_of(const std::string& method) {
    try {
      reply = methods.at(method).call(Json::object(), {});
    } catch (const ControlRefusal& refusal) {
      return refusal.what();
    }
    return "";
  }
  // With the job's print in this state, for a call.
  std::string refusal_in(PrintState state, const std::string& method) {
    bool called = false;
    std::string refusal;
    begin();
    run_until([&] {
      if (!called && job.print().state() == state) {
        called = true;
        refusal = refusal_of(method);
      }
      return called;
    });
    CHECK(called);
    return refusal;
  }
  void arrive(const std::string& file) {
    put(Spool::Folder::Incoming, file);
    queue.arrived(file);
  }

  PrintQueue queue{
      log.log,
      {.check = [](const std::string&, JobReader::Keep, const auto& done) { done(JobOutlook{}); },
       .forget = [](const std::string&) {},
       .reject = [](const std::string&, const std::string&, const Spool::Rejected&) {},
       .changed = [this] { scheduler.run(); },
       .refused = [](const std::string&, const std::string&) {},
       .removed = [](const std::string&, const std::string&) {},
       .keep_order = [](const QueueOrder::Names&, const auto&) {}}};
  JobScheduler scheduler{context,
                         spool,
                         queue,
                         hold,
                         {.has_job = [this] { return job.job() != nullptr; },
                          .prints = [this] { return job.print().state() != PrintState::Idle; },
                          .controlled_by_hand = [] { return false; },
                          .begin = [this](ClaimedJob claimed) { job.begin(std::move(claimed)); },
                          .copy_over = [] {}}};
  JobHistory history;
  ManualProcess manual{machine, clock, [] {}};
  ReminderConfig reminder_config;
  Reminders reminders{reminder_config};
  PrinterStatus status{context, {spool, queue, scheduler, hold, job, history, manual, reminders}};
  PrinterControl control{context, hold, job, scheduler, status};
  ControlMethods methods = control.methods();
  Json reply;
};

}  // namespace

TEST_CASE("Without a print there is nothing to pause, resume or cancel") {
  Desk desk;
  CHECK(desk.refusal_of("pause") == "there is no print to pause");
  CHECK(desk.refusal_of("resume") == "there is no print to resume");
  CHECK(desk.refusal_of("cancel") == "there is no print to cancel");
}

TEST_CASE(
    "A job that is being read can be cancelled, but neither paused nor resumed, nor its plate cleared") {
  Desk desk;
  desk.begin();
  CHECK(desk.refusal_of("pause") == "there is no print to pause");
  CHECK(desk.refusal_of("resume") == "there is no print to resume");
  CHECK(desk.refusal_of("plate_cleared") == "part is being printed");
  CHECK(desk.refusal_of("cancel").empty());
  CHECK(desk.job.job()->cancel_wanted);
}

TEST_CASE("The reply to a command is the status that it has led to") {
  Desk desk;
  CHECK(desk.refusal_in(PrintState::Exposing, "pause").empty());
  CHECK(desk.reply["job"]["pause_pending"] == true);
}

TEST_CASE("A print that is not paused cannot be resumed") {
  CHECK(Desk().refusal_in(PrintState::Exposing, "resume") == "the print is not paused");
}

TEST_CASE("A print whose layers are done can be neither paused nor cancelled") {
  CHECK(Desk().refusal_in(PrintState::Parking, "pause") == "all layers are printed, the plate goes up");
  CHECK(Desk().refusal_in(PrintState::Parking, "cancel") == "all layers are printed, the plate goes up");
}

TEST_CASE("A print does not go on while something is in its way") {
  Desk desk;
  desk.machine.open_lid();
  CHECK(desk.refusal_in(PrintState::Held, "resume") == "the print cannot go on: the lid is open");
  desk.machine.close_lid();
  CHECK(desk.refusal_of("resume").empty());
  CHECK(desk.job.print().state() == PrintState::WarmingUp);
}

TEST_CASE("To resume a held print releases the queue too") {
  Desk desk;
  desk.hold.hold("the emergency stop was pressed");
  CHECK(desk.refusal_in(PrintState::Held, "resume").empty());
  CHECK_FALSE(desk.hold.reason());
}

TEST_CASE("To resume a held queue has the next job begin, but not while something is in its way") {
  Desk desk;
  desk.hold.hold("part failed");
  desk.arrive("next.stl");
  desk.machine.open_lid();
  CHECK(desk.refusal_of("resume") == "the queue cannot go on: the lid is open");
  CHECK(desk.hold.reason());
  desk.machine.close_lid();
  CHECK(desk.refusal_of("resume").empty());
  CHECK_FALSE(desk.hold.reason());
  CHECK(desk.reply["state"] == "preparing");
  CHECK(desk.reply["job"]["name"] == "next");
}

TEST_CASE("A cleared plate releases the queue, and the next job begins") {
  Desk desk;
  desk.hold.set_plate_occupant("part");
  desk.hold.hold("part failed");
  desk.arrive("next.stl");
  CHECK(desk.reply.is_null());
  CHECK(desk.refusal_of("plate_cleared").empty());
  CHECK(desk.log.has("info: the plate is clear"));
  CHECK(desk.reply["plate"] == "clear");
  CHECK(desk.reply["held"].is_null());
  CHECK(desk.job.name() == "next");
}

TEST_CASE("Only what changes something is told in the log") {
  Desk desk;
  for (const auto& [name, method] : desk.methods) {
    CAPTURE(name);
    const bool asks = name == "status";
    CHECK(method.changes != asks);
  }
}
