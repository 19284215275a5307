// A projector that writes its commands into a log. Not thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/hw/plain_devices.hpp"

namespace contourd::testing {

class NotedProjector final : public PlainProjector {
 public:
  explicit NotedProjector(std::vector<std::string>& log) : log_(log) {}
  void power_on(Done done) override { note("power on"), done(reply); }
  void light_on(Duration, LightOn tell) override {
    note("light on");
    if (answers_light_on) return tell.done(reply);
    answer = std::move(tell);
  }
  void light_off() noexcept override { note("light off"); }
  void when_dark(std::function<void()> call) override { dark = std::move(call); }
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return light; }
  void power_off() noexcept override { note("power off"); }
  void ask_status(StatusDone done) override { done({reply, {}, true, 12}); }
  [[nodiscard]] std::string last_problem() const override { return "the projector's problem"; }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return unconfirmed; }
  void may_warm_up() override { note("may warm up"); }
  void confirm_dark(Done done) override { note("confirm dark"), done(reply); }
  void power_off_if_on() override { note("power off if on"); }
  [[nodiscard]] bool lost() const override { return true; }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {"why"}; }
  [[nodiscard]] std::string description() const override { return "the projector"; }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {"hot"}; }
  [[nodiscard]] LightSerialPath light_off_path() const override { return {7, "off", {}}; }

  ProjectorReply reply = ProjectorReply::Ok;
  bool answers_light_on = true;
  LightOn answer;  // set by light_on() if `answers_light_on` is false
  std::string unconfirmed;
  std::function<void()> dark;
  std::optional<LightSpan> light;

 private:
  void note(const char* what) { log_.emplace_back(what); }
  std::vector<std::string>& log_;
};

}  // namespace contourd::testing
