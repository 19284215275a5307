#include "hw/watchdog/last_light_off.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include "hw/gpio/step_engine.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/counting_line.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

namespace {

// The far end of a serial port.
struct Port {
  Port() { std::tie(near, far) = testing::socket_pair(SOCK_STREAM | SOCK_NONBLOCK); }
  std::string heard() {
    char bytes[64];
    const ssize_t count = ::read(far.get(), bytes, sizeof bytes);
    return {bytes, static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
  }
  FileDescriptor near, far;
};

// A clock that is far past the next due step at every call.
TimePoint later() noexcept {
  static TimePoint time{};
  return time += std::chrono::milliseconds{5};
}

// Runs in a child process, because every step engine of a process stands still from then on.
void check_still(int steps_before) {
  testing::CountingLine step, direction;
  StepEngine engine(step, direction, {}, later);
  engine.start({100, {10, 1'000}});
  expects(engine.begin(), "the move begins");
  while (step.rises < steps_before)
    engine.act();
  make_safe_at_once();
  expects(engine.interrupted() && engine.running(), "the thread is woken");
  while (engine.running())
    engine.act();
  expects(step.rises == steps_before, "no further step is made");
  expects(engine.last_end() == StepEnd::Halted, "the move was halted");
  engine.enable();
  engine.forget_halt();
  engine.start({100, {10, 1'000}});
  while (engine.begin() || engine.running())
    engine.act();
  expects(step.rises == steps_before, "no step of a later move is made");
}

}  // namespace

TEST_CASE_METHOD(testing::ReadyWatchdogFixture,
                 "The last light off goes to the port that was last given to the light watchdog") {
  Port first, second;
  watchdog.set_serial({first.near.get(), "OFF\r", 100ms});
  last_light_off().light_off();
  CHECK(first.heard() == "OFF\r");
  watchdog.set_serial({second.near.get(), "DARK\r", 100ms});
  last_light_off().light_off();
  CHECK(first.heard().empty());
  CHECK(second.heard() == "DARK\r");
  watchdog.set_serial({});
  last_light_off().light_off();
  CHECK(second.heard().empty());
}

TEST_CASE("The last light off goes nowhere once there is no light watchdog any more") {
  Port port;
  {
    testing::ReadyWatchdogFixture fixture;
    fixture.watchdog.set_serial({port.near.get(), "OFF\r", 100ms});
  }
  last_light_off().light_off();
  last_light_off().display_black();
  CHECK(port.heard().empty());
}

TEST_CASE_METHOD(testing::ReadyWatchdogFixture,
                 "The last light off allocates no memory, and does not wait for a port that takes no more") {
  Port port;
  const std::string kilobyte(1024, 'x');
  while (::write(port.near.get(), kilobyte.data(), kilobyte.size()) > 0) {
  }
  watchdog.set_serial({port.near.get(), "OFF\r", 100ms});
  const long before = testing::allocations();
  last_light_off().light_off();
  CHECK(testing::allocations() == before);
}

TEST_CASE("A motor that was made safe at once makes no further step of any move") {
  CHECK(testing::contract_broken_by([] { check_still(0); }).empty());
  CHECK(testing::contract_broken_by([] { check_still(7); }).empty());
}
