#include "hw/gpio/axis_threads.hpp"

#include <poll.h>
#include <sched.h>

#include <atomic>
#include <iostream>
#include <map>
#include <random>

#include "hw/gpio/gpio_axis.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/counting_line.hpp"
#include "tests/hw/gpio/pipe_input.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::CountingLine;
using testing::PipeInput;

namespace {

class SharedOutput final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool active) noexcept override {
    if (level_.exchange(active) != active && changed) changed(active);
    return true;
  }
  [[nodiscard]] bool level() const noexcept { return level_; }
  std::function<void(bool)> changed;  // called by the step thread

 private:
  std::atomic<bool> level_{false};
};

// An event loop with poll() that is sometimes a little late.
class PollLoop final : public Clock, public DescriptorWatcher {
 public:
  [[nodiscard]] TimePoint now() const override { return monotonic_now(); }
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override {
    return std::make_unique<Call>(*this, when, std::move(call));
  }
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override {
    return std::make_unique<Watched>(*this, fd, std::move(call));
  }

  void run_until(const std::function<bool()>& done) {
    while (!done())
      turn();
  }

 private:
  using Calls = std::multimap<TimePoint, std::shared_ptr<std::function<void()>>>;
  class Call final : public Timer {
   public:
    Call(PollLoop& loop, TimePoint when, std::function<void()> call)
        : loop_(loop), call_(std::make_shared<std::function<void()>>(std::move(call))) {
      loop_.calls_.emplace(when, call_);
    }
    ~Call() override {
      std::erase_if(loop_.calls_, [this](const auto& entry) { return entry.second == call_; });
    }

   private:
    PollLoop& loop_;
    std::shared_ptr<std::function<void()>> call_;
  };
  class Watched final : public Watch {
   public:
    Watched(PollLoop& loop, int fd, std::function<void()> call) : loop_(loop), fd_(fd) {
      loop_.watched_[fd] = std::make_shared<std::function<void()>>(std::move(call));
    }
    ~Watched() override { loop_.watched_.erase(fd_); }

   private:
    PollLoop& loop_;
    int fd_;
  };

  void turn() {
    std::vector<pollfd> waited;
    for (const auto& [fd, call] : watched_)
      waited.push_back({fd, POLLIN, 0});
    const bool woken = poll(waited.data(), waited.size(), 1) > 0;
    // Mostly as late as a contact takes to settle, so that a run's end and its cause come in one turn.
    const Duration late = woken && ++turns_ % 4 != 0 ? Duration{1ms} : Duration{0};
    for (const TimePoint start = now(); now() < start + late;) {
    }
    for (const pollfd& fd : waited) {
      const auto found = watched_.find(fd.fd);
      if (fd.revents == 0 || found == watched_.end()) continue;
      const auto call = found->second;
      (*call)();
    }
    if (calls_.empty() || calls_.begin()->first > now()) return;
    const auto call = calls_.begin()->second;
    calls_.erase(calls_.begin());
    (*call)();
  }

  Calls calls_;
  std::map<int, std::shared_ptr<std::function<void()>>> watched_;
  int turns_ = 0;
};

