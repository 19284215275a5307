#include "hw/projector_with_light_line.hpp"

#include <utility>

#include "hw/hardware_error.hpp"

namespace contourd {

LightLineProjector::LightLineProjector(LightLine& line, Clock& clock, Duration warm_up)
    : line_(line), clock_(clock), warm_up_(warm_up) {
  line_.off();
}

LightLineProjector::~LightLineProjector() {
  line_.off();
}

void LightLineProjector::answer_after(Duration delay, std::function<void()> answer) {
  answer_ = clock_.call_after(delay, std::move(answer));
}

void LightLineProjector::power_on(Done done) {
  answer_after(warm_ ? Duration{0} : warm_up_, [this, done = std::move(done)] {
    warm_ = true;
    done(ProjectorReply::Ok);
  });
}

void LightLineProjector::light_on(Done done) {
  ProjectorReply reply = ProjectorReply::Ok;
  try {
    line_.on();
  } catch (const HardwareError& error) {
    line_.off();
    problem_ = error.what();
    reply = ProjectorReply::Refused;
  }
  answer_after(Duration{0}, [reply, done = std::move(done)] { done(reply); });
}

void LightLineProjector::light_off() noexcept {
  line_.off();
  answer_.reset();
}

void LightLineProjector::power_off() noexcept {
  light_off();
  warm_ = false;
}

void LightLineProjector::ask_status(StatusDone done) {
  answer_after(Duration{0}, [done = std::move(done)] { done({}); });
}

ProjectorWithLightLine::ProjectorWithLightLine(Projector& projector, LightLine& line)
    : projector_(projector), line_(line) {
  line_.off();
}

ProjectorWithLightLine::~ProjectorWithLightLine() {
  line_.off();
}

void ProjectorWithLightLine::power_on(Done done) {
  line_.off();
  projector_.power_on(std::move(done));
}

void ProjectorWithLightLine::light_on(Done done) {
  line_problem_.clear();
  projector_.light_on([this, done = std::move(done)](ProjectorReply reply) {
    if (reply != ProjectorReply::Ok) return done(reply);
    try {
      line_.on();
    } catch (const HardwareError& error) {
      light_off();
      line_problem_ = error.what();
      return done(ProjectorReply::Refused);
    }
    done(reply);
  });
}

void ProjectorWithLightLine::light_off() noexcept {
  line_.off();
  projector_.light_off();
}

void ProjectorWithLightLine::power_off() noexcept {
  line_.off();
  projector_.power_off();
}

void ProjectorWithLightLine::ask_status(StatusDone done) {
  projector_.ask_status(std::move(done));
}

std::string ProjectorWithLightLine::last_problem() const {
  return line_problem_.empty() ? projector_.last_problem() : line_problem_;
}

}  // namespace contourd
