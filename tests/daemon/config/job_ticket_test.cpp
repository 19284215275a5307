#include "daemon/config/job_ticket.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

JobTicket load_ticket(std::string_view text) {
  const ConfigFolder folder;
  return load_job_ticket(folder.write("part.json", text));
}

JobTicket load_plate(std::string_view text) {
  const ConfigFolder folder;
  return load_plate_ticket(folder.write("plate.json", text));
}

Complaints ticket_complaints(std::string_view text) {
  return complaints_of([&] { (void)load_ticket(text); });
}

TEST_CASE("every key of a ticket is read with its unit") {
  const JobTicket ticket = load_ticket(R"({
    "$schema": "ticket.schema.json", "resin": "tough", "layer_height_um": 2.5, "unit": "inch", "scale": 1.25, "fit": false,
    "rotation_deg": {"x": 90, "y": -45.5, "z": 360}, "position_mm": {"x": -10, "y": 2.5}, "copies": 3.0})");
  CHECK(ticket.resin == "tough");
  CHECK(ticket.layer_height == Nanometers{2500});
  CHECK_FALSE(ticket.adaptive);
  REQUIRE(ticket.models.size() == 1);
  const ModelTicket& model = ticket.models[0];
  CHECK(model.file.empty());
  CHECK(model.rotation.x == 90.0);
  CHECK(model.rotation.y == -45.5);
  CHECK(model.rotation.z == 360.0);
  CHECK(model.unit == LengthUnit::Inch);
  CHECK(model.scale == Scale{1.25});
  CHECK_FALSE(model.up);
  CHECK_FALSE(model.fit);
  REQUIRE(model.position);
  CHECK(model.position->x == Millimeters{-10.0});
  CHECK(model.position->y == Millimeters{2.5});
  CHECK(model.copies == 3);
}

TEST_CASE("a ticket without a policy for cracks has none") {
  CHECK_FALSE(load_ticket("{}").cracks);
  CHECK(load_ticket(R"({"cracks": "repair"})").cracks == CrackPolicy::Repair);
  CHECK(load_plate(R"({"cracks": "refuse", "models": [{"file": "a.stl"}]})").cracks == CrackPolicy::Refuse);
}

TEST_CASE("a ticket or a plate has its job wait to be confirmed, or does not") {
  CHECK_FALSE(load_ticket("{}").confirm);
  CHECK(load_ticket(R"({"confirm": true})").confirm);
  CHECK(load_plate(R"({"confirm": true, "models": [{"file": "a.stl"}]})").confirm);
  CHECK(ticket_complaints(R"({"confirm": "yes"})").size() == 1);
}

TEST_CASE("a ticket or a plate asks for a dry run, or does not") {
  CHECK_FALSE(load_ticket("{}").dry);
  CHECK(load_ticket(R"({"dry": true})").dry);
  CHECK(load_plate(R"({"dry": true, "models": [{"file": "a.stl"}]})").dry);
  CHECK(ticket_complaints(R"({"dry": "yes"})").size() == 1);
}

TEST_CASE("a ticket's undersides are plain or by dose, or not its business") {
  CHECK_FALSE(load_ticket("{}").undersides);
  CHECK(load_ticket(R"({"undersides": "dose"})").undersides == Undersides::Dose);
  CHECK(load_ticket(R"({"undersides": "plain"})").undersides == Undersides::Plain);
  CHECK(load_plate(R"({"undersides": "dose", "models": [{"file": "a.stl"}]})").undersides ==
        Undersides::Dose);
  CHECK(ticket_complaints(R"({"undersides": "dark"})").size() == 1);
  CHECK(ticket_complaints(R"({"undersides": true})").size() == 1);
}

TEST_CASE("a ticket's mode is layered or continuous, or not its business") {
  CHECK_FALSE(load_ticket("{}").mode);
  CHECK(load_ticket(R"({"mode": "layered"})").mode == PrintWay::Layered);
  CHECK(load_plate(R"({"mode": "continuous", "models": [{"file": "a.stl"}]})").mode == PrintWay::Continuous);
  CHECK(ticket_complaints(R"({"mode": "fast"})").size() == 1);
}

