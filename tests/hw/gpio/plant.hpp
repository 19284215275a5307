// A simulated stepper axis with its own clock: a screw with backlash, switches that bounce, a motor that may
// be dead, an encoder on the plate. It provides the lines, the threads and the event loop of a GpioAxis in
// one thread, so that tests are deterministic and never wait.
#pragma once

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hw/gpio/gpio_axis.hpp"
#include "hw/virtual_clock.hpp"

namespace contourd::testing {

// An input with a queue of edges. It has no descriptor: the plant calls the reader itself.
class PlantInput final : public InputLine {
 public:
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  [[nodiscard]] std::optional<bool> level() noexcept override {
    if (before_level) before_level();
    return unreadable ? std::nullopt : std::optional(level_);
  }
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept override {
    const std::size_t count = std::min(edges.size(), edges_.size());
    std::copy_n(edges_.begin(), count, edges.begin());
    edges_.erase(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

  void set(bool level, TimePoint at) {
    if (level == level_) return;
    level_ = level;
    if (loses_edges) return;
    edges_.push_back({level, at});
    if (changed) changed();
  }
  // A pulse that is too short to be seen: two edges to the present level.
  void spike(TimePoint at) {
    edges_.insert(edges_.end(), 2, {level_, at});
    if (changed) changed();
  }
  bool loses_edges = false, unreadable = false;
  std::function<void()> changed;
  std::function<void()> before_level;  // called in level() before the level is read

 private:
  bool level_ = false;
  std::deque<LineEdge> edges_;
};

class PlantOutput final : public CuttableLine {
 public:
  [[nodiscard]] bool set(bool active) noexcept override {
    if (refuses) return false;
    if (active != level && changed) changed(active);
    level = active;
    return true;
  }
  [[nodiscard]] bool cut() noexcept override { return set(false); }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  bool level = false, refuses = false;
  std::function<void(bool)> changed;
};

// The time that a VirtualClock's calls and the steps share; global because the engine takes a plain function.
inline VirtualClock* plant_clock = nullptr;
inline TimePoint plant_now() noexcept {
  return plant_clock->now();
}

class Plant : public DescriptorWatcher {
 public:
  struct Switch {
    std::int64_t at = 0;          // closed from this plate position on, away from the middle of the travel
    std::int64_t hysteresis = 0;  // the switch opens this many steps later
    int bounces = 0;              // number of bounces before it rests
    Duration bounce{0};           // time between bounces
    std::optional<bool> stuck;    // if set, the switch keeps this level
  };

  explicit Plant(GpioAxisConfig axis_config) : config(std::move(axis_config)) {
    second.at = 1'000'000'000;
    plant_clock = &clock;
  }
  ~Plant() override {
    axis.reset();
    plant_clock = nullptr;
  }

  // Builds an axis on this plant in its present state; may be called again after the previous axis is
  // destroyed.
  GpioAxis& build() {
    plate_ = motor;
    lines = {};
    for (auto& input : inputs_) {
      if (!input) input = std::make_unique<PlantInput>();
    }
    update_switches();
    GpioAxis::Parts parts;
    step = new PlantOutput, direction = new PlantOutput;
    parts.lines.step.reset(step);
    parts.lines.direction.reset(direction);
    if (config.enable) parts.lines.enable.reset(enable = new PlantOutput);
    step->changed = [this](bool high) { step_edge(high); };
    direction->changed = [this](bool) { direction_changed_at_ = clock.now(); };
    const bool fitted[kAxisInputs] = {true,
                                      config.second_switch.has_value(),
                                      config.emergency_stop.has_value(),
                                      config.lid.has_value(),
                                      config.power_fail.has_value(),
                                      config.force.has_value()};
    for (std::size_t i = 0; i < kAxisInputs; ++i) {
      lines[i] = inputs_[i].get();
      if (fitted[i]) parts.lines.inputs[i] = std::move(inputs_[i]);
    }
    if (config.encoder) {
      parts.lines.encoder_a.reset(encoder_a = new PlantInput);
      parts.lines.encoder_b.reset(encoder_b = new PlantInput);
      encoder_a->changed = encoder_b->changed = [this] { wake_inputs(); };
      if (config.encoder->index) {
        parts.lines.encoder_index.reset(encoder_index = new PlantInput);
        encoder_index->changed = encoder_a->changed;
      }
    }
    for (PlantInput* line : lines)
      line->changed = [this] { wake_inputs(); };
    parts.now = plant_now;
    parts.start_threads = [this](StepEngine& engine, AxisInputs& axis_inputs) {
      return std::make_unique<Threads>(*this, engine, axis_inputs);
    };
    axis = std::make_unique<GpioAxis>(loop != nullptr ? *loop : clock, *this, config, std::move(parts));
    axis->on_event([this](const MachineEvent& event) {
      events.push_back(event);
      if (on_event) on_event();
    });
    return *axis;
  }

  // Builds an axis and homes it.
  GpioAxis& build_homed() {
    build();
    if (home() != HomingResult::Homed) throw std::runtime_error("the plant's axis was not homed");
    return *axis;
  }

  // Runs until nothing is pending or `done` returns true.
  void run(const std::function<bool()>& done = [] { return false; }) {
    dispatch();
    while (!done() && clock.run_next())
      dispatch();
  }
  void run_for(Duration time) {
    bool over = false;
    const auto timer = clock.call_after(time, [&] { over = true; });
    run([&] { return over; });
  }

  // Runs the threads but not the event loop for `time`.
  void run_threads_for(Duration time) {
    loop_busy_ = true;
    run_for(time);
    loop_busy_ = false;
    dispatch();
  }

  std::optional<HomingResult> home() {
    std::optional<HomingResult> result;
    axis->home([&result](HomingResult r) { result = r; });
    run([&] { return result.has_value(); });
    return result;
  }
  std::optional<MoveResult> move_to(double mm, double speed = 5) {
    std::optional<MoveResult> result;
    axis->move_to(Nanometers{std::llround(mm * 1e6)}, MillimetersPerSecond{speed},
                  [&result](MoveResult r) { result = r; });
    run([&] { return result.has_value(); });
    return result;
  }
  std::optional<MoveResult> nudge(double mm) {
    std::optional<MoveResult> result;
    axis->nudge(Nanometers{std::llround(mm * 1e6)}, MillimetersPerSecond{1},
                [&result](MoveResult r) { result = r; });
    run([&] { return result.has_value(); });
    return result;
  }
  // Removes the chip with the inputs.
  void pull_chip() {
    inputs_engine_->lose();
    dispatch();
  }
  // Delays the step thread for `time`.
  void hold_up_steps(Duration time) { held_up_until_ = clock.now() + time; }
  // Delays the input thread for `time`; steps and bounces continue.
  void preempt_for(Duration time) {
    if (preempted_) return;
    preempted_ = true;
    const auto timer = clock.call_after(time, [this] { preempted_ = false; });
    while (preempted_)
      clock.run_next();
  }
  void press(AxisInput which, bool active) {
    lines[static_cast<std::size_t>(which)]->set(active, clock.now());
  }

  [[nodiscard]] std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override {
    return std::make_unique<PlantWatch>(*this, fd, std::move(call));
  }

  // The plate's position in steps. The motor moves a nut that lifts the plate from below and, `slack` later,
  // pulls it down.
  [[nodiscard]] std::int64_t plate() const { return plate_; }

  VirtualClock clock;
  // The clock of an event loop that may be delayed. If null, it is never delayed and uses the plant's clock.
  Clock* loop = nullptr;
  std::function<bool()> loop_is_held_up = [] { return false; };
  GpioAxisConfig config;
  std::unique_ptr<GpioAxis> axis;
  std::vector<MachineEvent> events;
  std::vector<std::string> refusals;  // returned by AxisThreads::refusals()
  std::function<void()> on_event;

  std::int64_t motor = 4'000;
  std::int64_t slack = 0;
  Switch limit, second;
  bool dead = false, reversed = false, counts_down = false;
  std::function<bool()> loses_step;  // called for each step
  // Above this speed, in steps/s, the motor loses steps when it starts or stops dead.
  double pull_in = std::numeric_limits<double>::infinity();
  // The steps that the motor moves at the pulse after a dead stop from above pull_in: 0, or whole periods of
  // its field if it overruns.
  std::int64_t overrun = 0;
  // The rotor is at rest when its field has rested for a full step's time, 16 pulses, or for a quarter of the
  // rotor's oscillation, 5 ms. Both are 5 % longer here: rotor_rate_ lags behind the field by up to 4 pulses,
  // 3 % at pull_in and 50 mm/s^2, and the plant must not be at rest before the engine's own limits.
  static constexpr double kStandsAfterPulses = 16 * 1.05;
  double stands_after_s = 0.005 * 1.05;
  std::function<bool()> loses_count;       // called for each step of the plate; the encoder then misses it
  std::int64_t index_every = 400;          // steps between two marks of the encoder's index
  Duration latency{20'000};                // latency of the step thread
  std::function<Duration()> step_latency;  // replaces `latency` if set
  Duration input_latency{60'000};          // latency of the input thread
  std::vector<TimePoint> pulses;           // times of the step line's rising edges
  Duration shortest_pulse{1'000'000'000}, shortest_pause{1'000'000'000}, shortest_setup{1'000'000'000};
  PlantOutput *step = nullptr, *direction = nullptr, *enable = nullptr;
  PlantInput *encoder_a = nullptr, *encoder_b = nullptr, *encoder_index = nullptr;
  std::array<PlantInput*, kAxisInputs> lines{};
  std::uint64_t disabled_steps = 0;

 private:
  class PlantWatch final : public Watch {
   public:
    PlantWatch(Plant& plant, int fd, std::function<void()> call) : plant_(plant), fd_(fd) {
      plant_.watched_[fd] = std::make_shared<std::function<void()>>(std::move(call));
    }
    ~PlantWatch() override { plant_.watched_.erase(fd_); }

   private:
    Plant& plant_;
    int fd_;
  };

  class Threads final : public AxisThreads {
   public:
    Threads(Plant& plant, StepEngine& engine, AxisInputs& inputs) : plant_(plant) {
      plant.engine_ = &engine;
      plant.inputs_engine_ = &inputs;
    }
    ~Threads() override {
      plant_.engine_ = nullptr;
      plant_.inputs_engine_ = nullptr;
      plant_.next_act_.reset();
      plant_.next_serve_.reset();
    }
    [[nodiscard]] std::vector<std::string> refusals() const override { return plant_.refusals; }

   private:
    Plant& plant_;
  };

  // Does what a kernel would: runs the threads that have work, then the event loop.
  void dispatch() {
    if (engine_ == nullptr) return;
    const int steps = engine_->work().descriptor(), reader = inputs_engine_->work().descriptor();
    for (;;) {
      std::vector<pollfd> waited{{steps, POLLIN, 0}, {reader, POLLIN, 0}};
      if (!loop_is_held_up()) {
        for (const auto& [fd, call] : watched_)
          waited.push_back({loop_busy_ ? -1 : fd, POLLIN, 0});
      }
      if (poll(waited.data(), waited.size(), 0) == 0) return;
      const auto ready =
          std::find_if(waited.begin(), waited.end(), [](const pollfd& fd) { return fd.revents != 0; });
      if (ready->fd == steps) {
        if (engine_->begin()) plan_act();
      } else if (ready->fd == reader) {
        serve();
      } else {
        const auto call = watched_.at(ready->fd);
        (*call)();
      }
    }
  }

  void plan_act() {
    const Duration late = step_latency ? step_latency() : latency;
    // The thread wakes every 10 ms to check for interruptions,
    const TimePoint wake = std::min(engine_->due() + late, clock.now() + std::chrono::milliseconds{10});
    // and if interrupted acts after 100 ns.
    const TimePoint look = engine_->interrupted() ? clock.now() + Duration{100} : wake;
    next_act_ = clock.call_at(std::max(look, held_up_until_), [this] {
      if (clock.now() < held_up_until_) return plan_act();
      engine_->act();
      if (engine_->running()) plan_act();
    });
  }

  void wake_inputs() {
    if (woken_ || inputs_engine_ == nullptr) return;
    woken_ = true;
    next_wake_ = clock.call_after(input_latency, [this] {
      woken_ = false;
      serve();
    });
  }
  void serve() {
    if (preempted_) return wake_inputs();
    next_serve_.reset();
    if (const auto next = inputs_engine_->serve()) {
      next_serve_ = clock.call_at(*next, [this] { serve(); });
    }
  }

  void step_edge(bool high) {
    if (!high) {
      shortest_pulse = std::min(shortest_pulse, clock.now() - pulses.back());
      fell_at_ = clock.now();
      return;
    }
    const std::int64_t turned = turned_by_pulse();
    if (!pulses.empty()) shortest_pause = std::min(shortest_pause, clock.now() - fell_at_);
    shortest_setup = std::min(shortest_setup, clock.now() - direction_changed_at_);
    pulses.push_back(clock.now());
    if (enable != nullptr && !enable->level) {
      ++disabled_steps;
      return;
    }
    if (dead || turned == 0 || (loses_step && loses_step())) return;
    motor += direction->level != reversed ? turned : -turned;
    move_plate();
    update_switches();
  }

  // Returns the rotor's steps at a pulse; the rotor's speed is that of the last pulses.
  std::int64_t turned_by_pulse() {
    if (pulses.empty() || !std::isfinite(pull_in)) return 1;
    const double interval_s = std::chrono::duration<double>(clock.now() - pulses.back()).count();
    const double rate = 1 / interval_s, late_s = interval_s - (rotor_rate_ > 0 ? 1 / rotor_rate_ : 0);
    const bool stood = late_s > std::min(kStandsAfterPulses / rotor_rate_, stands_after_s);
    const bool overran = stood && rotor_rate_ > pull_in;
    const bool turns = !overran && rate <= std::max(pull_in, stood ? 0 : 2 * rotor_rate_);
    rotor_rate_ = !turns ? 0 : stood ? rate : rotor_rate_ + (rate - rotor_rate_) / 4;
    if (overran) return overrun;
    return turns ? 1 : 0;
  }

  void move_plate() {
    const std::int64_t before = plate_;
    plate_ = std::clamp(plate_, motor, motor + slack);
    if (encoder_a == nullptr) return;
    // Four counts per period and one count per step, 1 us apart.
    TimePoint at = clock.now();
    for (std::int64_t p = before; p != plate_; at += std::chrono::microseconds{1}) {
      const std::int64_t step_of_plate = plate_ > p ? 1 : -1;
      p += step_of_plate;
      if (!loses_count || !loses_count()) move_encoder(step_of_plate, at);
      if (encoder_index != nullptr)
        encoder_index->set(((p % index_every) + index_every) % index_every < 2, at);
    }
  }
  void move_encoder(std::int64_t by, TimePoint at) {
    scale_ += counts_down ? -by : by;
    const auto phase = ((scale_ % 4) + 4) % 4;
    encoder_a->set(phase == 1 || phase == 2, at);
    encoder_b->set(phase == 2 || phase == 3, at);
  }

  void update_switches() {
    update(AxisInput::LimitSwitch, limit, config.homes_upwards ? 1 : -1, limit_closed_);
    update(AxisInput::SecondSwitch, second, config.homes_upwards ? -1 : 1, second_closed_);
  }
  void update(AxisInput which, const Switch& contact, int side, bool& closed) {
    const std::int64_t beyond = (plate_ - contact.at) * side;
    const bool was = closed;
    if (beyond >= 0) closed = true;
    if (beyond < -contact.hysteresis) closed = false;
    PlantInput* line = built(which);
    line->set(contact.stuck.value_or(closed), clock.now());
    if (was == closed || contact.stuck || contact.bounces == 0 || axis == nullptr) return;
    for (int i = 1; i <= contact.bounces * 2; ++i) {
      const bool level = i % 2 == 0 ? closed : !closed;
      bounces_.push_back(
          clock.call_after(contact.bounce * i, [line, level, this] { line->set(level, clock.now()); }));
    }
  }
  PlantInput* built(AxisInput which) {
    const auto i = static_cast<std::size_t>(which);
    return lines[i] != nullptr ? lines[i] : inputs_[i].get();
  }

  std::array<std::unique_ptr<PlantInput>, kAxisInputs> inputs_;
  std::map<int, std::shared_ptr<std::function<void()>>> watched_;
  StepEngine* engine_ = nullptr;
  AxisInputs* inputs_engine_ = nullptr;
  std::int64_t plate_ = 0, scale_ = 0;
  double rotor_rate_ = 0;  // steps/s
  bool limit_closed_ = false, second_closed_ = false, woken_ = false, preempted_ = false, loop_busy_ = false;
  TimePoint fell_at_{}, direction_changed_at_{}, held_up_until_{};
  std::unique_ptr<Timer> next_act_, next_serve_, next_wake_;
  std::vector<std::unique_ptr<Timer>> bounces_;
};

}  // namespace contourd::testing