// 20,000 steps/s towards the switch, so that the steps are halted before the contact has settled.
GpioAxisConfig quick_config() {
  GpioAxisConfig config;
  config.microsteps_per_mm = 400;
  config.travel = Nanometers{10'000'000};
  config.homing_speed = MillimetersPerSecond{50};
  config.top_speed = config.homing_speed;
  config.acceleration = MillimetersPerSecondSquared{5'000};
  config.limit_switch.debounce = 100us;
  config.emergency_stop = GpioInputConfig{{"gpiochip0", "5", false}, LineBias::AsIs, 100us};
  return config;
}

// A motor, moved by the step thread, and a switch that is closed at 0 and below.
class Stage {
 public:
  Stage() {
    GpioAxis::Parts parts;
    auto step = std::make_unique<SharedOutput>(), direction = std::make_unique<SharedOutput>();
    auto limit = std::make_unique<PipeInput>(), emergency = std::make_unique<PipeInput>();
    step->changed = [this, up = direction.get(), contact = limit.get()](bool high) {
      if (!high) return;
      const int at = position_ += up->level() ? 1 : -1;
      contact->set(at <= 0);
    };
    emergency_ = emergency.get();
    parts.lines.step = std::move(step);
    parts.lines.direction = std::move(direction);
    parts.lines.inputs[static_cast<std::size_t>(AxisInput::LimitSwitch)] = std::move(limit);
    parts.lines.inputs[static_cast<std::size_t>(AxisInput::EmergencyStop)] = std::move(emergency);
    parts.start_threads = [](StepEngine& engine, AxisInputs& inputs) {
      return std::make_unique<RealtimeAxisThreads>(engine, inputs, 40);
    };
    axis_.emplace(loop, loop, quick_config(), std::move(parts));
  }

  GpioAxis& axis() { return *axis_; }
  void press(bool pressed) { emergency_->set(pressed); }
  // The motor's position in steps above the switch.
  [[nodiscard]] int position() const { return position_; }
  PollLoop loop;

 private:
  std::atomic<int> position_{600};
  PipeInput* emergency_ = nullptr;
  std::optional<GpioAxis> axis_;
};

// A step line whose steps keep the processor busy for too long; with the 100th step the switch closes.
class LaboriousLine final : public OutputLine {
 public:
  explicit LaboriousLine(PipeInput& contact) : contact_(contact) {}
  [[nodiscard]] bool set(bool active) noexcept override {
    if (active && ++rises == 100) contact_.set(true);
    for (const TimePoint start = monotonic_now(); monotonic_now() < start + 100us;) {
    }
    return true;
  }
  std::atomic<int> rises{0};

 private:
  PipeInput& contact_;
};

// While it exists, this thread and the threads that it creates share one processor.
class OneProcessor {
 public:
  OneProcessor() {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;
  ~OneProcessor() { sched_setaffinity(0, sizeof before_, &before_); }

 private:
  cpu_set_t before_{};
};

}  // namespace

TEST_CASE("After random calls at random times an axis' position is either true or unknown", "[threads]") {
  Stage stage;
  std::minstd_rand random(1);
  const auto below = [&random](int limit) {
    return static_cast<int>(random() % static_cast<unsigned>(limit));
  };
  int reached = 0;
  for (int round = 0; round < 40; ++round) {
    bool done = false;
    GpioAxis& axis = stage.axis();
    if (!axis.height()) {
      axis.home([&](HomingResult) { done = true; });
    } else {
      axis.move_to(Nanometers{below(4'000) * 2'500}, MillimetersPerSecond{5.0 + below(45)},
                   [&](MoveResult result) { done = true, reached += result == MoveResult::Reached ? 1 : 0; });
    }
    std::unique_ptr<Timer> event;
    const Duration when = std::chrono::microseconds{below(150'000)};
    const int what = below(6);
    if (what == 0) event = stage.loop.call_after(when, [&] { axis.stop(); });
    if (what == 1) event = stage.loop.call_after(when, [&] { axis.abort(), done = true; });
    if (what == 2) event = stage.loop.call_after(when, [&] { stage.press(true), stage.press(false); });
    stage.loop.run_until([&] {
      (void)axis.height_at(monotonic_now() + 1ms);
      return done && !axis.moving();
    });
    event.reset();
    // A chattering emergency stop may not have settled yet.
    const TimePoint settled = monotonic_now() + 5ms;
    stage.loop.run_until([&] { return axis.why_not_ready().empty() && monotonic_now() > settled; });
    if (const auto height = axis.height()) REQUIRE(height->count() == stage.position() * 2'500);
  }
  CHECK(reached > 0);
}

TEST_CASE("An engine that is started, stopped, halted and inhibited at random makes the steps that it counts",
          "[threads]") {
  std::atomic<int> made{0};
  SharedOutput step, direction;
  step.changed = [&](bool high) { made += !high ? 0 : direction.level() ? 1 : -1; };
  PipeInput contact;
  StepEngine engine(step, direction, {});
  AxisInputs::Lines lines;
  lines.contacts[static_cast<std::size_t>(AxisInput::EmergencyStop)] = {&contact, 100us};
  AxisInputs inputs(engine, lines);
  std::minstd_rand random(2);
  const RealtimeAxisThreads threads(engine, inputs, 40);
  for (int round = 0; round < 300; ++round) {
    const auto steps = static_cast<std::int64_t>(random() % 400) - 200;
    engine.forget_halt();
    engine.start({steps, {20'000, 2'000'000}});
    const TimePoint until = monotonic_now() + std::chrono::microseconds{random() % 8'000};
    while (engine.moving() && monotonic_now() < until) {
      (void)engine.position_at(monotonic_now() + 100us);
      (void)inputs.take_change();
    }
    const auto what = random() % 5;
    if (what == 0) engine.stop();
    if (what == 1) engine.halt();
    if (what == 2) engine.inhibit();
    if (what == 3) contact.set(true);
    while (engine.moving())
      engine.ended().wait();
    engine.ended().clear();
    const StepEnd end = engine.last_end();
    REQUIRE(engine.position() == made);
    if (what == 4) REQUIRE(end == StepEnd::Completed);
    contact.set(false);
    while (inputs.active(AxisInput::EmergencyStop))
      (void)inputs.take_change();
    inputs.let_go();
    engine.enable();
  }
}

TEST_CASE("The threads make a move's steps, then the next move's, and end when destroyed", "[threads]") {
  CountingLine step, direction;
  StepEngine engine(step, direction, {});
  AxisInputs inputs(engine, {});
  {
    const RealtimeAxisThreads threads(engine, inputs, 50);
    for (const std::int64_t steps : {200, -150}) {
      const int before = step.rises;
      engine.start({steps, {20'000, 2'000'000}});
      while (engine.moving())
        engine.ended().wait();
      engine.ended().clear();
      CHECK(engine.last_end() == StepEnd::Completed);
      CHECK(step.rises - before == std::abs(steps));
    }
    engine.start({1'000'000, {1'000, 1'000'000}});
    while (engine.position() < 60)
      sched_yield();
    engine.halt();
    const int made = step.rises;
    while (engine.moving())
      engine.ended().wait();
    CHECK(engine.last_end() == StepEnd::Halted);
    CHECK(step.rises == made);
    CHECK(engine.position() == 50 + made - 350);
    engine.ended().clear();
    engine.forget_halt();
    engine.start({1'000'000, {1'000, 1'000'000}});  // the threads end during the move
  }
  CHECK_FALSE(engine.moving());
}

TEST_CASE("A switch halts the steps at the next one, even on a processor that they keep fully busy",
          "[threads]") {
  PipeInput contact;
  LaboriousLine step(contact);
  CountingLine direction;
  StepEngine engine(step, direction, {});
  AxisInputs::Lines lines;
  lines.contacts[static_cast<std::size_t>(AxisInput::LimitSwitch)] = {&contact, 5ms};
  AxisInputs inputs(engine, lines);
  const OneProcessor shared;
  const RealtimeAxisThreads threads(engine, inputs, 40);
  if (!threads.refusals().empty()) {
    std::cout << "SKIPPED: " << threads.refusals()[0] << '\n';
    return;
  }
  // Once the steps begin, no other thread runs on this processor.
  inputs.set_limit_rule(LimitRule::AtContact);
  engine.start({5'000, {20'000, 2'000'000}});
  while (engine.moving())
    engine.ended().wait();
  CHECK(engine.last_end() == StepEnd::Halted);
  CHECK(step.rises == 100);  // the step at which the switch closed
}

TEST_CASE("A refused priority is reported in a sentence, and the thread runs", "[threads]") {
  CountingLine step, direction;
  StepEngine engine(step, direction, {});
  const StepThread thread(engine, 1'000);  // the highest is 99
  REQUIRE_FALSE(thread.refusals().empty());
  CHECK(thread.refusals()[0].find("refuses real-time priority 1000 to the thread contourd-steps") !=
        std::string::npos);
  engine.start({10, {20'000, 2'000'000}});
  while (engine.moving())
    engine.ended().wait();
  CHECK(step.rises == 10);
}
