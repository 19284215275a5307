// A simulated printer with an adjustable count of late motor steps, whose machine events a test can trigger.
// Not thread-safe.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "hw/machine.hpp"
#include "tests/hw/plain_devices.hpp"

namespace contourd::testing {

class LateAxis final : public PlainAxis {
 public:
  explicit LateAxis(ZAxis& axis) : axis_(axis) {}
  void home(std::function<void(HomingResult)> done) override { axis_.home(std::move(done)); }
  void move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override {
    axis_.move_to(target, speed, std::move(done));
  }
  void stop() override { axis_.stop(); }
  void abort() noexcept override { axis_.abort(); }
  [[nodiscard]] bool moving() const override { return axis_.moving(); }
  [[nodiscard]] std::optional<Nanometers> height() const override { return axis_.height(); }
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const override {
    return axis_.height_at(time);
  }
  [[nodiscard]] Nanometers travel() const override { return axis_.travel(); }
  [[nodiscard]] Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const override {
    return axis_.move_duration(distance, speed);
  }
  [[nodiscard]] std::vector<AxisInputState> inputs() const override { return axis_.inputs(); }
  [[nodiscard]] LateSteps late_steps() const override { return late; }

  LateSteps late;

 private:
  ZAxis& axis_;
};

class LateMachine final : public Machine {
 public:
  explicit LateMachine(Machine& rest) : axis(rest.z_axis()), rest_(rest) {}
  [[nodiscard]] ZAxis& z_axis() override { return axis; }
  [[nodiscard]] MaskDisplay& display() override { return rest_.display(); }
  [[nodiscard]] Projector& projector() override { return rest_.projector(); }
  void on_event(std::function<void(const MachineEvent&)> call) override {
    report = call;
    rest_.on_event(std::move(call));
  }
  [[nodiscard]] std::string why_not_ready() const override { return rest_.why_not_ready(); }
  std::optional<std::filesystem::path> begin_job(std::string_view name) override {
    return rest_.begin_job(name);
  }

  LateAxis axis;
  std::function<void(const MachineEvent&)> report;

 private:
  Machine& rest_;
};

}  // namespace contourd::testing
