#include "daemon/prepare/supports_text.hpp"

#include "tests/catch.hpp"

namespace {

SupportContact contact(ContactCause cause, double z) {
  return {{1, -2, z}, {0, 0, -1}, cause, 0.25};
}

Supports some() {
  Supports supports;
  supports.contacts = {contact(ContactCause::Island, 1), contact(ContactCause::Overhang, 2),
                       contact(ContactCause::Overhang, 3), contact(ContactCause::Peel, 4)};
  supports.branches = 3;
  supports.feet = 1;
  supports.volume_mm3 = 330;
  return supports;
}

}  // namespace

TEST_CASE("The supports line counts contacts by cause, branches and feet") {
  Supports supports = some();
  CHECK(supports_line(counts_of(supports)) ==
        "4 contacts (1 at islands, 2 at overhangs, 1 against peel), 3 branches, 1 foot, 0.33 ml");
  supports.feet_on_models = 2;
  CHECK(supports_line(counts_of(supports)) ==
        "4 contacts (1 at islands, 2 at overhangs, 1 against peel), 3 branches, 1 foot, 2 on the model, 0.33 "
        "ml");
  SupportCounts counts = counts_of(supports);
  counts.unheld = 1;
  CHECK(supports_line(counts) ==
        "4 contacts (1 at islands, 2 at overhangs, 1 against peel), 3 branches, 1 foot, 2 on the model, 0.33 "
        "ml; 1 place "
        "not held");
  CHECK(supports_line({}) == "none needed");
  CHECK(supports_line({.carriers = 1}) == "none added: 1 model carries its own in its file");
  counts.carriers = 2;
  CHECK(supports_line(counts).ends_with(
      ", 0.33 ml; 2 models carry their own in their files; 1 place not held"));
  counts.over_gaps = 3;
  CHECK(supports_in_summary(supports_summary_json(counts)) == counts);
  CHECK(supports_line({.over_gaps = 1}) ==
        "0 contacts (0 at islands, 0 at overhangs, 0 against peel), 0 branches, 0 feet, 0.00 ml; 1 overhang "
        "over a narrow gap left");
}

TEST_CASE("The sentence about unheld places describes the first three") {
  std::vector<UnheldPlace> places{{contact(ContactCause::Island, 1), "no path leads to the plate"}};
  CHECK(unheld_sentence({}).empty());
  CHECK(unheld_sentence(places) ==
        "1 place cannot be held: at 1.00, -2.00 mm from the plate's centre, 1.00 mm above the plate (island, "
        "0.25 mm²): no path leads to the plate");
  places.resize(5, {contact(ContactCause::Peel, 2), "there is no room"});
  const std::string sentence = unheld_sentence(places);
  CHECK(sentence.find("5 places cannot be held: at 1.00") == 0);
  CHECK(sentence.find("(peel, 0.25 mm²): there is no room; and 2 more") != std::string::npos);
}

TEST_CASE("Supports that stay in the part are reported with the lowest place") {
  Supports supports;
  CHECK(supports_warnings(supports).empty());
  supports.on_hairs = {contact(ContactCause::Island, 1)};
  CHECK(
      supports_warnings(supports)[0] ==
      "1 support holds a part that is one pixel thick and may break off: at 1.00, -2.00 mm from the plate's "
      "centre, 1.00 mm above the plate; make the part thicker, or turn the model");
  CHECK(supports_json(supports)["on_hair_list"].size() == 1);
  supports.on_hairs.clear();
  supports.in_hollows = {contact(ContactCause::Overhang, 2)};
  supports.in_gaps = {contact(ContactCause::Island, 3), contact(ContactCause::Island, 4)};
  const std::vector<std::string> expected{
      "1 support stands in a sealed hollow and cannot be taken out: at 1.00, -2.00 mm from the plate's "
      "centre, "
      "2.00 mm above the plate; open the hollow, or turn the model",
      "2 supports fill gaps narrower than themselves and join both sides: the lowest at 1.00, -2.00 mm from "
      "the plate's centre, 3.00 mm above the plate; widen the gap, or turn the model"};
  CHECK(supports_warnings(supports) == expected);
  supports.over_gaps = {contact(ContactCause::Overhang, 5)};
  CHECK(supports_warnings(supports)[2] ==
        "1 overhang is not held over a gap narrower than a support, which would join both sides: at 1.00, "
        "-2.00 "
        "mm from the plate's centre, 5.00 mm above the plate; widen the gap, or turn the model");
  supports.unheld = {{contact(ContactCause::Island, 1), "there is no room"}};
  CHECK(supports_warnings(supports).size() == 4);
  CHECK(supports_warnings(supports)[0] == unheld_sentence(supports.unheld));
  CHECK(supports_json(supports)["in_hollow_list"].size() == 1);
  CHECK(supports_json(supports)["in_gap_list"][1]["plate_mm"][2] == 4.0);
}

TEST_CASE("The JSON of supports lists every contact and every unheld place") {
  Supports supports = some();
  supports.unheld = {{contact(ContactCause::Island, 9), "no way"}};
  const auto json = supports_json(supports);
  CHECK(json["contacts"] == 4);
  CHECK(json["overhangs"] == 2);
  CHECK(json["unheld"] == 1);
  CHECK(json["contact_list"].size() == 4);
  CHECK(json["contact_list"][3]["cause"] == "peel");
  CHECK(json["contact_list"][3]["plate_mm"] == nlohmann::ordered_json{1.0, -2.0, 4.0});
  CHECK(json["unheld_list"][0]["why"] == "no way");
  CHECK(support_settings_json(SupportSettings{})["tip_holds_mm2"] == 11.1);
}
