#include "hw/drm/uevent_socket.hpp"

#include <sys/sysmacros.h>

#include "tests/catch.hpp"

namespace {

// Joins the fields as the kernel sends them: each ended by a zero byte.
std::string fields(std::initializer_list<const char*> texts) {
  std::string all;
  for (const char* text : texts)
    all += std::string(text) + '\0';
  return all;
}

}  // namespace

TEST_CASE("An announcement is parsed into its card, its connector, and whether a display's state changed") {
  const auto plugged =
      display_change(fields({"change@/devices/platform/gpu/drm/card1", "ACTION=change",
                             "DEVPATH=/devices/platform/gpu/drm/card1", "SUBSYSTEM=drm", "HOTPLUG=1",
                             "CONNECTOR=32", "MAJOR=226", "MINOR=1", "DEVNAME=dri/card1", "SEQNUM=2211"}));
  REQUIRE(plugged);
  CHECK(plugged->card == makedev(226, 1));
  CHECK(plugged->connector == 32U);
  CHECK(plugged->of_state);

  const auto removed =
      display_change(fields({"remove@/devices/x/drm/card1", "ACTION=remove", "SUBSYSTEM=drm"}));
  REQUIRE(removed);
  CHECK_FALSE(removed->card);
  CHECK_FALSE(removed->connector);
  CHECK(removed->of_state);
}

TEST_CASE("A change event without HOTPLUG, as udevadm triggers it, is no change of state") {
  const auto change = display_change(
      fields({"change@/devices/x/drm/card0", "ACTION=change", "SUBSYSTEM=drm", "MAJOR=226", "MINOR=0"}));
  REQUIRE(change);
  CHECK_FALSE(change->of_state);
  CHECK_FALSE(concerns(*change, makedev(226, 0), 32));
}

TEST_CASE("Announcements about other devices and truncated ones are ignored") {
  CHECK_FALSE(display_change(fields({"add@/devices/usb1/drm", "ACTION=add", "SUBSYSTEM=usb"})));
  CHECK_FALSE(display_change(fields({"x", "NOTE=SUBSYSTEM=drm"})));
  CHECK_FALSE(display_change(std::string("change@/devices/x")));
  CHECK_FALSE(display_change({}));
  CHECK(display_change(std::string("SUBSYSTEM=drm")));  // the last zero byte is missing
}

TEST_CASE("A malformed number counts as a missing one") {
  const auto change = display_change(
      fields({"SUBSYSTEM=drm", "HOTPLUG=1", "CONNECTOR=3x", "MAJOR=226", "MINOR=", "MINOR=99999999999"}));
  REQUIRE(change);
  CHECK_FALSE(change->connector);
  CHECK_FALSE(change->card);
}

TEST_CASE("A change concerns the connector and card that it names, or all if it names none") {
  const dev_t card = makedev(226, 1);
  const DisplayChange any{.card = {}, .connector = {}, .of_state = true};
  CHECK(concerns(any, card, 32));
  CHECK(concerns({.card = card, .connector = {}, .of_state = true}, card, 32));
  CHECK(concerns({.card = card, .connector = 32, .of_state = true}, card, 32));
  CHECK_FALSE(concerns({.card = card, .connector = 33, .of_state = true}, card, 32));
  CHECK_FALSE(concerns({.card = makedev(226, 0), .connector = 32, .of_state = true}, card, 32));
  CHECK_FALSE(concerns({.card = card, .connector = 32, .of_state = false}, card, 32));
}

TEST_CASE("A socket for announcements opens without privileges and is empty at first") {
  UeventSocket socket;
  CHECK(socket.fd() >= 0);
  (void)socket.read_all();  // drops announcements of this machine's own devices
  CHECK(socket.read_all().empty());
}
