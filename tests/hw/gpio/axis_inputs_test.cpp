// Tests of AxisInputs: the calls of the input thread, made in one thread with the test's own clock.
#include "hw/gpio/axis_inputs.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/counting_line.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/test_time.hpp"
#include "tests/random_shapes.hpp"

namespace {

class Lamp final : public LightCutoff {
 public:
  void cut(TimePoint) noexcept override {
    ++cuts;
    cut_ = true;
  }
  void release() noexcept override { cut_ = false; }
  [[nodiscard]] bool is_cut() const { return cut_; }
  int cuts = 0;

 private:
  bool cut_ = false;
};

constexpr Duration kInputDebounce = 5ms;

struct InputsFixture {
  InputsFixture() { build(); }
  void build() {
    AxisInputs::Lines lines;
    lines.contacts[0] = {&limit, kInputDebounce};
    lines.contacts[static_cast<std::size_t>(AxisInput::EmergencyStop)] = {&stop, kInputDebounce};
    lines.contacts[static_cast<std::size_t>(AxisInput::Lid)] = {&lid, kInputDebounce};
    inputs.emplace(engine, lines, testing::test_now);
    inputs->set_light_cutoff(&lamp);
    next = inputs->serve();
  }
  // serve() is the input thread after an edge; pass() calls it when it is due.
  void serve() { next = inputs->serve(); }
  void pass(Duration time) {
    const TimePoint end = test_time + time;
    while (next && *next <= end) {
      test_time = std::max(test_time, *next);
      serve();
    }
    test_time = end;
  }
  void set(testing::PlantInput& input, bool level) {
    input.set(level, test_time);
    serve();
  }
  // Takes the changes like the event loop, which calls let_go() when an input is safe again.
  std::vector<InputChange> told() {
    std::vector<InputChange> all;
    while (const auto change = inputs->take_change()) {
      all.push_back(*change);
      if (change->to == SafetyState::Safe) inputs->let_go();
    }
    return all;
  }
  [[nodiscard]] bool active(AxisInput which) const { return inputs->active(which); }

  testing::CountingLine step, direction;
  testing::PlantInput limit, stop, lid;
  Lamp lamp;
  StepEngine engine{step, direction, {}, testing::test_now};
  std::optional<AxisInputs> inputs;
  std::optional<TimePoint> next;
};

std::vector<SafetyState> states_of(const std::vector<InputChange>& changes, AxisInput which) {
  std::vector<SafetyState> states;
  for (const InputChange& change : changes) {
    if (change.which == which) states.push_back(change.to);
  }
  return states;
}
using States = std::vector<SafetyState>;

}  // namespace

TEST_CASE_METHOD(InputsFixture,
                 "The light is cut at the first edge of either safety input and released after let_go()") {
  const bool by_lid = GENERATE(false, true);
  testing::PlantInput& wire = by_lid ? lid : stop;
  set(wire, true);
  CHECK(lamp.is_cut());
  pass(100ms);
  CHECK(engine.inhibited() == !by_lid);
  set(wire, false);
  pass(kInputDebounce - 1ns);
  (void)told();
  CHECK(lamp.is_cut());
  pass(1ns);
  CHECK(lamp.is_cut());  // until the change has been taken
  CHECK(told().size() == 1);
  CHECK_FALSE(lamp.is_cut());
  CHECK_FALSE(engine.inhibited());
}

TEST_CASE_METHOD(
    InputsFixture,
    "Chatter at 125 Hz keeps the light cut from its first edge until a debounce time after its end") {
  for (int i = 0; i < 29 * 125; ++i) {
    for (const bool level : {true, false}) {
      set(stop, level);
      REQUIRE(lamp.is_cut());
      pass(4ms);
      (void)told();
      REQUIRE(lamp.is_cut());
    }
  }
  pass(1ms);
  CHECK(told().back().to == SafetyState::Safe);
  CHECK_FALSE(lamp.is_cut());
}

TEST_CASE_METHOD(InputsFixture,
                 "The light is cut a second time, in case it was just being turned on at the first cut") {
  set(stop, true);
  const int cuts = lamp.cuts;
  pass(3ms);
  CHECK(lamp.cuts > cuts);
}

