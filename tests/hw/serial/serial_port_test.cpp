#include "hw/serial/serial_port.hpp"

#include <string>

#include "tests/catch.hpp"
#include "tests/hw/no_descriptors.hpp"
#include "tests/hw/refusal.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;

// Build machines have no serial port to themselves, and libserialport refuses ptys: these tests only cover
// failures before a port is open. The tests in a virtual machine have a null-modem pair.
namespace {

std::string refusal_of_port(const std::string& path) {
  testing::NoDescriptors watcher;
  return testing::refusal_of([&] { return SerialPort(path, 9600, watcher).descriptor(); });
}

}  // namespace

TEST_CASE("a serial port that does not exist is named, with those that do") {
  CHECK(refusal_of_port("/dev/ttyNone7") ==
        "the serial port /dev/ttyNone7 does not exist; " + serial_ports_there_are());
}

TEST_CASE("a file or a device that is not a serial port is distinguished from a missing one") {
  const testing::TemporaryFolder folder;
  const std::string file = folder.write("port", "");
  CHECK(refusal_of_port(file) ==
        "the serial port " + file + " is not a serial port; " + serial_ports_there_are());
  CHECK(refusal_of_port("/dev/null") ==
        "the serial port /dev/null is not a usable serial port; " + serial_ports_there_are());
}