TEST_CASE("a ticket's unit is one of those that a model may be in") {
  CHECK_FALSE(load_ticket("{}").models[0].unit);
  for (const LengthUnit unit : {LengthUnit::Millimeter, LengthUnit::Centimeter, LengthUnit::Meter,
                                LengthUnit::Micrometer, LengthUnit::Inch, LengthUnit::Foot}) {
    const std::string key = R"("unit": ")" + std::string(name_of(unit)) + "\"";
    CHECK(load_ticket("{" + key + "}").models[0].unit == unit);
    CHECK(load_plate(R"({"models": [{"file": "a.stl", )" + key + "}]}").models[0].unit == unit);
  }
  CHECK(ticket_complaints(R"({"unit": "furlong"})").size() == 1);
  CHECK(ticket_complaints(R"({"unit": 25.4})").size() == 1);
}

TEST_CASE("a ticket sets supports to auto, on, off or in the file, or to on with its own values") {
  CHECK_FALSE(load_ticket("{}").supports);
  CHECK(load_ticket(R"({"supports": "off"})").supports == SupportTicket{SupportPolicy::Off, {}});
  CHECK(load_ticket(R"({"supports": "auto"})").supports == SupportTicket{SupportPolicy::Auto, {}});
  CHECK(load_ticket(R"({"supports": "on"})").supports == SupportTicket{SupportPolicy::On, {}});
  CHECK(load_ticket(R"({"supports": "in the file"})").supports == SupportTicket{SupportPolicy::InFile, {}});
  CHECK(load_ticket(R"({"supports": {"lift_mm": 7.5, "tip_diameter_mm": 0.3}})").supports ==
        SupportTicket{SupportPolicy::On, {{"tip_diameter_mm", 0.3}, {"lift_mm", 7.5}}});
  CHECK(load_plate(R"({"supports": "off", "models": [{"file": "a.stl"}]})").supports ==
        SupportTicket{SupportPolicy::Off, {}});
  CHECK(ticket_complaints(R"({"supports": "yes"})").size() == 1);
  CHECK(ticket_complaints(R"({"supports": {"tip_diameter_mm": 0.01}})") ==
        Complaints{"/supports/tip_diameter_mm: 0.01 is less than the least allowed, 0.05 mm"});
}

TEST_CASE("a drain hole is read in the model's own millimetres") {
  const ModelTicket model = load_ticket(R"({"drain": [
      {"position_mm": {"x": 1.5, "z": -2}, "direction": {"z": 2}, "diameter_mm": 3, "depth_mm": 4.5},
      {"position_mm": {}, "direction": {"y": -1}, "diameter_mm": 1}]})")
                                .models[0];
  REQUIRE(model.drain.size() == 2);
  CHECK(model.drain[0] == DrainHole{1.5, 0, -2, {0, 0, 2}, 3, 4.5});
  CHECK(model.drain[1] == DrainHole{0, 0, 0, {0, -1, 0}, 1, 5});
  CHECK(load_plate(R"({"models": [{"file": "a.stl", "drain": [
      {"position_mm": {}, "direction": {"y": -1}, "diameter_mm": 1}]}]})")
            .models[0]
            .drain.size() == 1);
  CHECK(load_ticket("{}").models[0].drain.empty());
}

TEST_CASE("a hollow model has walls, holes and, if asked for, an infill") {
  CHECK(load_ticket("{}").models[0].hollow == std::nullopt);
  CHECK(load_ticket(R"({"hollow": {}})").models[0].hollow ==
        HollowSettings{Millimeters{2}, std::nullopt, Millimeters{2.5}});
  CHECK(load_ticket(R"({"hollow": {"wall_mm": 1.5, "hole_mm": 0, "infill": {"cell_mm": 6}}})")
            .models[0]
            .hollow ==
        HollowSettings{Millimeters{1.5}, InfillLattice{Millimeters{6}, Millimeters{1}}, Millimeters{0}});
  CHECK(load_plate(R"({"models": [{"file": "a.stl", "hollow": {"wall_mm": 3}}]})").models[0].hollow->wall ==
        Millimeters{3});
  CHECK(ticket_complaints(R"({"hollow": {"wall_mm": 0.1}})") ==
        Complaints{"/hollow/wall_mm: 0.1 is less than the least allowed, 0.2 mm"});
  CHECK(
      ticket_complaints(R"({"hollow": {"infill": {"cell_mm": 4, "strut_mm": 2.5}}})") ==
      Complaints{"/hollow/infill/strut_mm: 2.5 is more than half of cell_mm, 4: the cells would be closed"});
  CHECK(ticket_complaints(R"({"hollow": true})").size() == 1);
}

