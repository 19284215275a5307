// Projectors whose light is switched by a line: an LED driver's enable, or a shutter. Event loop's thread
// only.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hw/clock.hpp"
#include "hw/light_line.hpp"
#include "hw/projector.hpp"

namespace contourd {

// A projector that is only a light line: a bare LED engine, whose power is not ours to switch. The line
// reports its events itself.
class LightLineProjector final : public Projector {
 public:
  // The line and the clock must outlive the projector.
  LightLineProjector(LightLine& line, Clock& clock, Duration warm_up);
  ~LightLineProjector() override { line_.off(); }

  void power_on(Done done) override;
  void light_on(Duration exposure, LightOn tell) override;
  void light_off() noexcept override;
  void when_dark(std::function<void()> call) override;
  // Returns when the light shone; a light that a cutoff ended went off at that time.
  [[nodiscard]] std::optional<LightSpan> last_light() const override;
  void power_off() noexcept override;
  void ask_status(StatusDone done) override {
    answer_after(Duration{0}, [done = std::move(done)] { done({}); });
  }
  [[nodiscard]] std::string last_problem() const override { return problem_; }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return line_.refusal(); }
  void confirm_dark(Done done) override;
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;
  [[nodiscard]] std::string description() const override { return "a light line"; }

 private:
  void answer_after(Duration delay, std::function<void()> answer) {
    answer_ = clock_.call_after(delay, std::move(answer));
  }
  ProjectorReply turn_line_on();
  void note_whether_off();
  void look_whether_dark(Duration delay);

  LightLine& line_;
  Clock& clock_;
  Duration warm_up_;
  bool warm_ = false;
  std::string problem_;
  std::optional<LightSpan> light_;
  std::function<void()> dark_;
  std::unique_ptr<Timer> answer_, look_;
};

// A projector with a light line in front of its light. The line lets light through only after the projector
// says that its own light is on, and goes off before the projector gets any command. The light's times are
// the line's; the whole is dark when both are.
class ProjectorWithLightLine final : public Projector {
 public:
  // All arguments must outlive this object. Its owner calls light_off(), which drops pending answers, before
  // destroying it.
  ProjectorWithLightLine(Projector& projector, LightLine& line, Clock& clock);
  ~ProjectorWithLightLine() override;

  void power_on(Done done) override;
  void light_on(Duration exposure, LightOn tell) override;
  void light_off() noexcept override;
  void when_dark(std::function<void()> call) override {
    projector_.when_dark([this, call = std::move(call)] { line_projector_.when_dark(call); });
  }
  [[nodiscard]] std::optional<LightSpan> last_light() const override {
    return line_asked_ ? line_projector_.last_light() : std::nullopt;
  }
  void power_off() noexcept override;
  void ask_status(StatusDone done) override { projector_.ask_status(std::move(done)); }
  [[nodiscard]] std::string last_problem() const override {
    return line_asked_ ? line_projector_.last_problem() : projector_.last_problem();
  }
  [[nodiscard]] std::string light_off_unconfirmed() const override;
  void may_warm_up() override { projector_.may_warm_up(); }
  void confirm_dark(Done done) override;
  void power_off_if_on() override { projector_.power_off_if_on(); }
  [[nodiscard]] LightSerialPath light_off_path() const override { return projector_.light_off_path(); }
  void on_event(std::function<void(const MachineEvent&)> call) override {
    projector_.on_event(std::move(call));
  }
  [[nodiscard]] bool lost() const override { return projector_.lost(); }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;
  [[nodiscard]] std::string description() const override { return projector_.description(); }
  [[nodiscard]] std::vector<std::string> warnings() const override { return projector_.warnings(); }

 private:
  Projector& projector_;
  LightLineProjector line_projector_;
  bool line_asked_ = false;  // the last power_on() or light_on() has got as far as the line
};

}  // namespace contourd
