#include "hw/simulated_printer.hpp"

#include <cstdio>
#include <fstream>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "hw/png_file.hpp"
#include "hw/simulated_axis.hpp"

namespace contourd {

// Records the pictures and the light of a job in a file, as lines "time in ns, tab, event": when each picture
// came onto the screen, by the name of its file or as "black", and when the light went on and off.
class SimulatedPrinter::Recording {
 public:
  explicit Recording(Clock& clock) : clock_(clock) {}

  // Ends the record, and begins another one in this file, if there is one.
  void begin(const std::optional<std::filesystem::path>& path) {
    file_.close();
    if (path) file_.open(*path, std::ios::trunc);
  }
  void add(std::string_view event) {
    if (file_.is_open()) file_ << clock_.now().time_since_epoch().count() << '\t' << event << std::endl;
  }

 private:
  Clock& clock_;
  std::ofstream file_;
};

// The lit pixels of a mask, and the sides between them and dark ones.
struct LitExtent {
  std::int64_t pixels = 0, sides = 0;
};

LitExtent extent_of(const Mask& mask) {
  constexpr std::uint8_t kLit = 128;
  LitExtent extent;
  std::vector<std::uint8_t> above(static_cast<std::size_t>(mask.width().count()), 0);
  for (std::int32_t y = 0; y < mask.height().count(); ++y) {
    const auto row = mask.row(y);
    bool left = false;
    for (std::size_t x = 0; x < above.size(); ++x) {
      const bool lit = row[x] >= kLit;
      extent.pixels += lit;
      extent.sides += (lit != left) + (lit != (above[x] != 0));
      left = lit;
      above[x] = lit;
    }
    extent.sides += left;
  }
  return extent;
}

// A screen that saves the masks it shows as 0001.png, 0002.png, ...
class SimulatedPrinter::Screen final : public MaskDisplay {
 public:
  // Calls `unplugged` when the configuration says that the display is unplugged now.
  Screen(Clock& clock, const SimulatedDisplayConfig& config, Recording& recording,
         std::function<void()> unplugged)
      : clock_(clock), config_(config), recording_(recording), unplugged_(std::move(unplugged)) {}

  [[nodiscard]] Pixels width() const override { return config_.width; }
  [[nodiscard]] Pixels height() const override { return config_.height; }
  [[nodiscard]] Duration frame() const override { return config_.frame; }

  void show(const Mask& mask, Presented done) override {
    expects(mask.width() == config_.width && mask.height() == config_.height,
            "the mask has the display's size");
    const bool unplugged_now = config_.lost_after_frames && frames_++ == *config_.lost_after_frames;
    if (unplugged_now || !connected_) return lose(std::move(done));
    ++masks_shown_;
    if (measures_) extent_ = extent_of(mask);
    if (folder_) write_png(*folder_ / file_name(masks_shown_), mask);
    present(masks_shown_, next_refresh(), std::move(done));
  }

  void black(Presented done) override {
    if (!connected_) return lose(std::move(done));
    present(std::nullopt, next_refresh(), std::move(done));
  }

  void connect(bool connected) {
    connected_ = connected;
    if (!connected) turn_black();
  }

  void black_now() noexcept override {
    turn_black();
    refresh_.reset();
  }

  [[nodiscard]] std::vector<std::string> why_not_ready() const override {
    if (connected_) return {};
    return {"the display is unplugged"};
  }
  [[nodiscard]] std::string description() const override { return "simulated"; }

  // Measures every mask from now on, for last_extent().
  void measure() { measures_ = true; }
  // Returns the extent of the last mask.
  [[nodiscard]] const LitExtent& last_extent() const { return extent_; }

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

  void turn_black() {
    if (!std::exchange(black_, true)) recording_.add("black");
  }

