#include "hw/drm/drm_display.hpp"

#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "hw/drm/blocking_calls.hpp"
#include "hw/drm/color.hpp"
#include "hw/drm/crtc_route.hpp"
#include "hw/drm/output.hpp"
#include "hw/drm/uevent_socket.hpp"
#include "hw/event_descriptor.hpp"
#include "hw/hardware_error.hpp"
#include "hw/mask_display.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {
namespace {

FileDescriptor made_timerfd() {
  FileDescriptor fd(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!fd.valid()) throw std::system_error(errno, std::generic_category(), "creating a timerfd");
  return fd;
}

// How often the card is checked while a mask is on the screen or a flip is pending: about every refresh.
constexpr timespec kCheckInterval{0, 20'000'000};

class DrmDisplay final : public MaskDisplay {
 public:
  // Sets the mode, with a black picture. A display that is not connected counts as lost, and
  // why_not_ready() says why. Throws HardwareError for an error that waiting does not fix: no such card,
  // connector, mode or format, a card in use, no permission. The watcher must outlive this object. Blocks for
  // some refreshes, and for some milliseconds (with some displays 300 or more) per connected display.
  DrmDisplay(DescriptorWatcher& watcher, const DrmDisplayConfig& config)
      : watcher_(watcher),
        config_(config),
        check_timer_(made_timerfd()),
        uevent_watch_(watcher.when_readable(uevents_.fd(), [this] { displays_changed(); })),
        wake_watch_(watcher.when_readable(wake_.descriptor(), [this] { deny_waiting(); })),
        check_watch_(watcher.when_readable(check_timer_.get(), [this] { check_card(); })),
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

  [[nodiscard]] Pixels width() const override { return config_.width; }
  [[nodiscard]] Pixels height() const override { return config_.height; }
  // Returns the refresh period of the mode; 0 before a display was found.
  [[nodiscard]] Duration frame() const override { return frame_; }

  // Neither show() nor black() allocates or blocks.
  void show(const Mask& mask, Presented done) override {
    waiting_ = std::move(done);
    if (problem_) return deny_later();
    output_->write(mask);
    if (const int error = output_->show_written(); error != 0) return lose_later(error);
    mask_is_up_ = true;
    keep_checking(true);
  }

  void black(Presented done) override {
    mask_is_up_ = false;
    waiting_ = std::move(done);
    if (problem_) return deny_later();
    if (const int error = output_->show_black(); error != 0) return lose_later(error);
    keep_checking(true);
  }

  // Does not block. If a flip is pending, black follows it, and a mask that the flip would show is blackened
  // in its memory. A commit that waits for the driver (10 s or more, the kernel's limit, if the driver hangs)
  // would not be faster.
  void black_now() noexcept override {
    mask_is_up_ = false;
    waiting_ = nullptr;
    denied_ = false;
    if (!output_) return;  // if the other thread has the output, it leaves the screen dark in any case
    const int error = output_->black_now();
    if (problem_) return;
    if (error != 0) return lose_later(error);
    keep_checking(true);
  }

  // Reports only a recovery: the kernel announces every other change. Needed because the kernel does not
  // notify us when another program drops DRM master.
  void probe_again() override {
    if (problem_) probe(Report::Recovery);
  }

  // `call` runs from the event loop: when the display is lost, before its pending `done`, and when it has
  // been restored.
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }

