#include "daemon/prepare/print_findings.hpp"

#include "tests/catch.hpp"

namespace {

PrintFindings spoilt() {
  PrintFindings findings;
  findings.area_mm2 = {80, 0, 0, 81, 0, 7, 0, 6, 0, 5};
  findings.volume_mm3 = 1234.5;
  findings.largest_area_mm2 = 81;
  findings.largest_area_layer = 3;
  findings.empty_layers = {1, 2, 4, 6, 8};
  findings.islands = {
      {3, {1, 2}, {0.5, -1.25}, 2}, {5, {1, 2}, {1, 1}, 7}, {7, {1, 2}, {2, 2}, 5}, {9, {1, 2}, {3, 3}, 4}};
  findings.island_count = 40;
  findings.cracked_layers = {{2, {1, Millimeters{0.01}, 0}}, {3, {0, Millimeters{1.5}, 2}}};
  findings.cracks = {1, Millimeters{1.5}, 2};
  findings.layer_time = std::chrono::minutes{185};
  return findings;
}

}  // namespace

TEST_CASE("The findings line has layers, time, resin and the number of faults") {
  CHECK(findings_line(spoilt()) ==
        "10 layers in 3 h 05 min, 1.23 ml of resin, at most 81.00 mm² (layer 4), 40 islands, 5 empty layers");
  PrintFindings sound;
  sound.area_mm2 = {10};
  sound.largest_area_mm2 = 10;
  CHECK(findings_line(sound) ==
        "1 layer, 0.00 ml of resin, at most 10.00 mm² (layer 1), 0 islands, 0 empty layers");
}

TEST_CASE("A sound print has no warnings") {
  PrintFindings sound;
  sound.area_mm2 = {10, 10};
  sound.cracks.gaps_closed = 3;  // closed within the tolerance: a figure, not a warning
  CHECK(warnings_about(sound).empty());
}

TEST_CASE("Warnings name the largest islands, the empty layers and the open contours") {
  const auto warnings = warnings_about(spoilt());
  REQUIRE(warnings.size() == 3);
  CHECK(
      warnings[0] ==
      "40 islands begin with nothing under them: layer 6 at 1.00, 1.00 mm from the plate's centre (7 mm²), "
      "layer 8 at 2.00, 2.00 mm from the plate's centre (5 mm²), layer 10 at 3.00, 3.00 mm from the plate's "
      "centre (4 mm²), and 37 more");
  CHECK(warnings[1] == "layers 2 to 3, 5, 7 and 1 more are empty: nothing holds the layers above");
  CHECK(warnings[2] ==
        "the model is cracked: contours of 1 layer (4) did not close; the widest gap bridged is 1.500 mm");
}

TEST_CASE("A warning lists the layers named in its sentence and a label for them") {
  const auto warnings = findings_warnings(spoilt());
  REQUIRE(warnings.size() == 3);
  CHECK(warnings[0].mark == "island");
  CHECK(warnings[0].layers == std::vector<std::int32_t>{5, 7, 9});
  CHECK(warnings[1].mark == "empty");
  CHECK(warnings[1].layers == std::vector<std::int32_t>{1, 4, 6});
  CHECK(warnings[2].mark == "crack");
  CHECK(warnings[2].layers == std::vector<std::int32_t>{3});
}

TEST_CASE("Warnings of suction cups and resin traps have their layers, place, area and volume") {
  PrintFindings findings;
  findings.area_mm2 = {10, 10};
  findings.largest_area_mm2 = 10;
  findings.suction_cups = {{0, 19, 4, {1, 2}, {3.25, -2}, 81, 1234, true}};
  findings.suction_cup_count = 1;
  findings.resin_traps = {{4, 9, 6, {1, 2}, {0, 1}, 2, 3.5, false},
                          {11, 11, 11, {1, 2}, {5, 6}, 3, 800, false},
                          {12, 20, 14, {1, 2}, {7, 8}, 3, 20, false},
                          {13, 20, 14, {1, 2}, {9, 9}, 3, 10, false}};
  findings.resin_trap_count = 5;
  const auto warnings = findings_warnings(findings);
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0].sentence ==
        "1 suction cup pulls on the film until it opens or is closed: layers 1 to 20, at 3.25, -2.00 mm from "
        "the plate's centre in layer 5 (81 mm², 1.2 ml, closed by the plate)");
  CHECK(warnings[0].mark == "suction cup");
  CHECK(warnings[0].layers == std::vector<std::int32_t>{4});
  CHECK(warnings[1].sentence ==
        "5 closed hollows keep resin that cannot flow out: layer 12, at 5.00, 6.00 mm from the plate's "
        "centre in layer 12 (800 mm³), layers 13 to 21, at 7.00, 8.00 mm from the plate's centre in layer 15 "
        "(20 mm³), "
        "layers 14 to 21, at 9.00, 9.00 mm from the plate's centre in layer 15 (10 mm³), and 2 more");
  CHECK(warnings[1].mark == "resin trap");
  CHECK(warnings[1].layers == std::vector<std::int32_t>{11, 14});
  CHECK(findings_line(findings) ==
        "2 layers, 0.00 ml of resin, at most 10.00 mm² (layer 1), 0 islands, 0 empty layers, 1 suction cup, "
        "5 resin traps");
  const auto json = findings_json(findings);
  CHECK(json["suction_cups"] == 1);
  CHECK(json["resin_traps"] == 5);
  CHECK(json["resin_trap_list"].size() == 4);
  const auto& cup = json["suction_cup_list"][0];
  CHECK(cup["first_layer"] == 1);
  CHECK(cup["last_layer"] == 20);
  CHECK(cup["widest_layer"] == 5);
  CHECK(cup["plate_mm"][1] == -2);
  CHECK(cup["pixel"][0] == 1);
  CHECK(cup["area_mm2"] == 81);
  CHECK(cup["volume_mm3"] == 1234);
  CHECK(cup["on_plate"] == true);
}