TEST_CASE("a drain hole needs a place, a nonzero direction and a diameter, and their number is limited") {
  CHECK(ticket_complaints(R"({"drain": [{"position_mm": {}, "direction": {"z": 0}, "diameter_mm": 1}]})") ==
        Complaints{"/drain/0/direction: a direction must not be zero in x, y and z"});
  CHECK(ticket_complaints(R"({"drain": [{"position_mm": {}, "direction": {"z": 1}, "diameter_mm": 0}]})") ==
        Complaints{"/drain/0/diameter_mm: 0 is less than the least allowed, 0.001 mm"});
  CHECK(ticket_complaints(R"({"drain": [{}]})").size() == 3);
  std::string many = R"({"drain": [)";
  for (int i = 0; i < 17; ++i)
    many +=
        std::string(i == 0 ? "" : ", ") + R"({"position_mm": {}, "direction": {"z": 1}, "diameter_mm": 1})";
  CHECK(ticket_complaints(many + "]}").size() == 1);
}

TEST_CASE("an empty ticket equals no ticket") {
  const JobTicket ticket = load_ticket("{}");
  CHECK_FALSE(ticket.resin);
  CHECK_FALSE(ticket.layer_height);
  CHECK_FALSE(ticket.adaptive);
  REQUIRE(ticket.models.size() == JobTicket{}.models.size());
  const ModelTicket model = ticket.models[0], none;
  CHECK(model.rotation.x == none.rotation.x);
  CHECK(model.rotation.y == none.rotation.y);
  CHECK(model.rotation.z == none.rotation.z);
  CHECK(model.up == none.up);
  CHECK(model.scale == none.scale);
  CHECK(model.fit == none.fit);
  CHECK(model.position.has_value() == none.position.has_value());
  CHECK(model.copies == none.copies);
}

TEST_CASE("a section of a ticket may be incomplete") {
  const ModelTicket model =
      load_ticket(R"({"rotation_deg": {"y": 30}, "position_mm": {"x": 5}, "scale": {"y": 1.02}})").models[0];
  CHECK(model.rotation.x == 0.0);
  CHECK(model.rotation.y == 30.0);
  CHECK(model.position->x == Millimeters{5.0});
  CHECK(model.position->y == Millimeters{0.0});
  CHECK(model.scale == Scale{1, 1.02, 1});
  CHECK(load_ticket(R"({"up": {"x": -2}})").models[0].up == Direction{-2, 0, 0});
}

TEST_CASE("a ticket has up or a rotation but not both, and up is a direction") {
  CHECK(ticket_complaints(R"({"up": {"z": 1}, "rotation_deg": {"x": 90}})") ==
        Complaints{"/up: a ticket has either up or rotation_deg, not both"});
  CHECK(ticket_complaints(R"({"up": {}})") == Complaints{"/up: a direction must not be zero in x, y and z"});
  CHECK(ticket_complaints(R"({"up": {"z": 0.0}})").size() == 1);
  CHECK(ticket_complaints(R"({"up": {"x": "left"}})") ==
        Complaints{"/up/x: expected a number, found the text \"left\""});
}

TEST_CASE("a ticket can leave the orientation to contourd and name surfaces to keep clean") {
  const ModelTicket model = load_ticket(R"({"up": "clean", "keep_clean": [
    {"y": -1}, {"min": {"x": 0, "y": -1, "z": 2}, "max": {"x": 3, "y": 4, "z": 5}}]})")
                                .models[0];
  CHECK_FALSE(model.up);
  REQUIRE(model.orientation);
  CHECK(model.orientation->preset == OrientationPreset::Clean);
  CHECK(model.orientation->keep_clean ==
        std::vector<KeepClean>{Direction{0, -1, 0}, KeepCleanBox{{0, -1, 2}, {3, 4, 5}}});
  CHECK(load_ticket(R"({"up": "auto"})").models[0].orientation == OrientationTicket{});
  CHECK_FALSE(load_ticket(R"({"up": {"z": 1}})").models[0].orientation);
  const JobTicket plate =
      load_plate(R"({"models": [{"file": "a.stl", "up": "safe", "keep_clean": [{"x": 1}]}]})");
  CHECK(plate.models[0].orientation == OrientationTicket{OrientationPreset::Safe, {Direction{1, 0, 0}}});
}