  // Returns at most one sentence: why nothing can be shown.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override {
    if (problem_) return {*problem_};
    return {};
  }
  // Returns a sentence if the text console may come back, and one for each change that the driver makes to
  // pixel values.
  [[nodiscard]] std::vector<std::string> warnings() const override { return warnings_; }
  // "HDMI-A-1 of /dev/dri/card0 (vc4): 1920x1080 at 60.00 Hz, atomic"
  [[nodiscard]] std::string description() const override { return description_; }

  // Returns the card's descriptor, which is shared, and the ids for showing black. Empty while there is no
  // output.
  [[nodiscard]] LightDisplayPath black_path() const override {
    if (!output_) return {};
    return {output_->card().fd(), output_->crtc_id(), output_->connector_id(), output_->black_id(),
            std::bit_cast<DisplayModeBytes>(output_->mode())};
  }

 private:
  // Hands the output to the other thread until take_back(). Nothing can be shown meanwhile.
  std::shared_ptr<Output> give_away_output() {
    card_watch_.reset();
    return std::exchange(output_, nullptr);
  }
  void take_back(std::shared_ptr<Output> output) {
    away_ = false;
    output_ = std::move(output);
    if (output_) card_watch_ = watcher_.when_readable(output_->card().fd(), [this] { flip_done(); });
  }

  enum class Report { Recovery, RecoveryOrNewProblem };
  // Probes for a lost display on the thread for blocking calls, and uses it again if it is back.
  void probe(Report report) {
    if (away_) {
      probe_wanted_ = true;
      return;
    }
    away_ = true;
    calls_.run(
        [output = give_away_output(), config = config_]() mutable {
          return output ? restored(std::move(output), config) : probe_all(config);
        },
        [this, report](DisplayProbe probe) { after_probe(std::move(probe), report); });
  }

  void after_probe(DisplayProbe probe, Report wanted) {
    take_back(std::move(probe.output));
    if (probe.is_back) {
      use(probe.console_warning);
      report_recovery();
    } else if (wanted == Report::RecoveryOrNewProblem && !probe.refusal.empty() &&
               probe.refusal != *problem_) {
      problem_ = probe.refusal;
      report_event(MachineEvent::Kind::Interlock, probe.refusal);
    }
    probe_if_wanted();
  }

  void probe_if_wanted() {
    if (std::exchange(probe_wanted_, false) && problem_) probe(Report::RecoveryOrNewProblem);
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
          probe_if_wanted();
        });
  }

  // Takes frame, description and warnings from the present output.
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

  // Handles the kernel's announcements about displays, which may be other displays than this one.
  void displays_changed() {
    const std::vector<DisplayChange> changes = uevents_.read_all();
    if (changes.empty()) return;
    if (problem_) return probe(Report::RecoveryOrNewProblem);
    const dev_t card = output_->card().number();
    const std::uint32_t connector = output_->connector_id();
    if (std::ranges::any_of(changes, [&](const auto& change) { return concerns(change, card, connector); }))
      ask_display();
  }

  // Reads the display's state on the other thread, because the call may take long while a mask is on the
  // screen and the light is on.
  void ask_display() {
    if (!output_->card().is_master()) return lose_to(EACCES);
    ask_again_ = asking_;
    if (std::exchange(asking_, true)) return;
    calls_.run([output = output_] { return output->connector(); },
               [this](const Connector& now) {
                 asking_ = false;
                 if (!problem_) judge(now);
                 const bool again = std::exchange(ask_again_, false);
                 if (again && problem_) return probe(Report::RecoveryOrNewProblem);
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
    probe(Report::RecoveryOrNewProblem);  // another display may have such a mode
  }

  void keep_checking(bool on) noexcept {
    if (on == checking_) return;
    checking_ = on;
    const itimerspec every{on ? kCheckInterval : timespec{}, on ? kCheckInterval : timespec{}};
    ::timerfd_settime(check_timer_.get(), 0, &every, nullptr);
  }

  // Checks for the two failures that the kernel does not report: another program has become the card's master
  // and may show anything, or a flip is never confirmed.
  void check_card() {
    std::uint64_t times = 0;
    if (::read(check_timer_.get(), &times, sizeof times) != sizeof times || problem_) return;
    if (!output_->card().is_master()) return lose_to(EACCES);
    if (output_->flip_is_overdue()) return lose_flip();
    if (!mask_is_up_ && !output_->flip_waits()) keep_checking(false);
  }

  // If this program itself was delayed, the confirmation may be waiting to be read, so lose_flip() reads it
  // first.
  void lose_flip() {
    flip_done();
    if (problem_ || !output_->flip_is_overdue()) return;
    const auto deadline = std::chrono::round<std::chrono::milliseconds>(flip_deadline(frame_));
    report_loss(output_->name() + " did not confirm a picture within " + std::to_string(deadline.count()) +
                " ms; its mode is being set again");
    probe(Report::RecoveryOrNewProblem);
  }

  // Handles the failure of a call that should have put a picture on the screen.
  void lose_to(int error) {
    if (error == EACCES || error == EPERM)
      return lose("another program took over " + output_->name() + ": " +
                  describe_master_holder(output_->card().path()));
    if (error == ENODEV) return lose_card();
    lose(output_->name() + " no longer shows pictures: " + std::strerror(error));
  }

  void lose_card() {
    report_loss(output_->name() + " is gone: its graphics card was removed");
    calls_.run([output = give_away_output()]() mutable { return output.reset(), 0; }, [](int) {});
  }

  void lose(const std::string& why) {
    report_loss(why);
    turn_off();
  }

  // Reports the loss. Callers do this first, so that the light goes off before they deal with the screen,
  // which may still show a mask.
  void report_loss(const std::string& why) {
    mask_is_up_ = false;
    keep_checking(false);
    problem_ = why;
    const Presented waiting = std::exchange(waiting_, nullptr);
    report_event(MachineEvent::Kind::Interlock, why);
    if (waiting) waiting(std::nullopt);
  }

  void report_event(MachineEvent::Kind kind, const std::string& what) {
    if (on_event_) on_event_({kind, what});
  }

  void report_recovery() {
    if (on_event_)
      on_event_({.kind = MachineEvent::Kind::Recovery,
                 .what = "the display is back: " + description_,
                 .warnings = warnings_});
  }

  // deny_later() and lose_later() are for show() and black(), which must not call back before they return.
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
    // The request is denied even if the display has come back since.
    if (std::exchange(denied_, false) && waiting_) std::exchange(waiting_, nullptr)(std::nullopt);
  }

  DescriptorWatcher& watcher_;
  DrmDisplayConfig config_;
  std::function<void(const MachineEvent&)> on_event_;
  // Null before the first output was found, while its card is gone, and while the other thread has it. Not
  // null if there is no problem.
  std::shared_ptr<Output> output_;
  std::optional<std::string> problem_;
  std::vector<std::string> warnings_;
  std::string description_ = "no display";
  Duration frame_{0};
  Presented waiting_;
  bool denied_ = false;  // waiting_ is to be called with nullopt
  int failed_show_ = 0;  // the errno of a show() or black() that has not been reported yet

  UeventSocket uevents_;
  EventDescriptor wake_;
  FileDescriptor check_timer_;  // runs while a mask is on the screen or a flip is pending
  bool checking_ = false;
  bool mask_is_up_ = false;
  bool away_ = false;          // the other thread has the output, or probes for one
  bool probe_wanted_ = false;  // another probe is needed when the output is back from the other thread
  bool asking_ = false, ask_again_ = false;
  std::unique_ptr<DescriptorWatcher::Watch> uevent_watch_, wake_watch_, check_watch_, card_watch_;
  BlockingCalls calls_;  // last member: delivers nothing once the destruction of the others begins
};

}  // namespace

