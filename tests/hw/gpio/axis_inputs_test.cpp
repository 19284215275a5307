// Tests of AxisInputs: the calls of the input thread, made in one thread with the test's own clock.
#include "hw/gpio/axis_inputs.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <vector>

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::draw;

namespace {

TimePoint test_time{};  // global because AxisInputs takes a plain function

class IdleLine final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool) noexcept override { return true; }
};

class Wire final : public InputLine {
 public:
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  [[nodiscard]] std::optional<bool> level() noexcept override {
    return unreadable ? std::nullopt : std::optional(level_);
  }
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept override {
    const std::size_t count = std::min(edges.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, edges.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  void set(bool level) {
    if (level == level_) return;
    level_ = level;
    if (!loses_edges) waiting_.push_back({level, test_time});
  }
  bool unreadable = false, loses_edges = false;

 private:
  bool level_ = false;
  std::deque<LineEdge> waiting_;
};

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

constexpr Duration kDebounce = 5ms;

struct Bench {
  Bench() { build(); }
  void build() {
    AxisInputs::Lines lines;
    lines.contacts[0] = {&limit, kDebounce};
    lines.contacts[static_cast<std::size_t>(AxisInput::EmergencyStop)] = {&stop, kDebounce};
    lines.contacts[static_cast<std::size_t>(AxisInput::Lid)] = {&lid, kDebounce};
    inputs.emplace(engine, lines, []() noexcept { return test_time; });
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
  void set(Wire& wire, bool level) {
    wire.set(level);
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

  IdleLine step, direction;
  Wire limit, stop, lid;
  Lamp lamp;
  StepEngine engine{step, direction, {}, []() noexcept { return test_time; }};
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

TEST_CASE("The light is cut at the first edge of either safety input and released after let_go()") {
  Bench bench;
  const bool lid = GENERATE(false, true);
  Wire& wire = lid ? bench.lid : bench.stop;
  bench.set(wire, true);
  CHECK(bench.lamp.is_cut());
  bench.pass(100ms);
  CHECK(bench.engine.inhibited() == !lid);
  bench.set(wire, false);
  bench.pass(kDebounce - 1ns);
  (void)bench.told();
  CHECK(bench.lamp.is_cut());
  bench.pass(1ns);
  CHECK(bench.lamp.is_cut());  // until the change has been taken
  CHECK(bench.told().size() == 1);
  CHECK_FALSE(bench.lamp.is_cut());
  CHECK_FALSE(bench.engine.inhibited());
}

TEST_CASE("Chatter at 125 Hz keeps the light cut from its first edge until a debounce time after its end") {
  Bench bench;
  for (int i = 0; i < 29 * 125; ++i) {
    for (const bool level : {true, false}) {
      bench.set(bench.stop, level);
      REQUIRE(bench.lamp.is_cut());
      bench.pass(4ms);
      (void)bench.told();
      REQUIRE(bench.lamp.is_cut());
    }
  }
  bench.pass(1ms);
  CHECK(bench.told().back().to == SafetyState::Safe);
  CHECK_FALSE(bench.lamp.is_cut());
}

TEST_CASE("The light is cut a second time, in case it was just being turned on at the first cut") {
  Bench bench;
  bench.set(bench.stop, true);
  const int cuts = bench.lamp.cuts;
  bench.pass(3ms);
  CHECK(bench.lamp.cuts > cuts);
}

TEST_CASE("The light is cut until both safety inputs are safe") {
  Bench bench;
  bench.set(bench.stop, true);
  bench.set(bench.lid, true);
  bench.pass(1ms);
  bench.set(bench.stop, false);
  bench.pass(100ms);
  CHECK(states_of(bench.told(), AxisInput::EmergencyStop) ==
        States{SafetyState::Debouncing, SafetyState::Safe});
  CHECK(bench.lamp.is_cut());
  bench.set(bench.lid, false);
  bench.pass(100ms);
  (void)bench.told();
  CHECK_FALSE(bench.lamp.is_cut());
}

TEST_CASE("An input that is unsafe again before its changes are taken stays cut and inhibited") {
  Bench bench;
  bench.set(bench.stop, true);
  bench.pass(100ms);
  bench.set(bench.stop, false);
  bench.pass(100ms);
  bench.set(bench.stop, true);
  bench.pass(100ms);
  (void)bench.told();  // includes the change to safe
  CHECK(bench.lamp.is_cut());
  CHECK(bench.engine.inhibited());
}

TEST_CASE("A safety input that is unsafe from the start cuts the light as soon as one is set") {
  Bench bench;
  bench.lid.set(true);
  bench.lamp.release();
  bench.build();
  CHECK(bench.active(AxisInput::Lid));
  CHECK(bench.lamp.is_cut());
  CHECK_FALSE(bench.engine.inhibited());
  Lamp other;
  bench.inputs->set_light_cutoff(&other);
  CHECK(other.is_cut());
}

TEST_CASE("A light that was cut before its inputs were reopened is released if they are safe") {
  Bench bench;
  Lamp lamp;
  lamp.cut(test_time);
  bench.inputs->set_light_cutoff(&lamp);
  CHECK_FALSE(lamp.is_cut());
  bench.inputs->set_light_cutoff(nullptr);
  bench.set(bench.stop, true);
  CHECK_FALSE(lamp.is_cut());
  CHECK(lamp.cuts == 1);
}

TEST_CASE("A lost edge of a safety input is found by its level within 20 ms, even while nothing moves") {
  Bench bench;
  bench.stop.loses_edges = true;
  bench.pass(1s);
  bench.stop.set(true);
  bench.pass(20ms);
  CHECK(bench.lamp.is_cut());
  bench.pass(kDebounce);
  CHECK(bench.engine.inhibited());
}

TEST_CASE("A safety input that cannot be read is unsafe, and safe again when it can be read") {
  Bench bench;
  bench.lid.unreadable = true;
  bench.pass(20ms);
  CHECK(bench.lamp.is_cut());
  CHECK(bench.active(AxisInput::Lid));
  CHECK_FALSE(bench.inputs->readable(AxisInput::Lid));
  const auto told = bench.told();
  REQUIRE(told.size() >= 1);
  CHECK(told[0].to == SafetyState::Debouncing);
  CHECK_FALSE(told[0].readable);
  bench.lid.unreadable = false;
  bench.pass(100ms);
  CHECK(bench.told().back().to == SafetyState::Safe);
  CHECK_FALSE(bench.lamp.is_cut());
  CHECK_FALSE(bench.inputs->lost());
}

TEST_CASE("An emergency stop that stays unreadable inhibits the steps") {
  Bench bench;
  bench.stop.unreadable = true;
  bench.pass(20ms + kDebounce);
  CHECK(bench.engine.inhibited());
  CHECK(states_of(bench.told(), AxisInput::EmergencyStop) ==
        States{SafetyState::Debouncing, SafetyState::Unsafe});
}

TEST_CASE("A limit switch that cannot be read loses all inputs: light cut, steps inhibited") {
  Bench bench;
  bench.limit.unreadable = true;
  bench.pass(20ms);
  CHECK(bench.inputs->lost());
  CHECK(bench.engine.inhibited());
  CHECK(bench.lamp.is_cut());
  CHECK_FALSE(bench.inputs->readable(AxisInput::LimitSwitch));
  bench.inputs->let_go();
  CHECK(bench.engine.inhibited());
  CHECK(bench.lamp.is_cut());
}

TEST_CASE("The loss of the chip cuts the light") {
  Bench bench;
  bench.inputs->lose();
  CHECK(bench.lamp.is_cut());
}

TEST_CASE("After random edges an input is unsafe until a debounce time of quiet, and changes come in order") {
  CHECK(rc::check([] {
    Bench bench;
    struct Truth {
      std::optional<TimePoint> first;  // first edge of the present burst
      TimePoint last{};
      bool level = false, lasted = false;
    };
    std::array<Truth, 2> truths;
    const std::array wires{&bench.stop, &bench.lid};
    const std::array inputs{AxisInput::EmergencyStop, AxisInput::Lid};
    std::array<States, 2> expected, seen;
    // Adds the changes that must have been reported by now.
    const auto settle = [&](std::size_t i, TimePoint now) {
      Truth& truth = truths[i];
      if (!truth.first) return;
      if (!truth.lasted && (truth.level ? now : truth.last) - *truth.first >= kDebounce) {
        truth.lasted = true;
        expected[i].push_back(SafetyState::Unsafe);
      }
      if (truth.level || now - truth.last < kDebounce) return;
      expected[i].push_back(SafetyState::Safe);
      truth = {};
    };
    for (int edge = 0; edge < 60; ++edge) {
      const auto i = static_cast<std::size_t>(draw(0, 1));
      Truth& truth = truths[i];
      // Many within the debounce time, some exactly at its end, some beyond it.
      bench.pass(std::chrono::microseconds{draw(0, 4) == 0   ? 5'000
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
      bench.set(*wires[i], truth.level);
      settle(i, test_time);
      RC_ASSERT(bench.lamp.is_cut());  // at this edge
      for (const InputChange& change : bench.told())
        seen[change.which == inputs[0] ? 0 : 1].push_back(change.to);
      for (std::size_t each = 0; each < 2; ++each) {
        RC_ASSERT(seen[each] == expected[each]);
        RC_ASSERT(bench.active(inputs[each]) == truths[each].first.has_value());
      }
      RC_ASSERT(bench.lamp.is_cut() == (truths[0].first || truths[1].first));
      RC_ASSERT(bench.engine.inhibited() == truths[0].lasted);
    }
    RC_ASSERT(!bench.inputs->lost());
  }));
}

TEST_CASE("Changes that are not taken lose the inputs when the ring is full, and none is overwritten") {
  Bench bench;
  // Each burst gives two changes: Debouncing, then Safe.
  int bursts = 0;
  for (; !bench.inputs->lost() && bursts < 1'000; ++bursts) {
    bench.set(bench.lid, true);
    bench.set(bench.lid, false);
    bench.pass(2 * kDebounce);
  }
  REQUIRE(bench.inputs->lost());
  CHECK(bench.lamp.is_cut());
  CHECK(bench.engine.inhibited());
  int taken = 0;
  for (; const auto change = bench.inputs->take_change(); ++taken)
    CHECK(change->to == (taken % 2 == 0 ? SafetyState::Debouncing : SafetyState::Safe));
  CHECK(taken == 2 * (bursts - 1));
  // There is room again, but the inputs stay lost.
  bench.set(bench.lid, true);
  bench.set(bench.lid, false);
  bench.pass(2 * kDebounce);
  CHECK(bench.inputs->take_change());
  bench.inputs->let_go();
  CHECK(bench.inputs->lost());
  CHECK(bench.lamp.is_cut());
  CHECK(bench.engine.inhibited());
}

TEST_CASE("A rule halts the steps once, and the cause is queued by then") {
  Bench bench;
  bench.inputs->set_limit_rule(LimitRule::Beyond, -1);
  bench.set(bench.limit, true);
  bench.pass(2 * kDebounce);
  REQUIRE(bench.engine.interrupted());
  const auto told = bench.told();
  REQUIRE(told.size() == 2);
  CHECK_FALSE(told[0].halted);  // the switch has settled
  CHECK(told[1].halted);
  bench.engine.forget_halt();
  bench.pass(100ms);
  CHECK_FALSE(bench.engine.interrupted());
  CHECK(bench.told().empty());
}

TEST_CASE("All edges are counted, including one that the kernel lost") {
  Bench bench;
  bench.set(bench.lid, true);
  bench.set(bench.lid, false);
  bench.set(bench.limit, true);
  bench.lid.loses_edges = true;
  bench.lid.set(true);
  bench.pass(100ms);  // levels are read
  CHECK(bench.inputs->edges(AxisInput::Lid) == 3);
  CHECK(bench.inputs->edges(AxisInput::LimitSwitch) == 1);
  CHECK(bench.inputs->edges(AxisInput::EmergencyStop) == 0);
}