TEST_CASE("keep_clean requires an automatic orientation and valid surfaces") {
  const auto only = [](std::string_view text, const std::string& complaint) {
    CHECK(ticket_complaints(text) == Complaints{complaint});
  };
  const std::string requires_up =
      "/keep_clean: it requires \"up\": \"auto\", \"fast\", \"clean\" or \"safe\"";
  only(R"({"keep_clean": [{"x": 1}]})", requires_up);
  only(R"({"up": {"z": 1}, "keep_clean": [{"x": 1}]})", requires_up);
  only(R"({"up": "auto", "rotation_deg": {"x": 90}})",
       "/up: a ticket has either up or rotation_deg, not both");
  only(R"({"up": "auto", "keep_clean": [{"x": 0, "z": 0}]})",
       "/keep_clean/0: a direction must not be zero in x, y and z");
  const std::string either = "a surface to keep clean is either a direction (x, y, z) or a box (min and max)";
  only(R"({"up": "auto", "keep_clean": [{"x": 1}, {}]})", "/keep_clean/1: " + either);
  only(R"({"up": "auto", "keep_clean": [{"min": {"x": 0, "y": 0, "z": 0}}]})", "/keep_clean/0: " + either);
  only(
      R"({"up": "auto", "keep_clean": [{"min": {"x": 0, "y": 5, "z": 0}, "max": {"x": 1, "y": 1, "z": 1}}]})",
      "/keep_clean/0/min/y: it is more than the y of max");
  CHECK(ticket_complaints(R"({"up": "best"})").size() == 1);
  CHECK(ticket_complaints(R"({"up": "auto", "keep_clean": []})").size() == 1);
  CHECK(ticket_complaints(R"({"up": "auto", "keep_clean": {"x": 1}})").size() == 1);
  CHECK(ticket_complaints(R"({"up": "auto", "keep_clean": [1]})").size() == 1);
}

