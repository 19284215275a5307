#include "hw/simulated_printer.hpp"

#include <cstdio>
#include <string>
#include <utility>

#include "hw/png_file.hpp"
#include "hw/simulated_axis.hpp"

namespace contourd {

// A screen that keeps what it showed as files 0001.png, 0002.png, ...
class SimulatedPrinter::Screen final : public MaskDisplay {
 public:
  Screen(Clock& clock, const SimulatedDisplayConfig& config) : clock_(clock), config_(config) {}

  [[nodiscard]] Pixels width() const override { return config_.width; }
  [[nodiscard]] Pixels height() const override { return config_.height; }

  void show(const Mask& mask, Presented done) override {
    ++masks_shown_;
    const bool lost = config_.lost_after_frames && masks_shown_ > *config_.lost_after_frames;
    if (lost) return present(true, std::nullopt, std::move(done));
    if (folder_) write_png(*folder_ / file_name(masks_shown_), mask);
    present(false, next_refresh(), std::move(done));
  }

  void black(Presented done) override { present(true, next_refresh(), std::move(done)); }

  void black_now() noexcept override {
    black_ = true;
    refresh_.reset();
  }

  void keep_masks_in(std::optional<std::filesystem::path> folder) {
    folder_ = std::move(folder);
    masks_shown_ = 0;
  }
  [[nodiscard]] const SimulatedDisplayConfig& config() const { return config_; }
  [[nodiscard]] bool is_black() const { return black_; }
  [[nodiscard]] int masks_shown() const { return masks_shown_; }

 private:
  static std::string file_name(int number) {
    char name[32];
    std::snprintf(name, sizeof name, "%04d.png", number);
    return name;
  }

  [[nodiscard]] TimePoint next_refresh() const {
    const Duration since_start = clock_.now().time_since_epoch();
    return TimePoint{(since_start / config_.frame + 1) * config_.frame};
  }

  void present(bool black, std::optional<TimePoint> at, Presented done) {
    refresh_ = clock_.call_at(at.value_or(clock_.now()), [this, black, at, done = std::move(done)] {
      black_ = black;
      done(at);
    });
  }

  Clock& clock_;
  SimulatedDisplayConfig config_;
  std::optional<std::filesystem::path> folder_;
  int masks_shown_ = 0;
  bool black_ = true;
  std::unique_ptr<Timer> refresh_;
};

class SimulatedPrinter::Lamp final : public Projector {
 public:
  Lamp(Clock& clock, const SimulatedProjectorConfig& config) : clock_(clock), config_(config) {}

  void power_on(Done done) override {
    reply(
        powered_ ? config_.reply : config_.reply + config_.warm_up, [this] { powered_ = true; },
        std::move(done));
  }

  void light_on(Done done) override {
    if (!powered_) {
      reply_ = clock_.call_after(config_.reply, [this, done = std::move(done)] {
        failed_ = ProjectorReply::Refused;
        done(failed_);
      });
      return;
    }
    reply(
        config_.reply, [this] { light_ = true; }, std::move(done));
  }

  void light_off() noexcept override {
    light_ = false;
    reply_.reset();
  }

  void power_off() noexcept override {
    light_off();
    powered_ = false;
  }

  void ask_status(StatusDone done) override {
    reply(
        config_.reply, [] {},
        [this, done = std::move(done)](ProjectorReply reply) {
          done(reply == ProjectorReply::Ok ? ProjectorStatus{reply, {}, powered_, {}}
                                           : ProjectorStatus{reply, last_problem(), {}, {}});
        });
  }

  [[nodiscard]] std::string last_problem() const override { return std::string(describe(failed_)); }

  [[nodiscard]] bool is_on() const { return light_; }

 private:
  void reply(Duration delay, const std::function<void()>& effect, Done done) {
    ++commands_;
    const bool silent = config_.silent_after_commands && commands_ > *config_.silent_after_commands;
    reply_ =
        clock_.call_after(silent ? config_.timeout : delay, [this, effect, silent, done = std::move(done)] {
          if (!silent) {
            effect();
            return done(ProjectorReply::Ok);
          }
          failed_ = ProjectorReply::NoAnswer;
          done(failed_);
        });
  }

  Clock& clock_;
  SimulatedProjectorConfig config_;
  bool powered_ = false;
  bool light_ = false;
  int commands_ = 0;
  ProjectorReply failed_ = ProjectorReply::Ok;  // the last that was not Ok
  std::unique_ptr<Timer> reply_;
};

SimulatedPrinter::SimulatedPrinter(Clock& clock, const SimulatedPrinterConfig& config)
    : axis_(std::make_unique<SimulatedAxis>(clock, config.axis)),
      screen_(std::make_unique<Screen>(clock, config.display)),
      lamp_(std::make_unique<Lamp>(clock, config.projector)) {}

SimulatedPrinter::~SimulatedPrinter() = default;

ZAxis& SimulatedPrinter::z_axis() {
  return *axis_;
}
MaskDisplay& SimulatedPrinter::display() {
  return *screen_;
}
Projector& SimulatedPrinter::projector() {
  return *lamp_;
}

std::optional<std::filesystem::path> SimulatedPrinter::begin_job(std::string_view name) {
  if (!screen_->config().masks) {
    screen_->keep_masks_in(std::nullopt);
    return std::nullopt;
  }
  const std::filesystem::path folder = *screen_->config().masks / name;
  std::filesystem::create_directories(folder);
  // An earlier job of that name may have left masks.
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") std::filesystem::remove(entry.path());
  }
  screen_->keep_masks_in(folder);
  return folder;
}

bool SimulatedPrinter::light_is_on() const {
  return lamp_->is_on();
}
bool SimulatedPrinter::screen_is_black() const {
  return screen_->is_black();
}
int SimulatedPrinter::masks_shown() const {
  return screen_->masks_shown();
}

}  // namespace contourd