  // Presents a mask, by its number, or black.
  void present(std::optional<int> mask, TimePoint at, Presented done) {
    refresh_ = clock_.call_at(at, [this, mask, at, done = std::move(done)] {
      if (mask && connected_) {
        black_ = false;
        recording_.add(file_name(*mask));
      } else {
        turn_black();
      }
      done(connected_ ? std::optional(at) : std::nullopt);
    });
  }

  void lose(Presented done) {
    refresh_ = clock_.call_after(Duration{0}, [this, done = std::move(done)] {
      turn_black();
      if (connected_) unplugged_();
      // unplugged_() may have led to black_now(), which drops `done`.
      if (refresh_) done(std::nullopt);
    });
  }

  Clock& clock_;
  SimulatedDisplayConfig config_;
  Recording& recording_;
  std::function<void()> unplugged_;
  bool connected_ = true;
  int frames_ = 0;  // requested so far, in all jobs
  bool measures_ = false;
  LitExtent extent_;
  std::optional<std::filesystem::path> folder_;
  int masks_shown_ = 0;
  bool black_ = true;
  std::unique_ptr<Timer> refresh_;
};

class SimulatedPrinter::Lamp final : public Projector {
 public:
  // Calls `switched` when the light has gone on (true) or off (false).
  Lamp(Clock& clock, const SimulatedProjectorConfig& config, std::function<void(bool)> switched)
      : clock_(clock), config_(config), switched_(std::move(switched)) {}

  void power_on(Done done) override {
    reply(
        powered_ ? config_.reply : config_.reply + config_.warm_up, [this] { powered_ = true; },
        std::move(done));
  }

  void light_on(Duration, LightOn tell) override {
    dark_ = nullptr;
    span_.reset();
    if (!powered_) {
      reply_ = clock_.call_after(config_.reply, [this, done = std::move(tell.done)] {
        failed_ = ProjectorReply::Refused;
        done(failed_);
      });
      return;
    }
    // The lamp obeys at the moment when it answers, so its latency is the reply time.
    span_ = LightSpan{clock_.now() + config_.reply, {}, {}, {}};
    sent_ = clock_.call_after(
        Duration{0}, [sent = std::move(tell.sent), earliest = span_->on_earliest] { sent(earliest); });
    reply(
        config_.reply,
        [this] {
          light_ = true;
          span_->on_latest = clock_.now();
          switched_(true);
        },
        std::move(tell.done));
  }

  void light_off() noexcept override {
    if (span_ && !span_->off_earliest) {
      span_->off_earliest = clock_.now();
      if (!is_silent()) span_->off_latest = clock_.now();
    }
    if (std::exchange(light_, false)) switched_(false);
    reply_.reset();
    sent_.reset();
    tell_dark();
  }

  void when_dark(std::function<void()> call) override {
    dark_ = std::move(call);
    tell_dark();
  }

  [[nodiscard]] std::optional<LightSpan> last_light() const override { return span_; }

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

  [[nodiscard]] std::string last_problem() const override {
    if (failed_ == ProjectorReply::Ok) return "ok";
    return failed_ == ProjectorReply::NoAnswer ? "the projector does not answer"
                                               : "the projector refused the command";
  }
  [[nodiscard]] std::string light_off_unconfirmed() const override {
    return is_silent() && span_ ? "the projector has not confirmed that its light is off" : "";
  }

  void confirm_dark(Done done) override {
    light_off();
    reply(
        config_.reply, [] {}, std::move(done));
  }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {}; }
  [[nodiscard]] std::string description() const override { return "simulated"; }

  [[nodiscard]] bool is_on() const { return light_; }

 private:
  [[nodiscard]] bool is_silent() const {
    return config_.silent_after_commands && commands_ > *config_.silent_after_commands;
  }

  // A projector that has fallen silent confirms nothing.
  void tell_dark() noexcept {
    if (!dark_ || light_ || is_silent()) return;
    tell_dark_ = clock_.call_after(Duration{0}, [this] {
      if (const auto dark = std::exchange(dark_, nullptr); dark && !light_) dark();
    });
  }

