#include "daemon/print/rise_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "daemon/print/rise_change.hpp"

namespace contourd {
namespace {

constexpr const char* kUnknownHeight = "the plate's position is unknown";

Nanometers apart(Nanometers a, Nanometers b) {
  return std::max(a, b) - std::min(a, b);
}

}  // namespace

RiseFrames::RiseFrames(Machine& machine, Clock& clock, const PrintPlan& plan, Nanometers solid)
    : machine_(machine), clock_(clock), plan_(plan), masks_(*plan.engine, clock, plan.mask_budget) {
  const LitResin& resin = plan.rises->bounds.lit;
  if (resin.irradiance <= MilliwattsPerCm2{}) return;
  // A mask that stays for 2.5 refreshes is not too old, see most_a_refresh().
  constexpr double kRefreshes = 2.5;
  gelling_.front.emplace(
      resin, solid,
      MillimetersPerSecond{in_mm(kFarthestCut) / kRefreshes / in_seconds(machine.display().frame())});
}

void RiseFrames::stop() {
  count_light();
  if (std::exchange(gelling_.lit_until, std::nullopt) && gelling_.front) gelling_.front->forget();
  end_frame(clock_.now());
  calls_.frame_over = nullptr;
  ++stops_;
  refresh_.reset();
  hand_over_.reset();
}

// --- The height at which resin gels

GelFront::Light RiseFrames::light_until(TimePoint when) const {
  if (!gelling_.lit_until) return {};
  return {std::max<std::chrono::duration<double>>(when - *gelling_.lit_until, {}),
          light_of(white_.on_screen, plan_.rises->gamma)};
}

// Adds the light since the last call.
void RiseFrames::count_light() {
  if (!gelling_.front || !gelling_.lit_until) return;
  const std::optional<Nanometers> plate = machine_.z_axis().height();
  if (!plate) return;
  const TimePoint now = clock_.now();
  gelling_.front->add(*plate, light_until(now));
  gelling_.lit_until = std::max(now, *gelling_.lit_until);
}

std::optional<Nanometers> RiseFrames::gelled() const {
  return gelling_.front ? gelling_.front->height() : machine_.z_axis().height();
}

// Returns the height of the cut that is right at a time; nullopt if the plate's position is unknown.
std::optional<Nanometers> RiseFrames::section_at(TimePoint when) const {
  const std::optional<Nanometers> plate = machine_.z_axis().height_at(when);
  if (!plate) return std::nullopt;
  return std::min(gelling_.front ? gelling_.front->ahead(*plate, light_until(when)) : *plate, calls_.highest);
}

double RiseFrames::take_lit_pixels() {
  const double sum = std::exchange(lit_pixels_.sum, 0);
  const std::int64_t masks = std::exchange(lit_pixels_.masks, 0);
  return masks > 0 ? sum / static_cast<double>(masks) : lit_pixels_.last;
}

TimePoint RiseFrames::next_vblank() const {
  const Duration frame = machine_.display().frame();
  return screen_.vblank + ((clock_.now() - screen_.vblank) / frame + 1) * frame;
}

// Waits for the mask by looking once a refresh: nothing shines, and nothing moves.
void RiseFrames::show_first(std::function<void()> shown, std::function<void(const std::string&)> unsafe) {
  stop();
  calls_.unsafe = std::move(unsafe);
  if (masks_.busy()) {
    refresh_ = clock_.call_after(machine_.display().frame(), [this, shown = std::move(shown)]() mutable {
      show_first(std::move(shown), calls_.unsafe);
    });
    return;
  }
  const std::optional<Nanometers> plate = machine_.z_axis().height();
  if (!plate) return calls_.unsafe(kUnknownHeight);
  screen_.plate = *plate;
  masks_.begin(*gelled(), white_.wanted);
  await_first(std::move(shown));
}

void RiseFrames::await_first(std::function<void()> shown) {
  if (!masks_.ready()) {
    refresh_ = clock_.call_after(machine_.display().frame(), [this, shown = std::move(shown)]() mutable {
      await_first(std::move(shown));
    });
    return;
  }
  const std::optional<Nanometers> plate = machine_.z_axis().height();
  if (!plate) return calls_.unsafe(kUnknownHeight);
  screen_.plate = *plate;
  present([this, shown = std::move(shown)](TimePoint at) {
    screen_.vblank = at;
    begin_frame(at);
    shown();
  });
}

void RiseFrames::run(Calls calls) {
  calls_ = std::move(calls);
  gelling_.lit_until = calls_.lit_from.value_or(clock_.now());
  if (frame_) {  // the mask at rest, which is on the screen
    frame_->begins = true;
    ++figures_.shown;
  }
  refresh_ = clock_.call_at(next_vblank(), [this] { refresh(); });
}

void RiseFrames::refresh() {
  const std::uint64_t stops = stops_;
  count_light();
  calls_.refreshed();
  if (stops != stops_) return;
  const TimePoint vblank = next_vblank();
  // None was begun if the heights were not yet to change enough, at the beginning of the rise for instance.
  if (!masks_.begun()) begin_mask(vblank);
  if (stops != stops_) return;
  hand_over_ = clock_.call_at(vblank - machine_.display().frame() / 2, [this, vblank] { hand_over(vblank); });
  refresh_ = clock_.call_at(vblank, [this] { refresh(); });
}

// Begins the mask for the refresh at a vblank, if one of the heights will have changed enough by then.
void RiseFrames::begin_mask(TimePoint vblank) {
  const TimePoint middle = vblank + machine_.display().frame() / 2;
  const std::optional<Nanometers> plate = machine_.z_axis().height_at(middle), section = section_at(middle);
  if (!plate || !section) return calls_.unsafe(kUnknownHeight);
  const Nanometers step = plan_.rises->mask_step;
  const bool is_new = white_.passed != white_.wanted || apart(*section, shown_.cut_at) >= step ||
                      apart(*plate, screen_.plate) >= step;
  if (!is_new || masks_.busy()) return;
  masks_.begin(*section, white_.wanted);
}

// Half a refresh before the vblank, the display has told which mask is on the screen. The next look at it is
// a refresh later, and until then this mask may stay.
void RiseFrames::hand_over(TimePoint vblank) {
  const Duration frame = machine_.display().frame();
  const std::optional<Nanometers> plate = machine_.z_axis().height_at(vblank + frame / 2);
  const std::optional<Nanometers> section = section_at(vblank + frame / 2);
  if (!plate || !section) return calls_.unsafe(kUnknownHeight);
  if (apart(*plate, screen_.due) > kFarthest || apart(*section, screen_.cut) > kFarthestCut) {
    return calls_.unsafe(fmt::format(
        "the mask on the screen is too old: {} masks were missed, and the plate would rise by more "
        "than {:.0f} um, or resin would gel more than {:.0f} um from the mask's height",
        figures_.missed, in_mm(kFarthest) * 1e3, in_mm(kFarthestCut) * 1e3));
  }
  if (!masks_.begun()) return begin_mask(vblank + frame);
  if (!masks_.ready()) {
    if (frame_) ++frame_->missed;
    return tell_missed(1);
  }
  const std::uint64_t stops = stops_;
  screen_.plate = *plate;
  present([this, vblank, frame](TimePoint at) {
    screen_.vblank = at;
    ++figures_.shown;
    const auto late =
        static_cast<std::uint32_t>(std::max<std::int64_t>((at - vblank + frame / 2) / frame, 0));
    if (frame_) frame_->missed += late;
    end_frame(at);
    begin_frame(at);
    figures_.farthest =
        std::max(figures_.farthest, apart(section_at(at + frame / 2).value_or(frame_->cut), frame_->cut));
    if (late > 0) tell_missed(late);
  });
  if (stops == stops_) begin_mask(vblank + frame);
}

void RiseFrames::tell_missed(std::uint32_t frames) {
  figures_.missed += frames;
  calls_.missed();
}

// Begins the record of the mask that has appeared on the screen.
void RiseFrames::begin_frame(TimePoint shown) {
  const std::optional<Nanometers> height =
      machine_.z_axis().height_at(shown + machine_.display().frame() / 2);
  frame_ = FrameRecord{.cut = shown_.cut_at, .first = height.value_or(shown_.cut_at), .shown = shown};
  frame_->light =
      static_cast<std::uint8_t>(std::lround(255 * light_of(white_.on_screen, plan_.rises->gamma)));
}

// Ends the record of the mask on the screen, and passes it on if the plate rose meanwhile.
void RiseFrames::end_frame(TimePoint until) {
  if (!frame_) return;
  FrameRecord frame = *std::exchange(frame_, std::nullopt);
  if (!calls_.frame_over) return;
  const Duration refresh = machine_.display().frame();
  frame.last = machine_.z_axis().height_at(until - refresh / 2).value_or(frame.first);
  frame.refreshes =
      static_cast<std::uint32_t>(std::max<std::int64_t>((until - frame.shown + refresh / 2) / refresh, 1));
  if (calls_.lit_from) frame.lit = std::max(until - std::max(frame.shown, *calls_.lit_from), Duration{0});
  calls_.frame_over(frame);
}

// Passes the mask that is ready to the display.
void RiseFrames::present(std::function<void(TimePoint)> presented) {
  const MaskAhead::Cut& cut = masks_.take();
  figures_.longest_cut = std::max<Duration>(figures_.longest_cut, cut.time);
  if (!cut.trouble.empty()) {
    return calls_.unsafe(
        fmt::format("the mask at {:.3f} mm was abandoned: {}", in_mm(cut.height), cut.trouble));
  }
  lit_pixels_.last = cut.lit_area;
  lit_pixels_.sum += cut.lit_area;
  ++lit_pixels_.masks;
  white_.passed = cut.white;
  shown_ = {&cut.mask, shown_.number + 1, plan_.job, shown_.layer, cut.height};
  machine_.display().show(
      cut.mask, [this, stops = stops_, presented = std::move(presented)](std::optional<TimePoint> at) {
        if (stops != stops_) return;
        if (!at) return calls_.unsafe("the display was lost");
        screen_.cut = shown_.cut_at;
        screen_.due = screen_.plate;
        white_.on_screen = white_.passed;
        presented(*at);
      });
}

}  // namespace contourd
