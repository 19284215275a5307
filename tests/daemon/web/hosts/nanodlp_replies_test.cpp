#include "daemon/web/hosts/nanodlp_replies.hpp"

#include "tests/catch.hpp"

using namespace contourd::web;

namespace {

using Json = ControlLink::Json;

const Json kResins{{"resins",
                    {{{"resin", "standard"},
                      {"is_default", true},
                      {"trouble", nullptr},
                      {"layer_height_um", 50.0},
                      {"exposure_ms", 3000.0},
                      {"bottom_exposure_ms", 30000.0},
                      {"bottom_layers", 5},
                      {"lift_mm", 3.5}},
                     {{"resin", "broken"}, {"is_default", false}, {"trouble", "no such file"}}}}};

}  // namespace

TEST_CASE("A status of NanoDLP has whole numbers where its clients need them") {
  HostStatus status{.printer = "Big one", .phase = HostPhase::Printing, .text = "exposing"};
  status.job = HostJob{.name = "gear", .file = "gear", .is_printing = true};
  status.layer = 2;
  status.layers = 200;
  status.height_mm = 0.1;
  status.time_left_s = 61.6;
  const Json reply = nanodlp_status(status, "1.2.3");
  for (const char* key : {"State", "LayerID", "LayersCount", "PlateID", "CurrentHeight", "TimeRemain"})
    CHECK(reply[key].is_number_integer());
  CHECK(reply["CurrentHeight"] == 640);
  CHECK(reply["TimeRemain"] == 62);
  // One percent would be taken for the whole.
  CHECK(reply["Progress"] == 0.01);
  CHECK(reply["State"] == 5);
  CHECK(reply["Name"] == "Big one");
  CHECK_FALSE(reply.contains("PrevLayerTime"));
}

TEST_CASE("A printer that does nothing has no plate and no layers") {
  const Json reply = nanodlp_status({.printer = "p", .text = "idle"}, "1.2.3");
  CHECK(reply["State"] == 0);
  CHECK(reply["Printing"] == false);
  for (const char* key : {"PlateID", "LayerID", "LayersCount", "CurrentHeight", "Progress"})
    CHECK_FALSE(reply.contains(key));
}

TEST_CASE("A plate has figures once it is checked") {
  HostJob job{.name = "gear", .file = "gear.nanodlp", .state = "unchecked", .bytes = 5};
  Json plate = nanodlp_plates({job})[0];
  CHECK(plate["PlateID"] == id_of("gear"));
  CHECK_FALSE(plate.contains("LayersCount"));
  job.layers = 200;
  job.layer_um = 50;
  job.print_time_s = 3661.7;
  plate = nanodlp_plates({job})[0];
  CHECK(plate["LayersCount"] == 200);
  CHECK(plate["LayerThickness"] == 50);
  CHECK(plate["PrintTime"] == 3662);
  CHECK(nanodlp_plates({}).dump() == "[]");
}

TEST_CASE("Usable resins are locked profiles, found by their numbers") {
  const Json profiles = nanodlp_profiles(kResins);
  REQUIRE(profiles.size() == 1);
  CHECK(profiles[0]["Title"] == "standard");
  CHECK(profiles[0]["locked"] == true);
  CHECK(profiles[0]["CureTime"] == 3);
  CHECK(profiles[0]["SupportLayerNumber"] == 5);
  CHECK(nanodlp_machine("p", kResins)["DefaultProfile"] == id_of("standard"));
  CHECK(nanodlp_resin(kResins, std::to_string(id_of("standard"))) == "standard");
  for (const std::string& number : {std::to_string(id_of("broken")), std::string("0"),
                                    std::string("standard"), std::string(), std::string("1 ")})
    CHECK_FALSE(nanodlp_resin(kResins, number));
}