TEST_CASE_METHOD(InputsFixture, "The light is cut until both safety inputs are safe") {
  set(stop, true);
  set(lid, true);
  pass(1ms);
  set(stop, false);
  pass(100ms);
  CHECK(states_of(told(), AxisInput::EmergencyStop) == States{SafetyState::Debouncing, SafetyState::Safe});
  CHECK(lamp.is_cut());
  set(lid, false);
  pass(100ms);
  (void)told();
  CHECK_FALSE(lamp.is_cut());
}

TEST_CASE_METHOD(InputsFixture,
                 "An input that is unsafe again before its changes are taken stays cut and inhibited") {
  set(stop, true);
  pass(100ms);
  set(stop, false);
  pass(100ms);
  set(stop, true);
  pass(100ms);
  (void)told();  // includes the change to safe
  CHECK(lamp.is_cut());
  CHECK(engine.inhibited());
}

TEST_CASE_METHOD(InputsFixture,
                 "A safety input that is unsafe from the start cuts the light as soon as one is set") {
  lid.set(true, test_time);
  lamp.release();
  build();
  CHECK(active(AxisInput::Lid));
  CHECK(lamp.is_cut());
  CHECK_FALSE(engine.inhibited());
  Lamp other;
  inputs->set_light_cutoff(&other);
  CHECK(other.is_cut());
}

TEST_CASE_METHOD(InputsFixture,
                 "A light that was cut before its inputs were reopened is released if they are safe") {
  Lamp other;
  other.cut(test_time);
  inputs->set_light_cutoff(&other);
  CHECK_FALSE(other.is_cut());
  inputs->set_light_cutoff(nullptr);
  set(stop, true);
  CHECK_FALSE(other.is_cut());
  CHECK(other.cuts == 1);
}

TEST_CASE_METHOD(
    InputsFixture,
    "A lost edge of a safety input is found by its level within 20 ms, even while nothing moves") {
  stop.loses_edges = true;
  pass(1s);
  stop.set(true, test_time);
  pass(20ms);
  CHECK(lamp.is_cut());
  pass(kInputDebounce);
  CHECK(engine.inhibited());
}

TEST_CASE_METHOD(InputsFixture,
                 "A safety input that cannot be read is unsafe, and safe again when it can be read") {
  lid.unreadable = true;
  pass(20ms);
  CHECK(lamp.is_cut());
  CHECK(active(AxisInput::Lid));
  CHECK_FALSE(inputs->readable(AxisInput::Lid));
  const auto changes = told();
  REQUIRE(changes.size() >= 1);
  CHECK(changes[0].to == SafetyState::Debouncing);
  CHECK_FALSE(changes[0].readable);
  lid.unreadable = false;
  pass(100ms);
  CHECK(told().back().to == SafetyState::Safe);
  CHECK_FALSE(lamp.is_cut());
  CHECK_FALSE(inputs->lost());
}

TEST_CASE_METHOD(InputsFixture, "An emergency stop that stays unreadable inhibits the steps") {
  stop.unreadable = true;
  pass(20ms + kInputDebounce);
  CHECK(engine.inhibited());
  CHECK(states_of(told(), AxisInput::EmergencyStop) == States{SafetyState::Debouncing, SafetyState::Unsafe});
}

TEST_CASE_METHOD(InputsFixture,
                 "A limit switch that cannot be read loses all inputs: light cut, steps inhibited") {
  limit.unreadable = true;
  pass(20ms);
  CHECK(inputs->lost());
  CHECK(engine.inhibited());
  CHECK(lamp.is_cut());
  CHECK_FALSE(inputs->readable(AxisInput::LimitSwitch));
  inputs->let_go();
  CHECK(engine.inhibited());
  CHECK(lamp.is_cut());
}

TEST_CASE_METHOD(InputsFixture, "The loss of the chip cuts the light") {
  inputs->lose();
  CHECK(lamp.is_cut());
}

