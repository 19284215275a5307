#include "hw/gpio/gpio_light_line.hpp"

#include "hw/hardware_error.hpp"
#include "tests/catch.hpp"
#include "tests/hw/virtual_time_fixture.hpp"

namespace {

struct LightWire {
  bool active = false;
  bool refuses_off = false, refuses_on = false;
  int sets = 0, cuts = 0;
  std::function<void()> before_on;  // called right before the line is on, in place of another thread
};

class FakeLine final : public CuttableLine {
 public:
  explicit FakeLine(LightWire& wire) : wire_(wire) {}
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
  LightWire& wire_;
};

struct LightLineFixture : testing::VirtualTimeFixture {
  LightLineFixture() {
    line.on_event([this](const MachineEvent& one) {
      events.push_back(one);
      line.off();  // like a print that ends
    });
  }
  LightWire wire;
  std::vector<MachineEvent> events;
  GpioLightLine line{std::make_unique<FakeLine>(wire), "line 24 of gpiochip0", clock};
};

}  // namespace

TEST_CASE_METHOD(
    LightLineFixture,
    "a light line that cannot be turned off is a fault, reported once and not from inside the call") {
  line.on();
  wire.refuses_off = true;
  line.off();
  line.off();  // again before the report
  CHECK(events.empty());
  CHECK(line.refusal() == "the light's line 24 of gpiochip0 cannot be set: the kernel refuses");
  pass(10s);
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == MachineEvent::Kind::Fault);
  CHECK(events[0].what ==
        "the light may be on: the light's line 24 of gpiochip0 cannot be set: the kernel refuses");
}

TEST_CASE_METHOD(LightLineFixture,
                 "turning a light line off is retried until it works, and on() is refused before") {
  line.on();
  wire.refuses_off = true;
  line.off();
  pass(10s);
  CHECK(wire.sets > 10);
  CHECK_THROWS_AS(line.on(), HardwareError);
  wire.refuses_off = false;
  pass(2s);
  CHECK_FALSE(wire.active);
  CHECK(line.refusal().empty());
  wire.sets = 0;
  pass(10s);
  CHECK(wire.sets == 0);
  CHECK(events.size() == 1);
  line.on();
  CHECK(wire.active);
  // The next refusal is reported again.
  wire.refuses_off = true;
  line.off();
  pass(2s);
  CHECK(events.size() == 2);
}

TEST_CASE_METHOD(LightLineFixture,
                 "a light line that cannot be turned on is turned off, without a fault event") {
  wire.refuses_on = true;
  CHECK_THROWS_AS(line.on(), HardwareError);
  pass(10s);
  CHECK(events.empty());
  CHECK(wire.sets == 2);
}

TEST_CASE_METHOD(LightLineFixture, "a light line that was cut is off and goes on only after its release") {
  line.on();
  line.cut(clock.now());
  CHECK_FALSE(wire.active);
  CHECK_THROWS_AS(line.on(), LightInterlocked);
  line.off();
  CHECK_THROWS_AS(line.on(), LightInterlocked);
  CHECK_FALSE(wire.active);
  line.release();
  CHECK_FALSE(wire.active);  // the release alone does not turn it on
  line.on();
  CHECK(wire.active);
  CHECK(events.empty());
}

TEST_CASE_METHOD(LightLineFixture,
                 "a light line that is cut while it is being turned on goes off, whichever comes first") {
  wire.before_on = [this] { line.cut(clock.now()); };
  CHECK_THROWS_AS(line.on(), LightInterlocked);
  CHECK_FALSE(wire.active);
  CHECK(wire.cuts == 1);
}

TEST_CASE_METHOD(LightLineFixture,
                 "a light line that cannot be cut is a fault when the event loop turns it off") {
  line.on();
  wire.refuses_off = true;
  line.cut(clock.now());
  CHECK(events.empty());
  line.off();
  pass(100ms);
  CHECK(events.size() == 1);
}
