#include "hw/projector_with_light_line.hpp"

#include <algorithm>

#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

// Interval at which a line that refuses to go off is checked; the line retries by itself.
constexpr Duration kLookAgain{std::chrono::milliseconds{20}};

}  // namespace

LightLineProjector::LightLineProjector(LightLine& line, Clock& clock, Duration warm_up)
    : line_(line), clock_(clock), warm_up_(warm_up) {
  line_.off();
}

void LightLineProjector::power_on(Done done) {
  answer_after(warm_ ? Duration{0} : warm_up_, [this, done = std::move(done)] {
    warm_ = true;
    if (problem_ = line_.refusal(); !problem_.empty()) return done(ProjectorReply::Refused);
    done(ProjectorReply::Ok);
  });
}

void LightLineProjector::light_on(Duration, LightOn tell) {
  dark_ = nullptr;
  light_ = LightSpan{clock_.now(), {}, {}, {}};
  if (const ProjectorReply reply = turn_line_on(); reply != ProjectorReply::Ok) {
    light_off();
    answer_after(Duration{0}, [reply, tell = std::move(tell)] { tell.done(reply); });
    return;
  }
  light_->on_latest = clock_.now();
  answer_after(Duration{0}, [tell = std::move(tell), earliest = light_->on_earliest] {
    tell.sent(earliest);
    tell.done(ProjectorReply::Ok);
  });
}

ProjectorReply LightLineProjector::turn_line_on() {
  try {
    line_.on();
    return ProjectorReply::Ok;
  } catch (const LightInterlocked& why) {
    problem_ = why.what();
    return ProjectorReply::Interlocked;
  } catch (const HardwareError& error) {
    problem_ = error.what();
    return ProjectorReply::Refused;
  }
}

void LightLineProjector::light_off() noexcept {
  const TimePoint now = clock_.now();
  if (light_ && !light_->off_earliest) light_->off_earliest = std::min(line_.cut_at().value_or(now), now);
  line_.off();
  answer_.reset();
  note_whether_off();
}

std::optional<LightSpan> LightLineProjector::last_light() const {
  std::optional<LightSpan> light = light_;
  if (light && !light->off_earliest) light->off_earliest = line_.cut_at();
  return light;
}

void LightLineProjector::note_whether_off() {
  if (!light_ || !light_->off_earliest || light_->off_latest || !line_.refusal().empty()) return;
  const TimePoint now = clock_.now();
  // A line that was cut before it was known to be on may have gone on after the cut, and off only now.
  light_->off_latest = light_->on_latest ? std::min(line_.cut_by().value_or(now), now) : now;
}

void LightLineProjector::when_dark(std::function<void()> call) {
  dark_ = std::move(call);
  look_whether_dark(Duration{0});
}

void LightLineProjector::look_whether_dark(Duration delay) {
  look_ = clock_.call_after(delay, [this] {
    note_whether_off();
    if (!line_.refusal().empty()) return look_whether_dark(kLookAgain);
    if (const auto dark = std::exchange(dark_, nullptr)) dark();
  });
}

void LightLineProjector::power_off() noexcept {
  light_off();
  warm_ = false;
}

void LightLineProjector::confirm_dark(Done done) {
  light_off();
  problem_ = line_.refusal();
  answer_after(Duration{0}, [done = std::move(done), dark = problem_.empty()] {
    done(dark ? ProjectorReply::Ok : ProjectorReply::Refused);
  });
}

std::vector<std::string> LightLineProjector::why_not_ready() const {
  if (line_.refusal().empty()) return {};
  return {"the light may be on: " + line_.refusal()};
}

ProjectorWithLightLine::ProjectorWithLightLine(Projector& projector, LightLine& line, Clock& clock)
    : projector_(projector), line_projector_(line, clock, Duration{0}) {}

// Withdraws the callback from the projector, which may outlive this object.
ProjectorWithLightLine::~ProjectorWithLightLine() {
  line_projector_.light_off();
  projector_.when_dark(nullptr);
}

void ProjectorWithLightLine::power_on(Done done) {
  line_projector_.light_off();
  projector_.power_on([this, done = std::move(done)](ProjectorReply reply) {
    line_asked_ = reply == ProjectorReply::Ok;
    if (!line_asked_) return done(reply);
    line_projector_.power_on(done);
  });
}

void ProjectorWithLightLine::light_on(Duration exposure, LightOn tell) {
  line_asked_ = false;
  const auto answered = [this, exposure, tell = std::move(tell)](ProjectorReply reply) {
    if (reply != ProjectorReply::Ok) return tell.done(reply);
    line_asked_ = true;
    line_projector_.light_on(exposure, {.sent = tell.sent, .done = [this, tell](ProjectorReply line_reply) {
                                          if (line_reply != ProjectorReply::Ok) light_off();
                                          tell.done(line_reply);
                                        }});
  };
  // The projector's own light does not get past the line yet, so its `sent` is ignored.
  projector_.light_on(exposure, {.sent = [](TimePoint) {}, .done = answered});
}

void ProjectorWithLightLine::light_off() noexcept {
  line_projector_.light_off();
  projector_.light_off();
}

void ProjectorWithLightLine::power_off() noexcept {
  line_projector_.power_off();
  projector_.power_off();
}

std::string ProjectorWithLightLine::light_off_unconfirmed() const {
  const std::string line = line_projector_.light_off_unconfirmed();
  return line.empty() ? projector_.light_off_unconfirmed() : line;
}

void ProjectorWithLightLine::confirm_dark(Done done) {
  line_projector_.light_off();
  const std::string line = line_projector_.light_off_unconfirmed();
  projector_.confirm_dark([dark = line.empty(), done = std::move(done)](ProjectorReply reply) {
    done(reply == ProjectorReply::Ok && !dark ? ProjectorReply::Refused : reply);
  });
}

std::vector<std::string> ProjectorWithLightLine::why_not_ready() const {
  std::vector<std::string> sentences = line_projector_.why_not_ready();
  for (std::string& sentence : projector_.why_not_ready())
    sentences.push_back(std::move(sentence));
  return sentences;
}

}  // namespace contourd
