#include "daemon/control/printer_control.hpp"

#include <fmt/format.h>

#include "tests/catch.hpp"
#include "tests/daemon/control/control_fixture.hpp"
#include "tests/message_of.hpp"

using Json = PrinterControl::Json;

namespace {

class PrinterControlFixture : public testing::ControlFixture {
 public:
  PrinterControlFixture() {
    queue_observer.on_change = [this] { scheduler.run(); };
  }
  // Calls the method and returns why it is refused; empty if it is not. The reply may come later.
  std::string refusal_of(const std::string& name, const Json& parameters = Json::object()) {
    const ControlMethod& method = methods.at(name);
    const auto later = [this](std::variant<Json, ControlRefusal> result) { reply = std::get<Json>(result); };
    return testing::message_of<ControlRefusal>([&] {
      if (method.call)
        reply = method.call(method.check(name, parameters), {});
      else
        method.call_later(parameters, {}, later);
    });
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

TEST_CASE_METHOD(PrinterControlFixture, "Without a print there is nothing to pause, resume or cancel") {
  CHECK(refusal_of("pause") == "there is no print to pause");
  CHECK(refusal_of("resume") == "there is no print to resume");
  CHECK(refusal_of("cancel") == "there is no print to cancel");
}

TEST_CASE_METHOD(
    PrinterControlFixture,
    "A job that is being read can be cancelled, but neither paused nor resumed, nor its plate cleared") {
  begin();
  CHECK(refusal_of("pause") == "there is no print to pause");
  CHECK(refusal_of("resume") == "there is no print to resume");
  CHECK(refusal_of("plate_cleared") == "part is being printed");
  CHECK(refusal_of("cancel").empty());
  CHECK(job.job()->cancel_wanted);
}

TEST_CASE_METHOD(PrinterControlFixture, "The reply to a command is the resulting status") {
  CHECK(refusal_in("exposing", "pause").empty());
  CHECK(reply["job"]["pause_pending"] == true);
}

TEST_CASE_METHOD(PrinterControlFixture,
                 "A planned pause is refused where the print has been, or never gets") {
  CHECK(refusal_of("pause", {{"at_layer", 2}}) == "there is no print to pause");
  REQUIRE(refusal_in("exposing", "status").empty());
  const auto layers = reply["job"]["layers"].get<int>();
  const std::string height = fmt::format("{:.3f}", 0.05 * (layers - 1));
  CHECK(refusal_of("pause", {{"at_layer", 1}}) ==
        fmt::format("a pause before layer 1 comes too late: layer 1 of {} is under way", layers));
  CHECK(refusal_of("pause", {{"at_mm", 0}}) ==
        "a pause at 0 mm comes too late: the layer under way lies at 0.000 mm");
  CHECK(refusal_of("pause", {{"at_layer", layers + 1}}) ==
        fmt::format("there is no layer {} to pause before: the print has {} layers", layers + 1, layers));
  CHECK(refusal_of("pause", {{"at_mm", 50}}) ==
        "there is no layer after a pause at 50 mm: the last one lies at " + height + " mm");
  CHECK(refusal_of("pause", {{"at_layer", layers}}).empty());
  CHECK(reply["job"]["planned_pause"] == fmt::format("before layer {}", layers));
  CHECK(refusal_of("pause", {{"at_mm", 0.05}}).empty());
  CHECK(reply["job"]["planned_pause"] == "at 0.050 mm");
  CHECK(refusal_of("resume").empty());
  CHECK(reply["job"]["planned_pause"].is_null());
}

TEST_CASE_METHOD(PrinterControlFixture, "A planned pause has one point") {
  REQUIRE(refusal_in("exposing", "status").empty());
  CHECK(testing::message_of<InvalidParameters>([&] {
          refusal_of("pause", {{"at_layer", 2}, {"at_mm", 1}});
        }) == "give either at_layer or at_mm");
}

TEST_CASE_METHOD(PrinterControlFixture, "A setting is changed within bounds, which its refusal names") {
  const auto set = [&](const std::string& setting, double value) {
    return refusal_of("set", {{"setting", setting}, {"value", value}});
  };
  CHECK(set("rest", 1).starts_with("nothing prints: "));
  REQUIRE(refusal_in("exposing", "status").empty());
  CHECK(set("lift", 0.05).starts_with("lift 0.05 mm is not allowed: the resin's profile "));
  CHECK(set("rest", 60'001).ends_with(" and the machine allow 0 to 60000 ms"));
  CHECK(set("lift-speed", 51).ends_with(" and the machine allow 0.01 to 50 mm/s"));
  CHECK(set("exposure", 0).find(" % is not allowed") != std::string::npos);
  CHECK(set("exposure", 90).empty());
  CHECK(set("retract-speed", 4).empty());
  CHECK(job.print().settings().exposure_percent == 90);
  REQUIRE(job.job()->record->changes().size() == 2);
  CHECK(job.job()->record->changes()[0] == SettingChange{1, "exposure", 90, 100});
  CHECK(log.has("info: part: from layer 2 on exposure 90 % instead of 100 %"));
}

TEST_CASE_METHOD(PrinterControlFixture,
                 "The settings are reported with the bounds within which they change") {
  CHECK(refusal_of("settings") == "there is no print to report the settings of");
  REQUIRE(refusal_in("exposing", "settings").empty());
  const Json settings = reply["settings"];
  REQUIRE(settings.size() == 5);  // nothing rises in this print
  for (const Json& each : settings) {
    const auto set = [&](double value) {
      return refusal_of("set", {{"setting", each["setting"]}, {"value", value}});
    };
    INFO(each.dump());
    CHECK(each["fixed"].is_null());
    const auto least = each["least"].get<double>(), most = each["most"].get<double>();
    CHECK(set(least).empty());
    CHECK(set(most).empty());
    CHECK_FALSE(set(least - 0.001).empty());
    CHECK_FALSE(set(most + 0.001).empty());
    CHECK(least <= each["value"].get<double>());
    CHECK(each["value"].get<double>() <= most);
  }
  REQUIRE(refusal_of("settings").empty());
  for (const Json& each : reply["settings"])
    CHECK(each["value"] == each["most"]);  // as was set last
}

TEST_CASE("The settings of a print whose layers are done are fixed") {
  PrinterControlFixture fixture;
  CHECK(fixture.refusal_in("parking", "settings").empty());
  for (const Json& each : fixture.reply["settings"]) {
    CHECK(each["fixed"] == "all layers are printed, the plate goes up");
    CHECK(each["most"].is_null());
  }
}

TEST_CASE_METHOD(PrinterControlFixture,
                 "The last copy of a print cannot be excluded, nor one that is not there") {
  const auto exclude = [&](const std::string& copy) { return refusal_of("exclude", {{"copy", copy}}); };
  CHECK(exclude("1") == "there is no print to exclude a copy from");
  REQUIRE(refusal_in("exposing", "copies").empty());
  REQUIRE(reply["copies"].size() == 1);
  CHECK(reply["copies"][0]["name"] == "part");
  CHECK(exclude("1") == "part is the last copy that is printed: cancel ends the print");
  CHECK(exclude("part") == "part is the last copy that is printed: cancel ends the print");
  CHECK(exclude("2") ==
        "there is no copy \"2\" on the plate: give a number from 1 to 1, or a name such as \"part\"");
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

TEST_CASE_METHOD(PrinterControlFixture, "A print does not resume while the machine is not ready") {
  machine.open_lid();
  CHECK(refusal_in("held", "resume") == "the print cannot go on: the lid is open");
  machine.close_lid();
  CHECK(refusal_of("resume").empty());
  CHECK(job.print().state().name == "warming up");
}

TEST_CASE_METHOD(PrinterControlFixture, "Resuming a held print also releases the queue") {
  hold.hold("the emergency stop was pressed");
  CHECK(refusal_in("held", "resume").empty());
  CHECK_FALSE(hold.reason());
}

TEST_CASE_METHOD(PrinterControlFixture,
                 "Resuming a held queue starts the next job, but not while the machine is not ready") {
  hold.hold("part failed");
  arrive("next.stl");
  machine.open_lid();
  CHECK(refusal_of("resume") == "the queue cannot go on: the lid is open");
  CHECK(hold.reason());
  machine.close_lid();
  CHECK(refusal_of("resume").empty());
  CHECK_FALSE(hold.reason());
  CHECK(reply["state"] == "preparing");
  CHECK(reply["job"]["name"] == "next");
}

TEST_CASE_METHOD(PrinterControlFixture, "A cleared plate releases the queue, and the next job begins") {
  hold.set_plate_occupant("part");
  hold.hold("part failed");
  arrive("next.stl");
  CHECK(reply.is_null());
  CHECK(refusal_of("plate_cleared").empty());
  CHECK(job.name() == "next");
  CHECK(reply.is_null());
  REQUIRE(run_until([&] { return !reply.is_null(); }));
  CHECK(log.has("info: the plate is clear"));
  CHECK(reply["plate"] == "clear");
  CHECK(reply["held"].is_null());
}

TEST_CASE_METHOD(PrinterControlFixture, "Only methods that change something are logged") {
  for (const auto& [name, method] : methods) {
    CAPTURE(name);
    const bool asks = name == "status" || name == "copies" || name == "settings";
    CHECK(method.changes != asks);
  }
}
