// The simulated printer's Z axis, a part of simulated_printer.hpp that is not for use outside hw.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hw/motion_curve.hpp"
#include "hw/simulated_printer_config.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

class SimulatedAxis final : public ZAxis {
 public:
  // The clock must outlive the axis.
  SimulatedAxis(Clock& clock, const SimulatedAxisConfig& config);

  void home(std::function<void(HomingResult)> done) override;
  void move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void rise(const RisePlan& plan, std::function<void(MoveResult)> done) override;
  void nudge(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void raise(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  // The plate is at this height from now on: this axis has forgotten where the process before left it.
  void assume_height(Nanometers height) override;
  [[nodiscard]] bool homes_upwards() const override { return config_.homes_upwards; }
  void expect_contact_at(Nanometers height) override { contact_ = height; }
  [[nodiscard]] std::optional<bool> force() const override {
    return config_.force ? std::optional(force_active_) : std::nullopt;
  }
  void on_force(std::function<void(const ForceChange&)> call) override { on_force_ = std::move(call); }
  // Makes a layer of this area and perimeter stick to the film, at the plate's present height.
  void cure(double area_mm2, double perimeter_mm);
  void stop() override;
  void abort() noexcept override;
  bool release() override;
  [[nodiscard]] bool moving() const override { return move_.has_value(); }
  [[nodiscard]] std::optional<Nanometers> height() const override { return height_at(clock_.now()); }
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const override;
  [[nodiscard]] std::optional<Nanometers> homing_shift() const override { return homing_shift_; }
  [[nodiscard]] Nanometers travel() const override { return config_.travel; }
  [[nodiscard]] Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const override {
    return MotionProfile(distance, speed, config_.acceleration).duration();
  }
  [[nodiscard]] std::vector<AxisInputState> inputs() const override;
  [[nodiscard]] LateSteps late_steps() const override { return {}; }
  void set_light_cutoff(LightCutoff*) noexcept override {}
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {}; }
  [[nodiscard]] std::string description() const override { return "simulated"; }

 private:
  struct Move {
    TimePoint start;
    Nanometers from;                        // true height, like all heights in this class
    std::shared_ptr<const RiseCurve> rise;  // the profile's, in millimetres; null if it follows none
    MotionProfile profile;
    std::function<void(MoveResult)> done;
  };

  [[nodiscard]] Nanometers nearest_step(Nanometers height) const;
  [[nodiscard]] Nanometers switch_height() const {
    return config_.homes_upwards ? config_.travel : Nanometers{0};
  }
  [[nodiscard]] bool switch_closed() const;
  void move_unhomed(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done);
  void put_at(Nanometers true_height);
  [[nodiscard]] Nanometers true_height() const;
  [[nodiscard]] std::optional<Nanometers> resistance(Nanometers end);
  void feel();
  [[nodiscard]] std::optional<MoveResult> why_not(const RisePlan& plan) const;
  void run(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done);
  void finish(Nanometers end, MoveResult result);
  void seek_switch(MillimetersPerSecond speed, std::function<void()> found);
  void end_homing(HomingResult result) {
    if (const auto done = std::exchange(homing_done_, nullptr)) done(result);
  }

  Clock& clock_;
  SimulatedAxisConfig config_;
  Nanometers true_height_;
  bool homed_ = false;
  std::optional<Nanometers> homing_shift_;
  std::uint64_t switch_edges_ = 0;
  // A layer on the film, from this height on, until the film pulls with this force.
  struct Stuck {
    Nanometers at;
    double force_n;
  };
  std::optional<Stuck> stuck_;
  Nanometers contact_{};
  std::optional<Nanometers> pressed_at_;  // the plate presses on something up to this height
  bool obstruction_met_ = false, force_active_ = false;
  int peels_ = 0;
  std::uint64_t force_edges_ = 0;
  std::function<void(const ForceChange&)> on_force_;
  std::unique_ptr<Timer> feel_;
  std::optional<Move> move_;
  std::unique_ptr<Timer> move_end_;
  std::function<void(HomingResult)> homing_done_;
};

}  // namespace contourd