  void reply(Duration delay, const std::function<void()>& effect, Done done) {
    ++commands_;
    const bool silent = is_silent();
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
  std::function<void(bool)> switched_;
  bool powered_ = false;
  bool light_ = false;
  int commands_ = 0;
  ProjectorReply failed_ = ProjectorReply::Ok;  // the last reply that was not Ok
  std::optional<LightSpan> span_;
  std::function<void()> dark_;  // set by when_dark()
  std::unique_ptr<Timer> reply_, sent_, tell_dark_;
};

SimulatedPrinter::SimulatedPrinter(Clock& clock, const SimulatedPrinterConfig& config)
    : clock_(clock),
      config_(config),
      light_until_lid_opens_(config.lid_opened_after_light),
      axis_(std::make_unique<SimulatedAxis>(clock, config.axis)),
      recording_(std::make_unique<Recording>(clock)),
      screen_(std::make_unique<Screen>(clock, config.display, *recording_, [this] { unplug_display(); })),
      lamp_(std::make_unique<Lamp>(clock, config.projector, [this](bool on) { light_switched(on); })) {
  if (config.axis.force) screen_->measure();
}

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

std::string SimulatedPrinter::why_not_ready() const {
  std::string sentences = lid_open_ ? "the lid is open" : "";
  for (const std::string& sentence : screen_->why_not_ready())
    sentences += (sentences.empty() ? "" : "; ") + sentence;
  return sentences;
}

void SimulatedPrinter::open_lid() {
  lid_open_ = true;
  report(MachineEvent::Kind::Interlock, "the lid was opened");
}

void SimulatedPrinter::close_lid() {
  lid_open_ = false;
  report(MachineEvent::Kind::Recovery, "the lid was closed");
}

void SimulatedPrinter::unplug_display() {
  screen_->connect(false);
  if (config_.display.back_after)
    plug_ = clock_.call_after(*config_.display.back_after, [this] { plug_display(); });
  report(MachineEvent::Kind::Interlock, "the display was unplugged");
}

void SimulatedPrinter::plug_display() {
  screen_->connect(true);
  report(MachineEvent::Kind::Recovery, "the display was plugged in again");
}

void SimulatedPrinter::press_emergency_stop() {
  axis_->abort();
  report(MachineEvent::Kind::Fault, "the emergency stop was pressed", true);
}

// Cures what the screen has shown last. Its perimeter is that along the sides of pixels.
void SimulatedPrinter::cure() {
  const LitExtent& extent = screen_->last_extent();
  const double side_mm = config_.axis.force->pixel_mm;
  axis_->cure(static_cast<double>(extent.pixels) * side_mm * side_mm,
              static_cast<double>(extent.sides) * side_mm);
}

void SimulatedPrinter::light_switched(bool on) {
  recording_->add(on ? "light on" : "light off");
  if (!on && config_.axis.force) cure();
  if (!light_until_lid_opens_) return;
  if (!on) {
    *light_until_lid_opens_ -= clock_.now() - light_on_at_;
    return lid_.reset();
  }
  light_on_at_ = clock_.now();
  lid_ = clock_.call_after(*light_until_lid_opens_, [this] {
    light_until_lid_opens_.reset();
    lid_ = clock_.call_after(config_.lid_open_for, [this] { close_lid(); });
    open_lid();
  });
}

std::optional<std::filesystem::path> SimulatedPrinter::begin_job(std::string_view name) {
  if (!screen_->config().masks) {
    screen_->keep_masks_in(std::nullopt);
    recording_->begin(std::nullopt);
    return std::nullopt;
  }
  const std::filesystem::path folder = *screen_->config().masks / name;
  std::filesystem::create_directories(folder);
  // An earlier job of that name may have left masks.
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") std::filesystem::remove(entry.path());
  }
  screen_->keep_masks_in(folder);
  std::filesystem::path record = folder;
  recording_->begin(record += ".shown.tsv");
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
