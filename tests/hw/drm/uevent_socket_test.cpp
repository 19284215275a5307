#include "hw/drm/uevent_socket.hpp"

#include <string>

#include "tests/catch.hpp"

using namespace contourd;

namespace {

// Fields as the kernel sends them: each ended by a zero byte.
std::string fields(std::initializer_list<const char*> texts) {
  std::string all;
  for (const char* text : texts)
    all += std::string(text) + '\0';
  return all;
}

}  // namespace

TEST_CASE("An announcement of a graphics card is about displays") {
  CHECK(is_about_displays(fields({"change@/devices/platform/gpu/drm/card1", "ACTION=change",
                                  "DEVPATH=/devices/platform/gpu/drm/card1", "SUBSYSTEM=drm", "HOTPLUG=1",
                                  "CONNECTOR=32", "DEVNAME=dri/card1", "SEQNUM=2211"})));
  CHECK(is_about_displays(fields({"remove@/devices/x/drm/card1", "ACTION=remove", "SUBSYSTEM=drm"})));
}

TEST_CASE("Other announcements are not, nor is half a one") {
  CHECK_FALSE(is_about_displays(fields({"add@/devices/usb1/drm", "ACTION=add", "SUBSYSTEM=usb"})));
  CHECK_FALSE(is_about_displays(fields({"x", "NOTE=SUBSYSTEM=drm"})));
  CHECK_FALSE(is_about_displays(std::string("change@/devices/x")));
  CHECK_FALSE(is_about_displays({}));
  CHECK(is_about_displays(std::string("SUBSYSTEM=drm")));  // the last zero byte is missing
}

TEST_CASE("A socket for announcements opens without privileges and has nothing to read at first") {
  UeventSocket socket;
  CHECK(socket.fd() >= 0);
  (void)socket.read_all();  // what the machine did meanwhile
  CHECK_FALSE(socket.read_all());
}