TEST_CASE("Turned facets are a warning and a figure") {
  PrintFindings findings;
  findings.area_mm2 = {1, 1, 1};
  LayerCracks turned;
  turned.turned_chains = 2;
  findings.cracked_layers = {{1, turned}};
  findings.cracks = turned;
  const auto warnings = warnings_about(findings);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0] == "facets of 1 layer (2) are turned against the others; they were turned back");
  const auto json = findings_json(findings);
  CHECK(json["turned_chains"] == 2);
  CHECK(json["cracked_layer_list"][0]["turned_chains"] == 2);
}

TEST_CASE("One island and one empty layer are described in the singular") {
  PrintFindings findings;
  findings.area_mm2 = {1, 0, 1};
  findings.empty_layers = {1};
  findings.islands = {{2, {1, 2}, {0, 0}, 1}};
  findings.island_count = 1;
  const auto warnings = warnings_about(findings);
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0] ==
        "1 island begins with nothing under it: layer 3 at 0.00, 0.00 mm from the plate's centre (1 mm²)");
  CHECK(warnings[1] == "layer 2 is empty: nothing holds the layers above");
}

TEST_CASE("Empty layers at the top end the print") {
  PrintFindings findings;
  findings.area_mm2 = {1, 0, 1, 0, 0};
  findings.empty_layers = {1, 3, 4};
  CHECK(warnings_about(findings) ==
        std::vector<std::string>{"layer 2 is empty: nothing holds the layers above",
                                 "layers 4 to 5 are empty: the print ends below"});
}

TEST_CASE("A print without any light has one warning") {
  PrintFindings findings;
  findings.area_mm2 = {0};
  findings.empty_layers = {0};
  CHECK(warnings_about(findings) ==
        std::vector<std::string>{"all masks are dark (1 layer): nothing would be printed"});
  CHECK(warnings_about(PrintFindings{}).empty());
}

TEST_CASE("An island's area has no exponent however large or small it is") {
  const auto text_of_island = [](double area_mm2) {
    PrintFindings findings;
    findings.area_mm2 = {1, area_mm2};
    findings.islands = {{1, {1, 2}, {0, 0}, area_mm2}};
    findings.island_count = 1;
    const std::string text = warnings_about(findings).at(0);
    return text.substr(text.find('('));
  };
  CHECK(text_of_island(1800) == "(1800 mm²)");
  CHECK(text_of_island(12345.6) == "(12346 mm²)");
  CHECK(text_of_island(999.9) == "(1000 mm²)");
  CHECK(text_of_island(123.4) == "(123 mm²)");
  CHECK(text_of_island(0.0025) == "(0.0025 mm²)");
  // A grey value of 1 in a pixel of 10 um: 1/255 of its area.
  CHECK(text_of_island(3.92e-7) == "(less than 0.0001 mm²)");
}

TEST_CASE("Findings as JSON count layers from one") {
  const auto json = findings_json(spoilt());
  CHECK(json["layers"] == 10);
  CHECK(json["layer_time_s"] == 11100.0);
  CHECK(json["largest_area_layer"] == 4);
  CHECK(std::fabs(json["resin_ml"].get<double>() - 1.2345) < 1e-12);  // one division
  CHECK(json["islands"] == 40);
  CHECK(json["island_list"].size() == 4);
  CHECK(json["island_list"][0]["layer"] == 4);
  CHECK(json["island_list"][0]["plate_mm"][1] == -1.25);
  CHECK(json["empty_layer_list"] == nlohmann::ordered_json({2, 3, 5, 7, 9}));
  CHECK(json["cracked_layer_list"][1]["open_chains"] == 2);
  CHECK(json["warnings"].size() == 3);
  CHECK(findings_summary_json(PrintFindings{})["largest_area_layer"].is_null());
}