TEST_CASE("After random edges an input is unsafe until a debounce time of quiet, and changes come in order") {
  CHECK(rc::check([] {
    InputsFixture fixture;
    struct Truth {
      std::optional<TimePoint> first;  // first edge of the present burst
      TimePoint last{};
      bool level = false, lasted = false;
    };
    std::array<Truth, 2> truths;
    const std::array wires{&fixture.stop, &fixture.lid};
    const std::array inputs{AxisInput::EmergencyStop, AxisInput::Lid};
    std::array<States, 2> expected, seen;
    // Adds the changes that must have been reported by now.
    const auto settle = [&](std::size_t i, TimePoint now) {
      Truth& truth = truths[i];
      if (!truth.first) return;
      if (!truth.lasted && (truth.level ? now : truth.last) - *truth.first >= kInputDebounce) {
        truth.lasted = true;
        expected[i].push_back(SafetyState::Unsafe);
      }
      if (truth.level || now - truth.last < kInputDebounce) return;
      expected[i].push_back(SafetyState::Safe);
      truth = {};
    };
    for (int edge = 0; edge < 60; ++edge) {
      const auto i = static_cast<std::size_t>(draw(0, 1));
      Truth& truth = truths[i];
      // Many within the debounce time, some exactly at its end, some beyond it.
      fixture.pass(std::chrono::microseconds{draw(0, 4) == 0   ? 5'000
                                             : draw(0, 4) == 0 ? draw(0, 60'000)
                                                               : draw(0, 6'000)});
      settle(0, test_time);
      settle(1, test_time);
      truth.level = !truth.level;
      truth.last = test_time;
      if (!truth.first) {
        truth.first = test_time;
        expected[i].push_back(SafetyState::Debouncing);
      }
      fixture.set(*wires[i], truth.level);
      settle(i, test_time);
      RC_ASSERT(fixture.lamp.is_cut());  // at this edge
      for (const InputChange& change : fixture.told())
        seen[change.which == inputs[0] ? 0 : 1].push_back(change.to);
      for (std::size_t each = 0; each < 2; ++each) {
        RC_ASSERT(seen[each] == expected[each]);
        RC_ASSERT(fixture.active(inputs[each]) == truths[each].first.has_value());
      }
      RC_ASSERT(fixture.lamp.is_cut() == (truths[0].first || truths[1].first));
      RC_ASSERT(fixture.engine.inhibited() == truths[0].lasted);
    }
    RC_ASSERT(!fixture.inputs->lost());
  }));
}

TEST_CASE_METHOD(
    InputsFixture,
    "Changes that are not taken lose the inputs when the ring is full, and none is overwritten") {
  // Each burst gives two changes: Debouncing, then Safe.
  int bursts = 0;
  for (; !inputs->lost() && bursts < 1'000; ++bursts) {
    set(lid, true);
    set(lid, false);
    pass(2 * kInputDebounce);
  }
  REQUIRE(inputs->lost());
  CHECK(lamp.is_cut());
  CHECK(engine.inhibited());
  int taken = 0;
  for (; const auto change = inputs->take_change(); ++taken)
    CHECK(change->to == (taken % 2 == 0 ? SafetyState::Debouncing : SafetyState::Safe));
  CHECK(taken == 2 * (bursts - 1));
  // There is room again, but the inputs stay lost.
  set(lid, true);
  set(lid, false);
  pass(2 * kInputDebounce);
  CHECK(inputs->take_change());
  inputs->let_go();
  CHECK(inputs->lost());
  CHECK(lamp.is_cut());
  CHECK(engine.inhibited());
}

TEST_CASE_METHOD(InputsFixture, "A rule halts the steps once, and the cause is queued by then") {
  inputs->set_limit_rule(LimitRule::Beyond, -1);
  set(limit, true);
  pass(2 * kInputDebounce);
  REQUIRE(engine.interrupted());
  const auto changes = told();
  REQUIRE(changes.size() == 2);
  CHECK_FALSE(changes[0].halted);  // the switch has settled
  CHECK(changes[1].halted);
  engine.forget_halt();
  pass(100ms);
  CHECK_FALSE(engine.interrupted());
  CHECK(told().empty());
}

TEST_CASE_METHOD(InputsFixture, "All edges are counted, including one that the kernel lost") {
  set(lid, true);
  set(lid, false);
  set(limit, true);
  lid.loses_edges = true;
  lid.set(true, test_time);
  pass(100ms);  // levels are read
  CHECK(inputs->edges(AxisInput::Lid) == 3);
  CHECK(inputs->edges(AxisInput::LimitSwitch) == 1);
  CHECK(inputs->edges(AxisInput::EmergencyStop) == 0);
}
