#include "hw/drm/connector.hpp"

#include "tests/catch.hpp"
#include "tests/hw/refusal.hpp"

namespace {

Connector connector_of(const std::string& name, Connector::Status status) {
  Connector connector;
  connector.name = name;
  connector.status = status;
  return connector;
}

const std::vector<CardOutputs> kTwoCards{
    {"/dev/dri/card0 (v3d)", {}},
    {"/dev/dri/card1 (vc4)",
     {connector_of("HDMI-A-1", Connector::Status::Disconnected),
      connector_of("HDMI-A-2", Connector::Status::Connected),
      connector_of("Composite-1", Connector::Status::Unknown)}},
    {"/dev/dri/card2 (udl)", {connector_of("HDMI-A-1", Connector::Status::Connected)}}};

}  // namespace

TEST_CASE("The first connected output is chosen") {
  const auto chosen = choose_output(kTwoCards, {});
  REQUIRE(chosen.has_value());
  CHECK(chosen->card == 1);
  CHECK(chosen->connector == 1);
}

TEST_CASE("If several cards have a connector of the wanted name, the connected one is chosen") {
  DrmDisplayConfig config;
  config.connector = "HDMI-A-1";
  const auto chosen = choose_output(kTwoCards, config);
  REQUIRE(chosen.has_value());
  CHECK(chosen->card == 2);
}

TEST_CASE("A connector of the wanted name is chosen even if its display is not known to be connected") {
  DrmDisplayConfig config;
  config.connector = "Composite-1";
  const auto chosen = choose_output(kTwoCards, config);
  REQUIRE(chosen.has_value());
  CHECK(chosen->connector == 2);
}

TEST_CASE("No output is chosen if no display is connected") {
  const std::vector<CardOutputs> dark{
      {"/dev/dri/card0 (vc4)", {connector_of("HDMI-A-1", Connector::Status::Disconnected)}}};
  CHECK_FALSE(choose_output(dark, {}).has_value());
}

TEST_CASE("A connector that does not exist is refused with a list of the connectors that do") {
  DrmDisplayConfig config;
  config.connector = "HDMI-A-7";
  CHECK(testing::refusal_of([&] { return choose_output(kTwoCards, config); }) ==
        "there is no connector HDMI-A-7; connectors: /dev/dri/card0 (v3d): no connector; "
        "/dev/dri/card1 (vc4): HDMI-A-1 (disconnected), HDMI-A-2 (connected), "
        "Composite-1 (connection unknown); /dev/dri/card2 (udl): HDMI-A-1 (connected)");
}
