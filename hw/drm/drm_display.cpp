#include "hw/drm/drm_display.hpp"

#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <system_error>
#include <utility>

#include "hw/drm/blocking_calls.hpp"
#include "hw/drm/display_probe.hpp"
#include "hw/drm/master_holder.hpp"
#include "hw/drm/output.hpp"
#include "hw/drm/uevent_socket.hpp"
#include "hw/event_descriptor.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

FileDescriptor made_timerfd() {
  FileDescriptor fd(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!fd.valid()) throw std::system_error(errno, std::generic_category(), "making a timerfd");
  return fd;
}

// While a mask is on the screen, or a flip waits, the card is looked after this often: a refresh or so.
constexpr timespec kLookInterval{0, 20'000'000};

}  // namespace

// It is larger than other classes: what is on the screen, what waits for it and what watches over the card
// change together whenever the kernel says something.
class DrmDisplay::Implementation {
 public:
  Implementation(DescriptorWatcher& watcher, const DrmDisplayConfig& config)
      : watcher_(watcher),
        config_(config),
        look_(made_timerfd()),
        uevent_watch_(watcher.when_readable(uevents_.fd(), [this] { displays_changed(); })),
        wake_watch_(watcher.when_readable(wake_.descriptor(), [this] { deny_waiting(); })),
        look_watch_(watcher.when_readable(look_.get(), [this] { look_after_card(); })),
        calls_(watcher) {
    OutputSearch search = find_output(config_);
    if (search.found) {
      DisplayProbe probe = open_display(std::move(*search.found), config_);
      take_back(std::move(probe.output));
      use(probe.console_warning);
    } else {
      problem_ = search.why_not;
    }
  }

  void show(const Mask& mask, Presented done) {
    waiting_ = std::move(done);
    if (problem_) return deny_later();
    bytes_written_ = output_->write(mask);
    if (const int error = output_->show_written(); error != 0) return lose_later(error);
    mask_is_up_ = true;
    keep_looking(true);
  }

  void black(Presented done) {
    mask_is_up_ = false;
    waiting_ = std::move(done);
    if (problem_) return deny_later();
    if (const int error = output_->show_black(); error != 0) return lose_later(error);
    keep_looking(true);
  }

  void black_now() noexcept {
    mask_is_up_ = false;
    waiting_ = nullptr;
    denied_ = false;
    if (!output_) return;  // the other thread, if it has it, leaves it dark in any case
    const int error = output_->black_now();
    if (problem_) return;
    if (error != 0) return lose_later(error);
    keep_looking(true);
  }

  // What else has become of it the kernel announces.
  void look_whether_back() {
    if (problem_) probe_again(Tell::Recovery);
  }

  void on_event(std::function<void(const MachineEvent&)> call) { on_event_ = std::move(call); }

