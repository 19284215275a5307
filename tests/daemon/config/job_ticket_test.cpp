#include "daemon/config/job_ticket.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using testing::Complaints;
using testing::complaints_of;
using testing::ConfigFolder;

JobTicket load(std::string_view text) {
  const ConfigFolder folder;
  return load_job_ticket(folder.write("part.json", text));
}

Complaints complaints_about(std::string_view text) {
  return complaints_of([&] { (void)load(text); });
}

TEST_CASE("every key of a ticket arrives with its unit") {
  const JobTicket ticket = load(R"({
    "$schema": "ticket.schema.json", "resin": "tough", "layer_height_um": 2.5, "scale": 1.25, "fit": false,
    "rotation_deg": {"x": 90, "y": -45.5, "z": 360}, "position_mm": {"x": -10, "y": 2.5}, "copies": 3.0})");
  CHECK(ticket.resin == "tough");
  CHECK(ticket.layer_height == Nanometers{2500});
  CHECK(ticket.rotation.x == 90.0);
  CHECK(ticket.rotation.y == -45.5);
  CHECK(ticket.rotation.z == 360.0);
  CHECK(ticket.scale == 1.25);
  CHECK_FALSE(ticket.fit);
  CHECK(ticket.position.x == Millimeters{-10.0});
  CHECK(ticket.position.y == Millimeters{2.5});
  CHECK(ticket.copies == 3);
}

TEST_CASE("an empty ticket is the same as none") {
  const JobTicket ticket = load("{}");
  const JobTicket none;
  CHECK(ticket.resin == none.resin);
  CHECK(ticket.layer_height == none.layer_height);
  CHECK(ticket.rotation.x == none.rotation.x);
  CHECK(ticket.rotation.y == none.rotation.y);
  CHECK(ticket.rotation.z == none.rotation.z);
  CHECK(ticket.scale == none.scale);
  CHECK(ticket.fit == none.fit);
  CHECK(ticket.position.x == none.position.x);
  CHECK(ticket.position.y == none.position.y);
  CHECK(ticket.copies == none.copies);
}

TEST_CASE("a section of a ticket may be given in part") {
  const JobTicket ticket = load(R"({"rotation_deg": {"y": 30}, "position_mm": {"x": 5}})");
  CHECK(ticket.rotation.x == 0.0);
  CHECK(ticket.rotation.y == 30.0);
  CHECK(ticket.position.x == Millimeters{5.0});
  CHECK(ticket.position.y == Millimeters{0.0});
}

TEST_CASE("a ticket has scale or fit but not both") {
  CHECK(load(R"({"fit": true})").fit);
  CHECK(complaints_about(R"({"fit": true, "scale": 1})") ==
        Complaints{"/scale: a ticket has either scale or fit, not both"});
  CHECK(complaints_about(R"({"fit": false, "scale": 1})").empty());
}

TEST_CASE("a ticket's figures have limits") {
  CHECK(complaints_about(R"({"scale": 0.001, "copies": 100})").empty());
  CHECK(complaints_about(R"({"scale": 0})") == Complaints{"/scale: 0 is less than the least allowed, 0.001"});
  CHECK(complaints_about(R"({"scale": 1000.5})") ==
        Complaints{"/scale: 1000.5 is more than the limit, 1000"});
  CHECK(complaints_about(R"({"copies": 0})") == Complaints{"/copies: 0 is less than the least allowed, 1"});
  CHECK(complaints_about(R"({"copies": 101})") == Complaints{"/copies: 101 is more than the limit, 100"});
  CHECK(complaints_about(R"({"cracks": "refuse"})").empty());
  CHECK(complaints_about(R"({"cracks": "mend"})").size() == 1);
  CHECK(complaints_about(R"({"copies": 1.5})") == Complaints{"/copies: expected a whole number, found 1.5"});
  CHECK(complaints_about(R"({"position_mm": {"x": 1001}})") ==
        Complaints{"/position_mm/x: 1001 is more than the limit, 1000 mm"});
  CHECK(complaints_about(R"({"rotation_deg": [0, 0, 90]})") ==
        Complaints{"/rotation_deg: expected an object, found an array"});
}

TEST_CASE("a ticket cannot name a resin outside the resins folder") {
  for (const char* name : {"../x", "a/b", ".x", ""}) {
    CHECK(complaints_about(nlohmann::json{{"resin", name}}.dump()).size() == 1);
  }
}

TEST_CASE("a ticket that is no object or not there is refused") {
  CHECK(complaints_about("[]") == Complaints{"expected an object, found an array"});
  CHECK(complaints_about("3") == Complaints{"expected an object, found 3"});
  CHECK(complaints_of([] { (void)load_job_ticket("/nonexistent/part.json"); }) ==
        Complaints{"there is no such file"});
}

TEST_CASE("ten mistakes in a ticket are ten lines") {
  CHECK(
      complaints_about(R"({"resin": 1, "layer_height_um": "50", "rotation_deg": {"x": 400, "w": 1, "y": null},
                             "scale": true, "fit": true, "position_mm": {"z": 1}, "copies": -1, "copies": -1,
                             "colour": "red"})")
          .size() == 10);
}

}  // namespace
}  // namespace contourd
