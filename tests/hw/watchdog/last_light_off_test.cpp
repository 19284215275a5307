#include "hw/watchdog/last_light_off.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <string>

#include "hw/virtual_clock.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/catch.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

class NoDescriptors final : public DescriptorWatcher {
 public:
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int, std::function<void()>) override {
    return std::make_unique<Watch>();
  }
};

// The far end of a serial port.
struct Port {
  Port() {
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) == 0);
    near = FileDescriptor(ends[0]);
    far = FileDescriptor(ends[1]);
  }
  std::string heard() {
    char bytes[64];
    const ssize_t count = ::read(far.get(), bytes, sizeof bytes);
    return {bytes, static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
  }
  FileDescriptor near, far;
};

struct Bench {
  VirtualClock clock;
  NoDescriptors watcher;
  FileDescriptor process;
  LightWatchdog watchdog = testing::ready_watchdog(clock, watcher, process);
};

}  // namespace

TEST_CASE("The last light off goes to the port that was last given to the light watchdog") {
  Bench bench;
  Port first, second;
  bench.watchdog.set_serial({first.near.get(), "OFF\r", 100ms});
  last_light_off().light_off();
  CHECK(first.heard() == "OFF\r");
  bench.watchdog.set_serial({second.near.get(), "DARK\r", 100ms});
  last_light_off().light_off();
  CHECK(first.heard().empty());
  CHECK(second.heard() == "DARK\r");
  bench.watchdog.set_serial({});
  last_light_off().light_off();
  CHECK(second.heard().empty());
}

TEST_CASE("The last light off goes nowhere once there is no light watchdog any more") {
  Port port;
  {
    Bench bench;
    bench.watchdog.set_serial({port.near.get(), "OFF\r", 100ms});
  }
  last_light_off().light_off();
  last_light_off().display_black();
  CHECK(port.heard().empty());
}

TEST_CASE("The last light off allocates no memory, and does not wait for a port that takes no more") {
  Bench bench;
  Port port;
  const std::string kilobyte(1024, 'x');
  while (::write(port.near.get(), kilobyte.data(), kilobyte.size()) > 0) {
  }
  bench.watchdog.set_serial({port.near.get(), "OFF\r", 100ms});
  const long before = testing::allocations();
  last_light_off().light_off();
  CHECK(testing::allocations() == before);
}