  [[nodiscard]] const DrmDisplayConfig& config() const { return config_; }
  [[nodiscard]] Duration frame() const { return frame_; }
  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }
  [[nodiscard]] std::size_t bytes_written() const { return bytes_written_; }
  [[nodiscard]] LightDisplayPath black_path() const {
    if (!output_) return {};
    return {output_->card().fd(), output_->crtc_id(), output_->connector_id(), output_->black_id(),
            std::bit_cast<DisplayModeBytes>(output_->mode())};
  }
  [[nodiscard]] const std::string& description() const { return description_; }

 private:
  // The output is the other thread's from here to the end of its call: nothing is shown meanwhile.
  std::shared_ptr<Output> give_away_output() {
    card_watch_.reset();
    return std::exchange(output_, nullptr);
  }
  void take_back(std::shared_ptr<Output> output) {
    away_ = false;
    output_ = std::move(output);
    if (output_) card_watch_ = watcher_.when_readable(output_->card().fd(), [this] { flip_done(); });
  }

  enum class Tell { Recovery, EverythingNew };
  // Looks whether a lost display is back, on the thread for blocking calls, and takes it up again if so.
  void probe_again(Tell tell) {
    if (away_) {
      probe_wanted_ = true;
      return;
    }
    away_ = true;
    calls_.run(
        [output = give_away_output(), config = config_]() mutable {
          return output ? restored(std::move(output), config) : probe_all(config);
        },
        [this, tell](DisplayProbe probe) { after_probe(std::move(probe), tell); });
  }

  void after_probe(DisplayProbe probe, Tell tell_what) {
    take_back(std::move(probe.output));
    if (probe.is_back) {
      use(probe.console_warning);
      tell_recovery();
    } else if (tell_what == Tell::EverythingNew && !probe.refusal.empty() && probe.refusal != *problem_) {
      problem_ = probe.refusal;
      tell(MachineEvent::Kind::Interlock, probe.refusal);
    }
    look_if_wanted();
  }

  void look_if_wanted() {
    if (std::exchange(probe_wanted_, false) && problem_) probe_again(Tell::EverythingNew);
  }

  void turn_off() {
    if (away_ || !output_) return;
    away_ = true;
    calls_.run(
        [output = give_away_output()]() mutable {
          output->turn_off();
          return std::move(output);
        },
        [this](std::shared_ptr<Output> output) {
          take_back(std::move(output));
          look_if_wanted();
        });
  }

  // Of the output that there is now.
  void use(const std::optional<std::string>& console_warning) {
    problem_.reset();
    warnings_ = output_->color_warnings();
    if (console_warning) warnings_.push_back(*console_warning);
    frame_ = output_->frame();
    description_ =
        output_->name() + ": " + describe(output_->mode()) + (output_->is_atomic() ? ", atomic" : ", legacy");
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
    const std::vector<DisplayChange> changes = uevents_.read_all();
    if (changes.empty()) return;
    if (problem_) return probe_again(Tell::EverythingNew);
    const dev_t card = output_->card().number();
    const std::uint32_t connector = output_->connector_id();
    if (std::ranges::any_of(changes, [&](const auto& change) { return concerns(change, card, connector); }))
      ask_display();
  }

  // What it is, which may take it long: a mask may be on the screen, and the light on.
  void ask_display() {
    if (!output_->card().is_master()) return lose_to(EACCES);
    ask_again_ = asking_;
    if (std::exchange(asking_, true)) return;
    calls_.run([output = output_] { return output->connector(); },
               [this](const Connector& now) {
                 asking_ = false;
                 if (!problem_) judge(now);
                 const bool again = std::exchange(ask_again_, false);
                 if (again && problem_) return probe_again(Tell::EverythingNew);
                 if (again) ask_display();
               });
  }

  void judge(const Connector& now) {
    if (now.name.empty()) return lose_card();
    if (now.status == Connector::Status::Disconnected) return lose(output_->name() + " was unplugged");
    const bool has_mode =
        std::ranges::any_of(now.modes, [&](const Mode& mode) { return same_timing(mode, output_->mode()); });
    if (has_mode) return;
    lose(output_->name() + " no longer has its mode " + describe(output_->mode()) +
         "; modes: " + describe(now.modes));
    probe_again(Tell::EverythingNew);  // another display may have the like
  }

  void keep_looking(bool on) noexcept {
    if (on == looking_) return;
    looking_ = on;
    const itimerspec every{on ? kLookInterval : timespec{}, on ? kLookInterval : timespec{}};
    ::timerfd_settime(look_.get(), 0, &every, nullptr);
  }

  // The kernel does not say that another program has become the card's master, and may show what it likes;
  // nor that it owes its word for a flip.
  void look_after_card() {
    std::uint64_t times = 0;
    if (::read(look_.get(), &times, sizeof times) != sizeof times || problem_) return;
    if (!output_->card().is_master()) return lose_to(EACCES);
    if (output_->flip_is_overdue()) return lose_flip();
    if (!mask_is_up_ && !output_->flip_waits()) keep_looking(false);
  }

  // Where this program was held up, the kernel's word may be there all the same.
  void lose_flip() {
    flip_done();
    if (problem_ || !output_->flip_is_overdue()) return;
    const auto deadline = std::chrono::round<std::chrono::milliseconds>(flip_deadline(frame_));
    report_loss(output_->name() + " has not said for " + std::to_string(deadline.count()) +
                " ms that it shows a picture; it is set anew");
    probe_again(Tell::EverythingNew);
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
    report_loss(output_->name() + " is gone, with its card");
    calls_.run([output = give_away_output()]() mutable { return output.reset(), 0; }, [](int) {});
  }

  void lose(const std::string& why) {
    report_loss(why);
    turn_off();
  }

  // The owner of the light is told first; then the screen, where a mask may still stand, is seen to.
  void report_loss(const std::string& why) {
    mask_is_up_ = false;
    keep_looking(false);
    problem_ = why;
    const Presented waiting = std::exchange(waiting_, nullptr);
    tell(MachineEvent::Kind::Interlock, why);
    if (waiting) waiting(std::nullopt);
  }

  void tell(MachineEvent::Kind kind, const std::string& what) {
    if (on_event_) on_event_({kind, what});
  }

  void tell_recovery() {
    if (on_event_)
      on_event_({.kind = MachineEvent::Kind::Recovery,
                 .what = "the display is back: " + description_,
                 .warnings = warnings_});
  }

  // For a show() or black() that must not call back from within itself.
  void deny_later() {
    denied_ = true;
    wake_.signal();
  }
  void lose_later(int error) {
    failed_show_ = error;
    wake_.signal();
  }
  void deny_waiting() {
    wake_.clear();
    const int error = std::exchange(failed_show_, 0);
    if (error != 0 && !problem_) return lose_to(error);
    // Also when the display has come back since.
    if (std::exchange(denied_, false) && waiting_) std::exchange(waiting_, nullptr)(std::nullopt);
  }

  DescriptorWatcher& watcher_;
  DrmDisplayConfig config_;
  std::function<void(const MachineEvent&)> on_event_;
  // None before the first was found, while its card is gone, and while the other thread has it. There
  // is one when there is no problem.
  std::shared_ptr<Output> output_;
  std::optional<std::string> problem_;
  std::vector<std::string> warnings_;
  std::string description_ = "no display";
  Duration frame_{0};
  Presented waiting_;
  bool denied_ = false;  // waiting_ is to be told that nothing can be shown
  int failed_show_ = 0;  // the errno of a show() or black() whose owner has not been told yet
  std::size_t bytes_written_ = 0;

  UeventSocket uevents_;
  EventDescriptor wake_;
  FileDescriptor look_;  // a timer's, that runs while a mask is on the screen or a flip waits
  bool looking_ = false;
  bool mask_is_up_ = false;
  bool away_ = false;          // the other thread has the output, or looks for one
  bool probe_wanted_ = false;  // again, when it is done with that
  bool asking_ = false, ask_again_ = false;
  std::unique_ptr<DescriptorWatcher::Watch> uevent_watch_, wake_watch_, look_watch_, card_watch_;
  BlockingCalls calls_;  // last: nothing is handed back once the rest goes
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

void DrmDisplay::probe_again() {
  implementation_->look_whether_back();
}

void DrmDisplay::on_event(std::function<void(const MachineEvent&)> call) {
  implementation_->on_event(std::move(call));
}
std::vector<std::string> DrmDisplay::why_not_ready() const {
  if (const auto problem = implementation_->problem()) return {*problem};
  return {};
}
std::vector<std::string> DrmDisplay::warnings() const {
  return implementation_->warnings();
}
std::string DrmDisplay::description() const {
  return implementation_->description();
}
LightDisplayPath DrmDisplay::black_path() const {
  return implementation_->black_path();
}
std::size_t DrmDisplay::bytes_written() const {
  return implementation_->bytes_written();
}

}  // namespace contourd
