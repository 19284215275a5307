// Devices for tests that only need their commands: they have no events of their own. Not thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hw/mask_display.hpp"
#include "hw/projector.hpp"
#include "hw/z_axis.hpp"

namespace contourd::testing {

template <typename Interface>
class PlainDevice : public Interface {
 public:
  void on_event(std::function<void(const MachineEvent&)>) override {}
  [[nodiscard]] bool lost() const override { return false; }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {}; }
  [[nodiscard]] std::string description() const override { return "plain"; }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {}; }
};

// A projector that no earlier process has left on.
class PlainProjector : public PlainDevice<Projector> {
 public:
  void may_warm_up() override {}
  void confirm_dark(Done done) override { done(ProjectorReply::Ok); }
  void power_off_if_on() override {}
  [[nodiscard]] LightSerialPath light_off_path() const override { return {}; }
};

class PlainDisplay : public PlainDevice<MaskDisplay> {
 public:
  void probe_again() override {}
  [[nodiscard]] LightDisplayPath black_path() const override { return {}; }
};

class PlainAxis : public PlainDevice<ZAxis> {
 public:
  void set_light_cutoff(LightCutoff*) noexcept override {}
  bool release() override { return false; }
  void nudge(Nanometers, MillimetersPerSecond, std::function<void(MoveResult)>) override {}
  [[nodiscard]] std::optional<Nanometers> homing_shift() const override { return std::nullopt; }
};

}  // namespace contourd::testing
