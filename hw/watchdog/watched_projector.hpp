// A projector whose light is on only under the light watchdog's eyes: from before light on is sent until
// darkness is confirmed. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hw/projector.hpp"
#include "hw/watchdog/light_watchdog.hpp"

namespace contourd {

class WatchedProjector final : public Projector {
 public:
  // Both must outlive this. `offer_paths` hands the watchdog what the light can be turned off by, as it is
  // now.
  WatchedProjector(Projector& projector, LightWatchdog& watchdog, std::function<void()> offer_paths)
      : projector_(&projector), watchdog_(watchdog), offer_paths_(std::move(offer_paths)) {}
  // Another takes its place. It must outlive this, or be replaced before it goes.
  void watch(Projector& projector) { projector_ = &projector; }

  void power_on(Done done) override { projector_->power_on(std::move(done)); }
  // Light on is sent when the watchdog has said that it watches. If it does not, LightWatchdog::on_trouble()
  // tells, and `tell` hears nothing.
  void light_on(Duration exposure, LightOn tell) override;
  void light_off() noexcept override;
  void when_dark(std::function<void()> call) override;
  // A light that the watchdog has turned off went off then.
  [[nodiscard]] std::optional<LightSpan> last_light() const override;
  void power_off() noexcept override;
  void ask_status(StatusDone done) override { projector_->ask_status(std::move(done)); }
  [[nodiscard]] std::string last_problem() const override { return projector_->last_problem(); }
  [[nodiscard]] std::string light_off_unconfirmed() const override {
    return projector_->light_off_unconfirmed();
  }
  void may_warm_up() override { projector_->may_warm_up(); }
  void confirm_dark(Done done) override { projector_->confirm_dark(std::move(done)); }
  void power_off_if_on() override { projector_->power_off_if_on(); }
  [[nodiscard]] LightSerialPath light_off_path() const override { return projector_->light_off_path(); }
  void on_event(std::function<void(const MachineEvent&)> call) override {
    projector_->on_event(std::move(call));
  }
  [[nodiscard]] bool lost() const override { return projector_->lost(); }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override {
    return projector_->why_not_ready();
  }
  [[nodiscard]] std::string description() const override { return projector_->description(); }
  [[nodiscard]] std::vector<std::string> warnings() const override { return projector_->warnings(); }

 private:
  void await_darkness();

  Projector* projector_;
  LightWatchdog& watchdog_;
  std::function<void()> offer_paths_;
  std::function<void()> dark_;
  bool watched_ = false;    // since light_on(), until it is confirmed dark
  bool passed_on_ = false;  // the last light_on(), to the projector
};

}  // namespace contourd