std::unique_ptr<MaskDisplay> open_device(const DrmDisplayConfig& config, Clock& /*clock*/,
                                         DescriptorWatcher& watcher) {
  return std::make_unique<DrmDisplay>(watcher, config);
}

DrmReport check_drm_display(const DrmDisplayConfig& config) {
  OutputSearch search = find_output(config);
  if (!search.found) throw HardwareError(search.why_not);
  const Card& card = search.found->card;
  const Connector& connector = search.found->connector;
  const std::string output = connector.name + " of " + card.name();
  const Mode mode = choose_mode(connector.modes, connector.size, config, output);
  const CrtcRoute route = routes_to(card, connector).front();
  check_format(route, config.format, output);

  const bool in_use = !card.is_master();
  std::string state;
  std::optional<std::string> range;
  if (in_use) {
    state = "in use: " + describe_master_holder(card.path());
  } else {
    const ObjectProperties properties(card.fd(), connector.id, DRM_MODE_OBJECT_CONNECTOR);
    range = range_warning(connector.name, mode, properties, output);
    const Framebuffer picture(card, config.width, config.height, config.format);
    const bool atomic = make_crtc(card, connector, mode, picture.id(), config.legacy)->is_atomic();
    state = atomic ? "atomic" : "legacy";
  }
  const auto console = console_of(card.path());
  return {output + ": " + describe(mode) + ", " + state +
              (card.has_vblank(route.crtc_id) ? "" : ", no vblank: presentation times are the driver's") +
              "; formats: " + describe_formats(route.formats) +
              (console ? "; the text console " + console->string() + " is on this card" : "") +
              (range ? "; " + *range : ""),
          in_use};
}

}  // namespace contourd
