// Stand-ins for missing devices: each does nothing and answers every command with a failure, so that a
// machine has all its parts at any time. Event loop's thread only.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hw/clock.hpp"
#include "hw/hardware_error.hpp"
#include "hw/light_line.hpp"
#include "hw/mask_display.hpp"
#include "hw/projector.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

class AbsentAxis final : public ZAxis {
 public:
  // The clock must outlive the axis.
  AbsentAxis(Clock& clock, Nanometers travel) : clock_(clock), travel_(travel) {}

  void home(std::function<void(HomingResult)> done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(HomingResult::Fault); });
  }
  void move_to(Nanometers, MillimetersPerSecond, std::function<void(MoveResult)> done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(MoveResult::NotHomed); });
  }
  void rise(const RisePlan&, std::function<void(MoveResult)> done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(MoveResult::NotHomed); });
  }
  void nudge(Nanometers, MillimetersPerSecond, std::function<void(MoveResult)> done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(MoveResult::Fault); });
  }
  void raise(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override {
    nudge(distance, speed, std::move(done));
  }
  void assume_height(Nanometers) override {}
  [[nodiscard]] bool homes_upwards() const override { return false; }
  void stop() override {}
  void abort() noexcept override { answer_.reset(); }
  bool release() override { return false; }
  [[nodiscard]] bool moving() const override { return false; }
  [[nodiscard]] std::optional<Nanometers> height() const override { return std::nullopt; }
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint) const override { return std::nullopt; }
  [[nodiscard]] std::optional<Nanometers> homing_shift() const override { return std::nullopt; }
  [[nodiscard]] Nanometers travel() const override { return travel_; }
  [[nodiscard]] Duration move_duration(Nanometers, MillimetersPerSecond) const override {
    return Duration{0};
  }
  [[nodiscard]] std::vector<AxisInputState> inputs() const override { return {}; }
  [[nodiscard]] LateSteps late_steps() const override { return {}; }
  void set_light_cutoff(LightCutoff*) noexcept override {}
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {"there is no axis"}; }
  [[nodiscard]] std::string description() const override { return "none"; }

 private:
  Clock& clock_;
  Nanometers travel_;
  std::unique_ptr<Timer> answer_;
};

class AbsentDisplay final : public MaskDisplay {
 public:
  // The clock must outlive the display.
  AbsentDisplay(Clock& clock, Pixels width, Pixels height) : clock_(clock), width_(width), height_(height) {}

  [[nodiscard]] Pixels width() const override { return width_; }
  [[nodiscard]] Pixels height() const override { return height_; }
  [[nodiscard]] Duration frame() const override { return Duration{0}; }
  void show(const Mask&, Presented done) override { black(std::move(done)); }
  void black(Presented done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(std::nullopt); });
  }
  void black_now() noexcept override { answer_.reset(); }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {"there is no display"}; }
  [[nodiscard]] std::string description() const override { return "none"; }

 private:
  Clock& clock_;
  Pixels width_, height_;
  std::unique_ptr<Timer> answer_;
};

class AbsentProjector final : public Projector {
 public:
  // The clock must outlive the projector.
  explicit AbsentProjector(Clock& clock) : clock_(clock) {}

  void power_on(Done done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(ProjectorReply::NoAnswer); });
  }
  void light_on(Duration, LightOn tell) override {
    answer_ =
        clock_.call_after(Duration{0}, [tell = std::move(tell)] { tell.done(ProjectorReply::Refused); });
  }
  void light_off() noexcept override { answer_.reset(); }
  // A missing projector confirms nothing, so the callback is never called.
  void when_dark(std::function<void()>) override {}
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return std::nullopt; }
  void power_off() noexcept override { answer_.reset(); }
  void ask_status(StatusDone done) override {
    answer_ = clock_.call_after(Duration{0}, [this, done = std::move(done)] {
      done({.reply = ProjectorReply::NoAnswer, .problem = last_problem(), .powered = {}, .lamp_hours = {}});
    });
  }
  [[nodiscard]] std::string last_problem() const override { return "there is no projector"; }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return last_problem(); }
  void confirm_dark(Done done) override {
    answer_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(ProjectorReply::NoAnswer); });
  }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {last_problem()}; }
  [[nodiscard]] std::string description() const override { return "none"; }

 private:
  Clock& clock_;
  std::unique_ptr<Timer> answer_;
};

// The stand-in for a light line. A line that refused to go off before it was lost may still be on, so its
// last refusal is kept.
class AbsentLightLine final : public LightLine {
 public:
  // Keeps the last refusal() of the line that was lost; empty if that line was off.
  void lose(const std::string& refusal) { refusal_ = refusal; }

  void on() override { throw HardwareError("there is no light line"); }
  void off() noexcept override {}
  [[nodiscard]] std::string refusal() const override { return refusal_; }
  [[nodiscard]] std::optional<TimePoint> cut_at() const override { return std::nullopt; }
  [[nodiscard]] std::optional<TimePoint> cut_by() const override { return std::nullopt; }

 private:
  std::string refusal_;
};

}  // namespace contourd
