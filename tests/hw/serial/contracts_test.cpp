// Tests that each header of hw/serial checks its preconditions.
#include "hw/serial/projector_light.hpp"
#include "hw/serial/reply_pattern.hpp"
#include "hw/serial/serial_projector.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/hw/serial/projector_tables.hpp"
#include "tests/hw/serial/scripted_channel.hpp"

using namespace contourd;
using testing::contract_broken_by;

namespace {

struct ProjectorLightFixture {
  explicit ProjectorLightFixture(ProjectorTable projector_table) : table(std::move(projector_table)) {}
  VirtualClock clock;
  testing::ScriptedChannel channel{clock};
  ProjectorTable table;
  CommandExchange exchange{channel,
                           clock,
                           table,
                           {.sent = [](const ProjectorCommand&, TimePoint) {},
                            .unasked = [](const UnaskedLine&) {},
                            .lost = [](const std::string&) {}}};
  ProjectorLight light{exchange, clock, table, {[] { return TimePoint{}; }, {}}};
};

}  // namespace

TEST_CASE("ProjectorLight requires a table with a light, and darkness before light on") {
  ProjectorLightFixture dark(testing::text_table(false)), lit(testing::text_table());
  CHECK(contract_broken_by([&] { dark.light.turn_on(Duration{1}, {}); }) ==
        "the table has a light on and off");
  CHECK(contract_broken_by([&] { dark.light.turn_off(); }) == "the table has a light off");
  CHECK(contract_broken_by([&] { lit.light.turn_on(Duration{1}, {}); }).empty());
  lit.light.suspect();
  CHECK(contract_broken_by([&] { lit.light.turn_on(Duration{1}, {}); }) == "the light is known to be off");
}

TEST_CASE("A brightness must be within the range of a table that has one") {
  BrightnessCommand brightness;
  brightness.least = 91;
  brightness.most = 1023;
  CHECK(contract_broken_by([&] { (void)brightness.with(91); }).empty());
  for (const std::int32_t number : {90, 1024})
    CHECK(contract_broken_by([&] { (void)brightness.with(number); }) ==
          "the number is within the projector's range");
  VirtualClock clock;
  testing::ScriptedChannel channel{clock};
  CHECK(contract_broken_by([&] { SerialProjector(channel, clock, testing::text_table(), 100); }) ==
        "the table has a brightness, where one is to be sent");
}

TEST_CASE("A projector can only be confirmed dark if its table has a light off") {
  VirtualClock clock;
  testing::ScriptedChannel channel{clock};
  SerialProjector projector(channel, clock, testing::text_table(false));
  CHECK(contract_broken_by([&] { projector.confirm_dark([](ProjectorReply) {}); }) ==
        "the table has a light off");
}

TEST_CASE("A checksum can only be computed of a kind that has one") {
  CHECK(contract_broken_by([] { (void)checksum_of("abc", Checksum::SumAfterFirst); }).empty());
  CHECK(contract_broken_by([] { (void)checksum_of("abc", Checksum::None); }) == "there is a checksum");
}
