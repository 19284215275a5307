#include "hw/drm/drm_display.hpp"

#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <system_error>
#include <utility>

#include "hw/drm/master_holder.hpp"
#include "hw/drm/output.hpp"
#include "hw/drm/text_console.hpp"
#include "hw/drm/uevent_socket.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

FileDescriptor made_eventfd() {
  FileDescriptor fd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!fd.valid()) throw std::system_error(errno, std::generic_category(), "making an eventfd");
  return fd;
}

FileDescriptor made_timerfd() {
  FileDescriptor fd(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!fd.valid()) throw std::system_error(errno, std::generic_category(), "making a timerfd");
  return fd;
}

// While a mask is on the screen its card is looked after this often: a refresh or so.
constexpr timespec kLookInterval{0, 20'000'000};

}  // namespace

class DrmDisplay::Implementation {
 public:
  Implementation(DescriptorWatcher& watcher, const DrmDisplayConfig& config)
      : watcher_(watcher),
        config_(config),
        wake_(made_eventfd()),
        look_(made_timerfd()),
        uevent_watch_(watcher.when_readable(uevents_.fd(), [this] { displays_changed(); })),
        wake_watch_(watcher.when_readable(wake_.get(), [this] { deny_waiting(); })),
        look_watch_(watcher.when_readable(look_.get(), [this] { look_after_card(); })) {
    OutputSearch search = find_output(config_);
    if (search.found) {
      take(std::move(*search.found));
    } else {
      problem_ = search.why_not;
    }
  }

  void show(const Mask& mask, Presented done) {
    waiting_ = std::move(done);
    if (!is_usable()) return deny_later();
    bytes_written_ = output_->write(mask);
    if (const int error = output_->show_written(); error != 0) return lose_later(error);
    keep_looking(true);
  }

  void black(Presented done) {
    keep_looking(false);
    waiting_ = std::move(done);
    if (!is_usable()) return deny_later();
    if (const int error = output_->show_black(); error != 0) lose_later(error);
  }

  void black_now() noexcept {
    keep_looking(false);
    waiting_ = nullptr;
    if (output_) output_->black_now();
  }

  void look_whether_back() {
    if (!problem_) return;
    // What else has become of it the kernel announces.
    const std::string before = *problem_;
    look_again();
    if (!problem_) return tell_recovery();
    problem_ = before;
  }

  void on_disturbance(std::function<void(const Disturbance&)> call) { on_disturbance_ = std::move(call); }

  [[nodiscard]] const DrmDisplayConfig& config() const { return config_; }
  [[nodiscard]] Duration frame() const {
    if (!output_) return Duration{0};
    return Duration{std::llround(1e9 / refresh_hz(output_->mode()))};
  }
  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  [[nodiscard]] const std::optional<std::string>& warning() const { return warning_; }
  [[nodiscard]] std::size_t bytes_written() const { return bytes_written_; }
  [[nodiscard]] std::string description() const {
    if (!output_) return "no display";
    return output_->name() + ": " + describe(output_->mode()) +
           (output_->is_atomic() ? ", atomic" : ", legacy");
  }

 private:
  // Takes a lost display up again if it is back.
  bool is_usable() {
    if (problem_) look_again();
    return !problem_;
  }

  // A display that is still away leaves the problem as it is; one that is back but of no use is a new one.
  void look_again() {
    try {
      if (output_) {
        if (output_->relight(config_)) problem_.reset();
      } else if (auto found = find_anywhere()) {
        take(std::move(*found));
      }
    } catch (const HardwareError& error) {
      problem_ = error.what();
    }
  }

  // Nothing while there is none, or its card is only just coming.
  [[nodiscard]] std::optional<FoundOutput> find_anywhere() const {
    try {
      return find_output(config_).found;
    } catch (const HardwareError&) {
      return std::nullopt;
    }
  }

  void take(FoundOutput found) {
    warning_ = keep_console_dark(found.card.path());
    output_ = std::make_unique<Output>(std::move(found.card), found.connector, config_);
    card_watch_ = watcher_.when_readable(output_->card().fd(), [this] { flip_done(); });
    problem_.reset();
  }

  void flip_done() {
    const Output::Events events = output_->read_events();
    if (events.card_is_gone) return lose_card();
    if (events.error != 0) return lose_to(events.error);
    if (!events.shown || !waiting_) return;
    std::exchange(waiting_, nullptr)(events.shown);
  }

  // The kernel announced something about displays: not necessarily this one.
  void displays_changed() {
    if (!uevents_.read_all()) return;
    if (problem_) {
      const std::string before = *problem_;
      look_again();
      if (!problem_) return tell_recovery();
      // Back, but of no use: another sentence than that it is away.
      if (*problem_ != before) lose(*problem_);
      return;
    }
    const Connector now = output_->connector();
    if (now.name.empty()) return lose_card();
    if (now.status == Connector::Status::Disconnected) return lose(output_->name() + " was unplugged");
    const bool has_mode =
        std::ranges::any_of(now.modes, [&](const Mode& mode) { return same_timing(mode, output_->mode()); });
    if (!has_mode) {
      lose(output_->name() + " no longer has its mode " + describe(output_->mode()) +
           "; modes: " + describe(now.modes));
      look_again();  // another display may have the like
      if (!problem_) tell_recovery();
      return;
    }
    if (!output_->card().is_master()) lose_to(EACCES);
  }

