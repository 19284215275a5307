#include "hw/gpio/gpio_light_line.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hw/hardware_error.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

struct Wire {
  bool active = false;
  bool refuses_off = false, refuses_on = false;
  int sets = 0, cuts = 0;
  std::function<void()> before_on;  // called right before the line is on, in place of another thread
};

class FakeLine final : public CuttableLine {
 public:
  explicit FakeLine(Wire& wire) : wire_(wire) {}
  [[nodiscard]] bool set(bool active) noexcept override {
    ++wire_.sets;
    if (active ? wire_.refuses_on : wire_.refuses_off) return false;
    if (active && wire_.before_on) wire_.before_on();
    wire_.active = active;
    return true;
  }
  [[nodiscard]] bool cut() noexcept override {
    ++wire_.cuts;
    if (wire_.refuses_off) return false;
    wire_.active = false;
    return true;
  }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

 private:
  Wire& wire_;
};

struct Bench {
  Bench() {
    line.on_event([this](const MachineEvent& one) {
      events.push_back(one);
      line.off();  // like a print that ends
    });
  }
  void pass(Duration time) {
    bool over = false;
    const auto timer = clock.call_after(time, [&over] { over = true; });
    while (!over)
      clock.run_next();
  }

  VirtualClock clock;
  Wire wire;
  std::vector<MachineEvent> events;
  GpioLightLine line{std::make_unique<FakeLine>(wire), "line 24 of gpiochip0", clock};
};

}  // namespace

TEST_CASE("a light line that cannot be turned off is a fault, reported once and not from inside the call") {
  Bench bench;
  bench.line.on();
  bench.wire.refuses_off = true;
  bench.line.off();
  bench.line.off();  // again before the report
  CHECK(bench.events.empty());
  CHECK(bench.line.refusal() == "the light's line 24 of gpiochip0 cannot be set: the kernel refuses");
  bench.pass(10s);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
  CHECK(bench.events[0].what ==
        "the light may be on: the light's line 24 of gpiochip0 cannot be set: the kernel refuses");
}

TEST_CASE("turning a light line off is retried until it works, and on() is refused before") {
  Bench bench;
  bench.line.on();
  bench.wire.refuses_off = true;
  bench.line.off();
  bench.pass(10s);
  CHECK(bench.wire.sets > 10);
  CHECK_THROWS_AS(bench.line.on(), HardwareError);
  bench.wire.refuses_off = false;
  bench.pass(2s);
  CHECK_FALSE(bench.wire.active);
  CHECK(bench.line.refusal().empty());
  bench.wire.sets = 0;
  bench.pass(10s);
  CHECK(bench.wire.sets == 0);
  CHECK(bench.events.size() == 1);
  bench.line.on();
  CHECK(bench.wire.active);
  // The next refusal is reported again.
  bench.wire.refuses_off = true;
  bench.line.off();
  bench.pass(2s);
  CHECK(bench.events.size() == 2);
}

TEST_CASE("a light line that cannot be turned on is turned off, without a fault event") {
  Bench bench;
  bench.wire.refuses_on = true;
  CHECK_THROWS_AS(bench.line.on(), HardwareError);
  bench.pass(10s);
  CHECK(bench.events.empty());
  CHECK(bench.wire.sets == 2);
}

TEST_CASE("a light line that was cut is off and goes on only after its release") {
  Bench bench;
  bench.line.on();
  bench.line.cut(bench.clock.now());
  CHECK_FALSE(bench.wire.active);
  CHECK_THROWS_AS(bench.line.on(), LightInterlocked);
  bench.line.off();
  CHECK_THROWS_AS(bench.line.on(), LightInterlocked);
  CHECK_FALSE(bench.wire.active);
  bench.line.release();
  CHECK_FALSE(bench.wire.active);  // the release alone does not turn it on
  bench.line.on();
  CHECK(bench.wire.active);
  CHECK(bench.events.empty());
}

TEST_CASE("a light line that is cut while it is being turned on goes off, whichever comes first") {
  Bench bench;
  bench.wire.before_on = [&bench] { bench.line.cut(bench.clock.now()); };
  CHECK_THROWS_AS(bench.line.on(), LightInterlocked);
  CHECK_FALSE(bench.wire.active);
  CHECK(bench.wire.cuts == 1);
}

TEST_CASE("a light line that cannot be cut is a fault when the event loop turns it off") {
  Bench bench;
  bench.line.on();
  bench.wire.refuses_off = true;
  bench.line.cut(bench.clock.now());
  CHECK(bench.events.empty());
  bench.line.off();
  bench.pass(100ms);
  CHECK(bench.events.size() == 1);
}
