#include "hw/hardware_check.hpp"

#include <cstdio>
#include <exception>
#include <utility>

#include "hw/drm/drm_display.hpp"
#include "hw/gpio/gpio_axis.hpp"

namespace contourd {
namespace {

constexpr const char* kUnreadable = ": it cannot be read";

}  // namespace

HardwareCheck::HardwareCheck(Clock& clock, DescriptorWatcher& watcher, RealMachineConfig config)
    : HardwareCheck(clock, watcher, std::move(config), [](double rate, int priority) {
        return measure_wake_up_latency(rate, priority, std::chrono::milliseconds{1'500});
      }) {}

HardwareCheck::HardwareCheck(Clock& clock, DescriptorWatcher& watcher, RealMachineConfig config,
                             MeasureWakeUpLatency measure)
    : clock_(clock), watcher_(watcher), config_(std::move(config)), measure_(std::move(measure)) {}

void HardwareCheck::run(Found found, std::function<void()> done) {
  found_ = std::move(found);
  done_ = std::move(done);
  users_.clear();
  check_axis();
  check_speed();
  if (config_.light) check_line("light", *config_.light);
  check_display();
  if (config_.projector) return check_projector();
  end_ = clock_.call_after(Duration{0}, [this] { done_(); });
}

// Asks the kernel about the line without requesting it; then has `level`, if there is one, request and read
// it.
void HardwareCheck::check_line(const std::string& device, const GpioLineConfig& line,
                               const std::function<std::string()>& level) {
  try {
    const GpioLineReport found = report_line(line);
    const std::string what = describe(found);
    const auto [user, is_new] = users_.try_emplace({found.chip, found.offset}, device);
    if (!is_new) return report(device, false, what + ": the " + user->second + " already uses this line");
    const std::string state = found.consumer || !level ? "" : level();
    report(device, !found.consumer && state != kUnreadable, what + state);
  } catch (const std::exception& error) {
    report(device, false, error.what());
  }
}

// Requests the line for a moment, as the input that it is, and reads its level.
void HardwareCheck::check_input(const std::string& device, const GpioInputConfig& input, const char* active,
                                const char* inactive) {
  check_line(device, input.line, [&]() -> std::string {
    const std::optional<bool> level = GpioInput(input.logical_line(), input.bias, device).level();
    return level ? std::string("; it is ") + (*level ? active : inactive) : kUnreadable;
  });
}

void HardwareCheck::check_axis() {
  const GpioAxisConfig& axis = config_.axis;
  if (const auto what = contradiction(axis)) report("axis", false, *what);
  check_line("step", axis.step);
  check_line("direction", axis.direction);
  if (axis.enable) check_line("enable", *axis.enable);
  check_input("limit switch", axis.limit_switch, "closed", "open");
  if (axis.second_switch) check_input("second switch", *axis.second_switch, "closed", "open");
  if (axis.emergency_stop) check_input("emergency stop", *axis.emergency_stop, "pressed", "not pressed");
  if (axis.lid) check_input("lid", *axis.lid, "open", "closed");
  if (axis.power_fail)
    check_input("power fail", *axis.power_fail, "active: the power is failing", "inactive");
  if (axis.force)
    check_input(kForceInput, axis.force->input, "active: a force, or the line is wired the wrong way round",
                "inactive");
  if (axis.encoder) {
    for (const auto& [device, line] :
         {std::pair{"encoder A", &axis.encoder->a}, std::pair{"encoder B", &axis.encoder->b}})
      check_input(device, {*line, axis.encoder->bias, {}}, "active", "inactive");
    if (axis.encoder->index)
      check_input("encoder index", {*axis.encoder->index, axis.encoder->bias, {}}, "active", "inactive");
  }
}

// Measures without making steps, and so without the system calls for them: the result is a little optimistic.
void HardwareCheck::check_speed() {
  const GpioAxisConfig& axis = config_.axis;
  if (contradiction(axis)) return;
  const double rate = axis.top_speed.count() * axis.microsteps_per_mm;
  const WakeUpLatency wakes = measure_(rate, axis.realtime_priority);
  const double kept = wakes.sustainable_rate(kMaxStepsPerSecond);
  const auto us = [](Duration duration) { return static_cast<double>(duration.count()) / 1e3; };
  char text[320];
  std::snprintf(
      text, sizeof text,
      "%.0f steps/s needed (%g mm/s); 99 %% of wake-ups are at most %.0f us late, the worst is %.0f us late: "
      "this computer sustains %.0f steps/s (%.3g mm/s)",
      rate, axis.top_speed.count(), us(wakes.p99), us(wakes.worst), kept, kept / axis.microsteps_per_mm);
  std::string what = text;
  for (const std::string& refusal : wakes.refusals)
    what += "; " + refusal;
  // The daemon may have privileges that this process lacks.
  const bool refused = !wakes.refusals.empty();
  report("step thread", kept >= rate || refused, what, refused);
}

void HardwareCheck::check_display() {
  try {
    const DrmReport display = check_drm_display(config_.display);
    report("display", !display.in_use, display.description);
  } catch (const std::exception& error) {
    report("display", false, error.what());
  }
}

void HardwareCheck::check_projector() {
  try {
    projector_ = open_device(*config_.projector, clock_, watcher_);
  } catch (const std::exception& error) {
    report("projector", false, error.what());
    end_ = clock_.call_after(Duration{0}, [this] { done_(); });
    return;
  }
  projector_->ask_status([this](const ProjectorStatus& status) {
    const std::string place = projector_->description();
    std::string answer;
    if (status.powered) answer += *status.powered ? ", on" : ", off";
    if (status.lamp_hours) answer += ", lamp " + std::to_string(*status.lamp_hours) + " h";
    if (answer.empty()) answer = ": it opens, but it has no query to send";
    const bool good = status.reply == ProjectorReply::Ok;
    report("projector", good, good ? place + answer : status.problem);
    // Deferred, because done_ may destroy the projector, which must not happen inside its callback.
    end_ = clock_.call_after(Duration{0}, [this] { done_(); });
  });
}

}  // namespace contourd
