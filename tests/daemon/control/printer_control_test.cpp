#include "daemon/control/printer_control.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/control/control_fixture.hpp"

using Json = PrinterControl::Json;

namespace {

class PrinterControlFixture : public testing::ControlFixture {
 public:
  PrinterControlFixture() {
    queue_observer.on_change = [this] { scheduler.run(); };
  }
  // Calls the method and returns why it is refused; empty if it is not.
  std::string refusal_of(const std::string& method) {
    try {
      reply = methods.at(method).call(Json::object(), {});
    } catch (const ControlRefusal& refusal) {
      return refusal.what();
    }
    return "";
  }
  // Runs a job to the state, calls the method, and returns why it is refused.
  std::string refusal_in(std::string_view state, const std::string& method) {
    bool called = false;
    std::string refusal;
    begin();
    run_until([&] {
      if (!called && job.print().state().name == state) {
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

  PrinterControl control{context, hold, job, scheduler, status};
  ControlMethods methods = control.methods();
  Json reply;
};

}  // namespace

TEST_CASE("Without a print there is nothing to pause, resume or cancel") {
  PrinterControlFixture fixture;
  CHECK(fixture.refusal_of("pause") == "there is no print to pause");
  CHECK(fixture.refusal_of("resume") == "there is no print to resume");
  CHECK(fixture.refusal_of("cancel") == "there is no print to cancel");
}

TEST_CASE(
    "A job that is being read can be cancelled, but neither paused nor resumed, nor its plate cleared") {
  PrinterControlFixture fixture;
  fixture.begin();
  CHECK(fixture.refusal_of("pause") == "there is no print to pause");
  CHECK(fixture.refusal_of("resume") == "there is no print to resume");
  CHECK(fixture.refusal_of("plate_cleared") == "part is being printed");
  CHECK(fixture.refusal_of("cancel").empty());
  CHECK(fixture.job.job()->cancel_wanted);
}

TEST_CASE("The reply to a command is the resulting status") {
  PrinterControlFixture fixture;
  CHECK(fixture.refusal_in("exposing", "pause").empty());
  CHECK(fixture.reply["job"]["pause_pending"] == true);
}

TEST_CASE("A print that is not paused cannot be resumed") {
  CHECK(PrinterControlFixture().refusal_in("exposing", "resume") == "the print is not paused");
}

TEST_CASE("A print whose layers are done can be neither paused nor cancelled") {
  CHECK(PrinterControlFixture().refusal_in("parking", "pause") ==
        "all layers are printed, the plate goes up");
  CHECK(PrinterControlFixture().refusal_in("parking", "cancel") ==
        "all layers are printed, the plate goes up");
}

TEST_CASE("A print does not resume while the machine is not ready") {
  PrinterControlFixture fixture;
  fixture.machine.open_lid();
  CHECK(fixture.refusal_in("held", "resume") == "the print cannot go on: the lid is open");
  fixture.machine.close_lid();
  CHECK(fixture.refusal_of("resume").empty());
  CHECK(fixture.job.print().state().name == "warming up");
}

TEST_CASE("Resuming a held print also releases the queue") {
  PrinterControlFixture fixture;
  fixture.hold.hold("the emergency stop was pressed");
  CHECK(fixture.refusal_in("held", "resume").empty());
  CHECK_FALSE(fixture.hold.reason());
}

TEST_CASE("Resuming a held queue starts the next job, but not while the machine is not ready") {
  PrinterControlFixture fixture;
  fixture.hold.hold("part failed");
  fixture.arrive("next.stl");
  fixture.machine.open_lid();
  CHECK(fixture.refusal_of("resume") == "the queue cannot go on: the lid is open");
  CHECK(fixture.hold.reason());
  fixture.machine.close_lid();
  CHECK(fixture.refusal_of("resume").empty());
  CHECK_FALSE(fixture.hold.reason());
  CHECK(fixture.reply["state"] == "preparing");
  CHECK(fixture.reply["job"]["name"] == "next");
}

TEST_CASE("A cleared plate releases the queue, and the next job begins") {
  PrinterControlFixture fixture;
  fixture.hold.set_plate_occupant("part");
  fixture.hold.hold("part failed");
  fixture.arrive("next.stl");
  CHECK(fixture.reply.is_null());
  CHECK(fixture.refusal_of("plate_cleared").empty());
  CHECK(fixture.log.has("info: the plate is clear"));
  CHECK(fixture.reply["plate"] == "clear");
  CHECK(fixture.reply["held"].is_null());
  CHECK(fixture.job.name() == "next");
}

TEST_CASE("Only methods that change something are logged") {
  PrinterControlFixture fixture;
  for (const auto& [name, method] : fixture.methods) {
    CAPTURE(name);
    const bool asks = name == "status";
    CHECK(method.changes != asks);
  }
}
