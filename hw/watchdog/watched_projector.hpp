// A projector whose light is on only while the light watchdog watches: from before light on is sent until
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
  // The projector and the watchdog must outlive this object. `offer_paths` hands the watchdog the descriptors
  // that can turn the light off at the moment.
  WatchedProjector(Projector& projector, LightWatchdog& watchdog, std::function<void()> offer_paths)
      : projector_(&projector), watchdog_(watchdog), offer_paths_(std::move(offer_paths)) {}
  // Replaces the projector. The new one must outlive this object, or be replaced before it is destroyed.
  void watch(Projector& projector) { projector_ = &projector; }

  void power_on(Done done) override { projector_->power_on(std::move(done)); }
  // Sends light on when the watchdog has confirmed that it watches. If it does not confirm,
  // LightWatchdog::on_trouble() reports that, and `tell` is not called.
  void light_on(Duration exposure, LightOn tell) override;
  void light_off() noexcept override;
  void when_dark(std::function<void()> call) override;
  // Returns when the last light shone; a light that the watchdog turned off went off at that time.
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
  bool passed_on_ = false;  // the projector was given the last light_on()
};

}  // namespace contourd