  void keep_looking(bool on) noexcept {
    if (on == looking_) return;
    looking_ = on;
    const itimerspec every{on ? kLookInterval : timespec{}, on ? kLookInterval : timespec{}};
    ::timerfd_settime(look_.get(), 0, &every, nullptr);
  }

  // The kernel does not say that another program has become the card's master, and may show what it likes.
  void look_after_card() {
    std::uint64_t times = 0;
    if (::read(look_.get(), &times, sizeof times) != sizeof times || problem_) return;
    if (!output_->card().is_master()) lose_to(EACCES);
  }

  // A call that should have put a picture on the screen did not.
  void lose_to(int error) {
    if (error == EACCES || error == EPERM)
      return lose("another program took " + output_->name() +
                  " over: " + describe_master_holder(output_->card().path()));
    if (error == ENODEV) return lose_card();
    lose(output_->name() + " does not show pictures any more: " + std::strerror(error));
  }

  void lose_card() {
    lose(output_->name() + " is gone, with its card");
    card_watch_.reset();
    output_.reset();
  }

  // The owner of the light is told first; then the screen, where a mask may still stand, goes off.
  void lose(const std::string& why) {
    keep_looking(false);
    problem_ = why;
    const Presented waiting = std::exchange(waiting_, nullptr);
    tell(Disturbance::Kind::Interruption, why);
    if (problem_ && output_) output_->turn_off();
    if (waiting) waiting(std::nullopt);
  }

  void tell(Disturbance::Kind kind, const std::string& what) {
    if (on_disturbance_) on_disturbance_({kind, what});
  }

  void tell_recovery() {
    Disturbance recovery{.kind = Disturbance::Kind::Recovery,
                         .what = "the display is back: " + description()};
    if (warning_) recovery.warnings.push_back(*warning_);
    if (on_disturbance_) on_disturbance_(recovery);
  }

  // For a show() or black() that must not call back from within itself.
  void deny_later() { ::eventfd_write(wake_.get(), 1); }
  void lose_later(int error) {
    failed_show_ = error;
    deny_later();
  }
  void deny_waiting() {
    eventfd_t count = 0;
    ::eventfd_read(wake_.get(), &count);
    const int error = std::exchange(failed_show_, 0);
    if (error != 0 && !problem_) return lose_to(error);
    if (problem_ && waiting_) std::exchange(waiting_, nullptr)(std::nullopt);
  }

  DescriptorWatcher& watcher_;
  DrmDisplayConfig config_;
  std::function<void(const Disturbance&)> on_disturbance_;
  std::unique_ptr<Output> output_;  // none before the first was found, and while its card is gone
  std::optional<std::string> problem_, warning_;
  Presented waiting_;
  int failed_show_ = 0;  // the errno of a show() or black() whose owner has not been told yet
  std::size_t bytes_written_ = 0;

  UeventSocket uevents_;
  FileDescriptor wake_;
  FileDescriptor look_;  // a timer's, that runs while a mask is on the screen
  bool looking_ = false;
  std::unique_ptr<DescriptorWatcher::Watch> uevent_watch_, wake_watch_, look_watch_, card_watch_;
};

DrmDisplay::DrmDisplay(DescriptorWatcher& watcher, const DrmDisplayConfig& config)
    : implementation_(std::make_unique<Implementation>(watcher, config)) {}

DrmDisplay::~DrmDisplay() = default;

Pixels DrmDisplay::width() const {
  return implementation_->config().width;
}
Pixels DrmDisplay::height() const {
  return implementation_->config().height;
}
Duration DrmDisplay::frame() const {
  return implementation_->frame();
}

void DrmDisplay::show(const Mask& mask, Presented done) {
  implementation_->show(mask, std::move(done));
}
void DrmDisplay::black(Presented done) {
  implementation_->black(std::move(done));
}
void DrmDisplay::black_now() noexcept {
  implementation_->black_now();
}

void DrmDisplay::look_again() {
  implementation_->look_whether_back();
}

void DrmDisplay::on_disturbance(std::function<void(const Disturbance&)> call) {
  implementation_->on_disturbance(std::move(call));
}
std::optional<std::string> DrmDisplay::problem() const {
  return implementation_->problem();
}
std::optional<std::string> DrmDisplay::warning() const {
  return implementation_->warning();
}
std::string DrmDisplay::description() const {
  return implementation_->description();
}
std::size_t DrmDisplay::bytes_written() const {
  return implementation_->bytes_written();
}

}  // namespace contourd
