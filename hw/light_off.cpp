#include "hw/light_off.hpp"

#include <exception>
#include <utility>

namespace contourd {
namespace {

constexpr Duration kPause{std::chrono::seconds{1}};

}  // namespace

LightOff::LightOff(Clock& clock, DescriptorWatcher& watcher, LightConfig config)
    : clock_(clock), watcher_(watcher), config_(std::move(config)) {}

void LightOff::run(Done done) {
  done_ = std::move(done);
  if (config_.line) turn_line_off();
  if (!config_.projector) return end();
  try {
    projector_ = open_device(*config_.projector, clock_, watcher_);
  } catch (const std::exception& error) {
    problems_.emplace_back(error.what());
    return end();
  }
  if (!config_.left_dark) projector_->may_warm_up();
  patience_ = clock_.call_after(kPatience, [this] { give_up(); });
  tell_projector();
}

void LightOff::tell_projector() {
  projector_->confirm_dark([this](ProjectorReply reply) {
    if (reply == ProjectorReply::Ok) return end();
    if (projector_->lost()) return give_up();
    again_ = clock_.call_after(kPause, [this] { tell_projector(); });
  });
}

void LightOff::give_up() {
  const bool warming = !config_.left_dark && warm_up_of(*config_.projector) > kPatience;
  problems_.push_back(projector_->last_problem() + (warming ? "; it may be warming up" : ""));
  end();
}

void LightOff::turn_line_off() {
  try {
    line_ = std::make_unique<GpioLightLine>(*config_.line, clock_);
    line_->off();
    if (const std::string refusal = line_->refusal(); !refusal.empty()) problems_.push_back(refusal);
  } catch (const std::exception& error) {
    problems_.emplace_back(error.what());
  }
}

// Defers done_, because it may destroy the projector, which must not happen inside the projector's callback.
void LightOff::end() {
  again_.reset();
  patience_.reset();
  end_ = clock_.call_after(Duration{0}, [this] { done_(problems_); });
}

}  // namespace contourd
