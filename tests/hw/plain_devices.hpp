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
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {}; }
  [[nodiscard]] std::string description() const override { return "plain"; }
};

// A projector that no earlier process has left on.
class PlainProjector : public PlainDevice<Projector> {
 public:
  void confirm_dark(Done done) override { done(ProjectorReply::Ok); }
};

using PlainDisplay = PlainDevice<MaskDisplay>;

class PlainAxis : public PlainDevice<ZAxis> {
 public:
  void set_light_cutoff(LightCutoff*) noexcept override {}
  bool release() override { return false; }
  void nudge(Nanometers, MillimetersPerSecond, std::function<void(MoveResult)>) override {}
  void rise(const RisePlan&, std::function<void(MoveResult)>) override {}
  void raise(Nanometers, MillimetersPerSecond, std::function<void(MoveResult)>) override {}
  void assume_height(Nanometers) override {}
  [[nodiscard]] bool homes_upwards() const override { return false; }
  [[nodiscard]] std::optional<Nanometers> homing_shift() const override { return std::nullopt; }
};

}  // namespace contourd::testing
