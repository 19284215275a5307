// Projectors whose light is switched by a line: an LED driver's enable, or a shutter. Event loop's thread
// only.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hw/clock.hpp"
#include "hw/light_line.hpp"
#include "hw/projector.hpp"

namespace contourd {

// Nothing but a line: a bare LED engine. Its power is somebody else's.
class LightLineProjector final : public Projector {
 public:
  // The line and the clock must outlive the projector.
  LightLineProjector(LightLine& line, Clock& clock, Duration warm_up);
  ~LightLineProjector() override;

  void power_on(Done done) override;
  void light_on(Done done) override;
  void light_off() noexcept override;
  void power_off() noexcept override;
  void ask_status(StatusDone done) override;
  [[nodiscard]] std::string last_problem() const override { return problem_; }

 private:
  void answer_after(Duration delay, std::function<void()> answer);

  LightLine& line_;
  Clock& clock_;
  Duration warm_up_;
  bool warm_ = false;
  std::string problem_;
  std::unique_ptr<Timer> answer_;
};

// A projector and a line before its light. The line lets light through only when the projector says that its
// own is on, and is off before the projector is told anything.
class ProjectorWithLightLine final : public Projector {
 public:
  // Both must outlive this.
  ProjectorWithLightLine(Projector& projector, LightLine& line);
  ~ProjectorWithLightLine() override;

  void power_on(Done done) override;
  void light_on(Done done) override;
  void light_off() noexcept override;
  void power_off() noexcept override;
  void ask_status(StatusDone done) override;
  [[nodiscard]] std::string last_problem() const override;

 private:
  Projector& projector_;
  LightLine& line_;
  std::string line_problem_;  // of the last light_on(), if the line was to blame
};

}  // namespace contourd
