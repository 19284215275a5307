#include "hw/real_machine.hpp"

#include <exception>
#include <initializer_list>
#include <utility>

#include "hw/projector_with_light_line.hpp"

namespace contourd {
namespace {

// Opens a device unless it is open already. True if it was opened now; if it cannot be, `missing` says why.
template <typename Device, typename Open>
bool open(std::unique_ptr<Device>& device, std::string& missing, Open open_device) {
  if (device) return false;
  try {
    device = open_device();
    missing.clear();
  } catch (const std::exception& error) {
    missing = error.what();
  }
  return device != nullptr;
}

void add(std::string& sentences, const std::string& sentence) {
  if (!sentence.empty()) sentences += (sentences.empty() ? "" : "; ") + sentence;
}

}  // namespace

RealMachine::RealMachine(Clock& clock, DescriptorWatcher& watcher, LightWatchdog& watchdog,
                         const RealMachineConfig& config)
    : RealMachine(clock, watcher, watchdog, config, Openers{}) {}

RealMachine::RealMachine(Clock& clock, DescriptorWatcher& watcher, LightWatchdog& watchdog,
                         RealMachineConfig config, Openers openers)
    : clock_(clock),
      watcher_(watcher),
      watchdog_(watchdog),
      config_(std::move(config)),
      openers_(std::move(openers)),
      no_projector_(clock),
      no_display_(clock, config_.display.width, config_.display.height),
      no_axis_(clock, config_.axis.travel),
      watched_(no_projector_, watchdog, [this] { offer_light_paths(); }) {
  add_openers();
  open_missing();
  watchdog_.on_trouble(
      [this](const std::string& what) { tell({.kind = MachineEvent::Kind::Interlock, .what = what}); });
  watchdog_.on_recovery([this](const std::string& problem) {
    tell({.kind = MachineEvent::Kind::Recovery,
          .what = "the light watchdog is running again",
          .warnings = {problem}});
  });
  if (missing_.any() || display_lost()) search_after(kSearchInterval);
}

void RealMachine::add_openers() {
  if (!openers_.axis) openers_.axis = [this] { return open_device(config_.axis, clock_, watcher_); };
  if (!openers_.light)
    openers_.light = [this] { return std::make_unique<GpioLightLine>(config_.light.value(), clock_); };
  if (!openers_.projector)
    openers_.projector = [this] { return open_device(config_.projector.value(), clock_, watcher_); };
  if (!openers_.display) openers_.display = [this] { return open_device(config_.display, clock_, watcher_); };
}

RealMachine::~RealMachine() {
  make_safe(*this);
  if (axis_) axis_->set_light_cutoff(nullptr);  // the light is destroyed before the axis
}

// Opens the devices in an order in which nothing else can fail before the light is off.
std::vector<RealMachine::Found> RealMachine::open_missing() {
  std::vector<Found> found;
  const auto forward = [this](const MachineEvent& event) { tell(event); };
  const bool light_came = config_.light && open_light();
  if (light_came) found.push_back({light_description(), {}});
  const bool projector_came = config_.projector && find_projector();
  if (projector_came) found.push_back({"projector: " + projector_->description(), projector_->warnings()});
  combine_projector();
  projector().light_off();
  if (projector_came) projector_->power_off_if_on();
  if (open(display_, missing_.display, openers_.display)) {
    display_->on_event(forward);
    if (!display_lost()) found.push_back({"display: " + display_->description(), display_->warnings()});
  }
  if (axis_ && axis_->lost()) axis_.reset();
  const bool axis_came = open(axis_, missing_.axis, openers_.axis);
  if (axis_came) {
    axis_->on_event(forward);
    found.push_back({"axis: " + axis_->description(), axis_->warnings()});
  }
  if (axis_ && (light_came || axis_came)) axis_->set_light_cutoff(light_.get());
  offer_light_paths();
  return found;
}

// Opens the light line. A line that refuses to go off is opened again, because its chip may have been
// unplugged and be back.
bool RealMachine::open_light() {
  if (light_ && light_->refusal().empty()) {
    const bool was_lost = !std::exchange(missing_.light, "").empty();
    return was_lost;
  }
  const std::string refusal = light_ ? light_->refusal() : no_light_.refusal();
  projector().light_off();  // also drops callbacks that wait for combined_
  watched_.watch(no_projector_);
  combined_.reset();
  if (axis_) axis_->set_light_cutoff(nullptr);
  light_.reset();
  if (!open(light_, missing_.light, openers_.light)) {
    no_light_.lose(refusal);
    if (!refusal.empty()) missing_.light = "the light may be on: " + refusal + "; " + missing_.light;
    return false;
  }
  no_light_.lose("");
  light_->on_event([this](const MachineEvent& event) { tell(event); });
  return true;
}

bool RealMachine::find_projector() {
  if (projector_ && !projector_->lost()) return false;
  watched_.watch(no_projector_);
  combined_.reset();
  projector_.reset();
  if (!open(projector_, missing_.projector, openers_.projector)) return false;
  projector_->on_event([this](const MachineEvent& event) { tell(event); });
  projector_->may_warm_up();
  return true;
}

void RealMachine::combine_projector() {
  // While the projector is missing, its line stays off and unused. While the line is missing, its stand-in
  // takes its place: the projector by itself knows of no line.
  if (!combined_ && config_.light && projector_) {
    LightLine& line = light_ ? static_cast<LightLine&>(*light_) : no_light_;
    combined_ = std::make_unique<ProjectorWithLightLine>(*projector_, line, clock_);
  } else if (!combined_ && light_ && !config_.projector) {
    combined_ = std::make_unique<LightLineProjector>(*light_, clock_, config_.warm_up);
  }
  if (combined_)
    watched_.watch(*combined_);
  else if (projector_)
    watched_.watch(*projector_);
}

// Runs before every light on, because the display may have another mode by then. Withdraws lost devices from
// the watchdog: as long as it held them, they could not be opened again.
void RealMachine::offer_light_paths() {
  watchdog_.set_line(light_ && light_->refusal().empty() ? light_->descriptor() : -1);
  watchdog_.set_serial(projector_ ? projector_->light_off_path() : LightSerialPath{});
  watchdog_.set_display(display_ ? display_->black_path() : LightDisplayPath{});
}

void RealMachine::search() {
  std::vector<Found> found;
  if (missing_.any()) found = open_missing();
  if (display_) display_->probe_again();
  if (missing_.any() || display_lost()) search_after(kSearchInterval);
  for (const Found& each : found)
    tell({.kind = MachineEvent::Kind::Recovery, .what = "found " + each.device, .warnings = each.warnings});
}

void RealMachine::tell(const MachineEvent& event) {
  note_losses(event.what);
  if (on_event_) on_event_(event);
}

// Marks lost devices as missing. They are closed by the next search rather than here, inside their own
// callback.
void RealMachine::note_losses(const std::string& what) {
  const bool projector_lost = projector_ && projector_->lost() && missing_.projector.empty();
  const bool axis_lost = axis_ && axis_->lost() && missing_.axis.empty();
  const bool light_lost = light_ && !light_->refusal().empty() && missing_.light.empty();
  if (light_lost) missing_.light = "the light may be on: " + light_->refusal();
  if (projector_lost) missing_.projector = what;
  offer_light_paths();
  if (axis_lost) missing_.axis = what;
  // Search soon: the light may be on, and a serial adapter that is plugged in again gets its old name only
  // after its old descriptor was closed.
  if (projector_lost || light_lost) return search_after(kFirstSearch);
  if (axis_lost || display_lost()) search_after(kSearchInterval);
}

ZAxis& RealMachine::z_axis() {
  if (axis_) return *axis_;
  return no_axis_;
}

MaskDisplay& RealMachine::display() {
  if (display_) return *display_;
  return no_display_;
}

std::string RealMachine::why_not_ready() const {
  std::string sentences;
  for (const std::string* missing : {&missing_.light, &missing_.projector, &missing_.display, &missing_.axis})
    add(sentences, *missing);
  add(sentences, watchdog_.problem());
  for (const Device* device :
       std::initializer_list<const Device*>{projector_.get(), display_.get(), axis_.get()}) {
    for (const std::string& why : device != nullptr ? device->why_not_ready() : std::vector<std::string>{})
      add(sentences, why);
  }
  return sentences;
}

std::vector<std::string> RealMachine::description() const {
  std::vector<std::string> sentences;
  if (light_) sentences.push_back(light_description());
  if (projector_) sentences.push_back("projector: " + projector_->description());
  if (display_ && !display_lost()) sentences.push_back("display: " + display_->description());
  if (axis_) sentences.push_back("axis: " + axis_->description());
  return sentences;
}

std::vector<std::string> RealMachine::warnings() const {
  std::vector<std::string> sentences;
  if (axis_) sentences = axis_->warnings();
  for (const std::string& warning : projector_ ? projector_->warnings() : std::vector<std::string>{})
    sentences.push_back(warning);
  for (const std::string& refusal : watchdog_.refusals())
    sentences.push_back(refusal);
  for (std::string& warning : display_ ? display_->warnings() : std::vector<std::string>{})
    sentences.push_back(std::move(warning));
  return sentences;
}

}  // namespace contourd