TEST_CASE("a ticket's layers have one height or are adaptive") {
  const JobTicket ticket =
      load_ticket(R"({"adaptive_layers": {"cusp_um": 12.5, "min_um": 20, "max_um": 80}})");
  REQUIRE(ticket.adaptive);
  CHECK(ticket.adaptive->cusp == Nanometers{12'500});
  CHECK(ticket.adaptive->thinnest == Nanometers{20'000});
  CHECK(ticket.adaptive->thickest == Nanometers{80'000});
  CHECK_FALSE(load_ticket(R"({"adaptive_layers": {"cusp_um": 5}})").adaptive->thinnest);
  CHECK(ticket_complaints(R"({"adaptive_layers": {"cusp_um": 5}, "layer_height_um": 50})") ==
        Complaints{"/adaptive_layers: a ticket has either adaptive_layers or layer_height_um, not both"});
  CHECK(ticket_complaints(R"({"adaptive_layers": {"cusp_um": 5, "min_um": 50, "max_um": 40}})") ==
        Complaints{"/adaptive_layers/min_um: it is more than max_um"});
  CHECK(ticket_complaints(R"({"adaptive_layers": {}})").size() == 1);
}

TEST_CASE("a scale is a number or a factor for each axis") {
  CHECK(ticket_complaints(R"({"scale": "big"})") ==
        Complaints{"/scale: expected an object or a number, found the text \"big\""});
  CHECK(ticket_complaints(R"({"scale": {"x": 0, "w": 1}})") ==
        Complaints{"/scale/w: there is no key \"w\" here; the known keys are \"x\", \"y\", \"z\"",
                   "/scale/x: 0 is less than the least allowed, 0.001"});
  CHECK(ticket_complaints(R"({"scale": {"x": 1}, "fit": true})") ==
        Complaints{"/scale: a ticket has either scale or fit, not both"});
}

TEST_CASE("a ticket has scale or fit but not both") {
  CHECK(load_ticket(R"({"fit": true})").models[0].fit);
  CHECK(ticket_complaints(R"({"fit": true, "scale": 1})") ==
        Complaints{"/scale: a ticket has either scale or fit, not both"});
  CHECK(ticket_complaints(R"({"fit": false, "scale": 1})").empty());
}

TEST_CASE("a ticket's numbers have limits") {
  CHECK(ticket_complaints(R"({"scale": 0.001, "copies": 100})").empty());
  CHECK(ticket_complaints(R"({"scale": 0})") ==
        Complaints{"/scale: 0 is less than the least allowed, 0.001"});
  CHECK(ticket_complaints(R"({"scale": 1000.5})") ==
        Complaints{"/scale: 1000.5 is more than the limit, 1000"});
  CHECK(ticket_complaints(R"({"copies": 0})") == Complaints{"/copies: 0 is less than the least allowed, 1"});
  CHECK(ticket_complaints(R"({"copies": 101})") == Complaints{"/copies: 101 is more than the limit, 100"});
  CHECK(ticket_complaints(R"({"cracks": "refuse"})").empty());
  CHECK(ticket_complaints(R"({"cracks": "mend"})").size() == 1);
  CHECK(ticket_complaints(R"({"copies": 1.5})") == Complaints{"/copies: expected a whole number, found 1.5"});
  CHECK(ticket_complaints(R"({"position_mm": {"x": 1001}})") ==
        Complaints{"/position_mm/x: 1001 is more than the limit, 1000 mm"});
  CHECK(ticket_complaints(R"({"rotation_deg": [0, 0, 90]})") ==
        Complaints{"/rotation_deg: expected an object, found an array"});
}

TEST_CASE("a ticket's exposures by height are read, and rise") {
  using std::chrono::milliseconds;
  CHECK(load_ticket(R"({"exposure_steps": [{"from_mm": 0.5, "exposure_ms": 4000},
                                           {"from_mm": 2.5, "exposure_ms": 3000}]})")
            .overrides.exposure_steps ==
        std::vector<ExposureStep>{{Nanometers{500'000}, milliseconds{4000}},
                                  {Nanometers{2'500'000}, milliseconds{3000}}});
  CHECK(ticket_complaints(R"({"exposure_steps": []})").size() == 1);
  CHECK(ticket_complaints(R"({"exposure_steps": 3000})") ==
        Complaints{"/exposure_steps: expected a list, found 3000"});
  CHECK(ticket_complaints(R"({"exposure_steps": [{"from_mm": 0, "exposure_ms": 0.5}]})") ==
        Complaints{"/exposure_steps/0/exposure_ms: 0.5 is less than the least allowed, 1 ms"});
  CHECK(ticket_complaints(R"({"exposure_steps": [{"exposure_ms": 10}]})").size() == 1);
  CHECK(ticket_complaints(R"({"exposure_steps": [{"from_mm": 2, "exposure_ms": 10},
                                                 {"from_mm": 2, "exposure_ms": 20}]})") ==
        Complaints{"/exposure_steps/1/from_mm: 2 is not above the step before it, 2"});
  CHECK(
      ticket_complaints(
          R"({"adaptive_layers": {"cusp_um": 5}, "exposure_steps": [{"from_mm": 2, "exposure_ms": 10}]})") ==
      Complaints{"/exposure_steps: a ticket has either adaptive_layers or exposure_steps, not both"});
}

TEST_CASE("a ticket's own exposures, lift and waits are read with their units") {
  using std::chrono::milliseconds;
  CHECK(load_ticket("{}").overrides == TicketOverrides{});
  const TicketOverrides asked =
      load_ticket(R"({"exposure_ms": 2500.5, "bottom_exposure_ms": 2e4, "lift_mm": 7.5,
                                         "settle_ms": 0, "rest_ms": 250})")
          .overrides;
  CHECK(asked.exposure == std::chrono::microseconds{2'500'500});
  CHECK(asked.bottom_exposure == milliseconds{20'000});
  CHECK(asked.lift == Nanometers{7'500'000});
  CHECK(asked.settle == milliseconds{0});
  CHECK(asked.rest == milliseconds{250});
  CHECK(load_plate(R"({"settle_ms": 40, "models": [{"file": "a.stl"}]})").overrides.settle ==
        milliseconds{40});
}

TEST_CASE("no odd number in a ticket becomes an exposure or a move") {
  CHECK(ticket_complaints(R"({"exposure_ms": 1e308})") ==
        Complaints{"/exposure_ms: 1e+308 is more than the limit, 120000 ms"});
  for (const char* key : {"exposure_ms", "bottom_exposure_ms", "lift_mm", "settle_ms", "rest_ms"}) {
    for (const char* value : {"-1", "1e308", "-1e308", "1e999", "120001", "18446744073709551616", "\"NaN\"",
                              "\"3000\"", "true", "null", "[3000, 4000]", "{}"}) {
      INFO(key << ": " << value);
      CHECK(ticket_complaints(std::string("{\"") + key + "\": " + value + "}").size() == 1);
    }
    CHECK(ticket_complaints(std::string("{\"") + key + "\": NaN}").size() == 1);
  }
  for (const char* key : {"exposure_ms", "bottom_exposure_ms", "lift_mm"})
    CHECK(ticket_complaints(std::string("{\"") + key + "\": 0}").size() == 1);
}

TEST_CASE("a ticket with adaptive layers cannot set exposures, which follow the thickness") {
  CHECK(ticket_complaints(R"({"exposure_ms": 3000, "adaptive_layers": {"cusp_um": 10}})") ==
        Complaints{"/exposure_ms: a ticket has either adaptive_layers, whose exposures follow the thickness, "
                   "or exposure_ms, not both"});
  CHECK(ticket_complaints(R"({"bottom_exposure_ms": 3000, "adaptive_layers": {"cusp_um": 10}})").size() == 1);
  CHECK(ticket_complaints(R"({"lift_mm": 7, "adaptive_layers": {"cusp_um": 10}})").empty());
}

TEST_CASE("a ticket cannot name a resin outside the resins folder") {
  for (const char* name : {"../x", "a/b", ".x", ""}) {
    CHECK(ticket_complaints(nlohmann::json{{"resin", name}}.dump()).size() == 1);
  }
}

TEST_CASE("a ticket that is missing or not an object is refused") {
  CHECK(ticket_complaints("[]") == Complaints{"expected an object, found an array"});
  CHECK(ticket_complaints("3") == Complaints{"expected an object, found 3"});
  CHECK(complaints_of([] { (void)load_job_ticket("/nonexistent/part.json"); }) ==
        Complaints{"there is no such file"});
}

TEST_CASE("ten mistakes in a ticket are reported in ten lines") {
  CHECK(ticket_complaints(
            R"({"resin": 1, "layer_height_um": "50", "rotation_deg": {"x": 400, "w": 1, "y": null},
                             "scale": true, "fit": true, "position_mm": {"z": 1}, "copies": -1, "copies": -1,
                             "colour": "red"})")
            .size() == 10);
}

Complaints complaints_about_plate(std::string_view text) {
  return complaints_of([&] { (void)load_plate(text); });
}

TEST_CASE("a plate's ticket lists its models, each with the keys of a model's ticket") {
  const JobTicket ticket = load_plate(R"({
    "resin": "tough", "adaptive_layers": {"cusp_um": 10}, "models": [
      {"file": "ring.stl", "position_mm": {"x": -10}, "scale": {"x": 1.01, "y": 1.02}},
      {"file": "pin.STL", "up": {"y": 1}, "copies": 4},
      {"file": "ring.stl", "rotation_deg": {"z": 90}}]})");
  CHECK(ticket.resin == "tough");
  CHECK(ticket.adaptive);
  REQUIRE(ticket.models.size() == 3);
  CHECK(ticket.models[0].file == "ring.stl");
  CHECK(ticket.models[0].position->x == Millimeters{-10});
  CHECK(ticket.models[0].position->y == Millimeters{0});
  CHECK(ticket.models[0].scale == Scale{1.01, 1.02, 1});
  CHECK(ticket.models[0].copies == 1);
  CHECK(ticket.models[1].up == Direction{0, 1, 0});
  CHECK(ticket.models[1].copies == 4);
  CHECK_FALSE(ticket.models[1].position);
  CHECK(ticket.models[2].rotation.z == 90);
}

TEST_CASE("a plate's mistakes are reported with the model's number, counted from 0") {
  CHECK(complaints_about_plate(R"({"models": [{"file": "a.stl"}, {"file": "b.stl", "copies": 0, "clour": 1},
                                               {"up": {"z": 0}, "scale": []}]})") ==
        Complaints{
            "/models/1/clour: there is no key \"clour\" here; the known keys are \"copies\", \"drain\", "
            "\"file\", \"hollow\", \"keep_clean\", \"model\", \"position_mm\", \"rotation_deg\", \"scale\", "
            "\"unit\", "
            "\"up\"",
            "/models/1/copies: 0 is less than the least allowed, 1",
            "/models/2/file: this key is missing: A model's file in the same folder: its name, without '/' "
            "and with no '.' at its start",
            "/models/2/scale: expected an object or a number, found an array",
            "/models/2/up: a direction must not be zero in x, y and z"});
  CHECK(complaints_about_plate(R"({"models": [{"file": "../a.stl"}]})").size() == 1);
  CHECK(complaints_about_plate(R"({"models": []})") ==
        Complaints{"/models: there are 0 in this list; it must have at least 1"});
  CHECK(complaints_about_plate(R"({"models": {}})") ==
        Complaints{"/models: expected a list, found an object"});
  CHECK(complaints_about_plate("{}").size() == 1);
  CHECK(complaints_about_plate("[]") == Complaints{"expected an object, found an array"});
  CHECK(complaints_about_plate(R"({"models": [3]})") == Complaints{"/models/0: expected an object, found 3"});
}

}  // namespace
}  // namespace contourd
