#include "daemon/report/printed_light.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "core/continuous/rise_laws.hpp"

namespace contourd {
namespace {

// Masks closer than this are joined: the error of a surface is about half as much at most.
constexpr Nanometers kFinestStep{4'000};

// The plate's mean height while a mask was on the screen.
Nanometers film_of(const FrameRecord& frame) {
  return frame.first + (frame.last - frame.first) / 2;
}

// Returns the time in which all of the lamp's light gives as much as a mask did.
double full_light_s(const FrameRecord& frame) {
  return in_seconds(frame.lit) * frame.light / 255;
}

Nanometers step_of(const ShownFrames& shown) {
  if (shown.frames.empty()) return kFinestStep;
  const Nanometers height = film_of(shown.frames.back()) - film_of(shown.frames.front());
  const auto most = static_cast<std::int64_t>(std::max<std::size_t>(shown.most_steps, 1));
  return std::max(kFinestStep, height / most + Nanometers{1});
}

// Joins masks to a step.
class StepOfRise {
 public:
  explicit StepOfRise(std::span<const FrameRecord> frames) {
    double cuts = 0;
    for (const FrameRecord& frame : frames) {
      const double lit = full_light_s(frame);
      top_ = std::max(top_, film_of(frame));
      cuts += lit * static_cast<double>(frame.cut.count());
      lit_s_ += lit;
    }
    mask_height_ = lit_s_ > 0 ? Nanometers{std::llround(cuts / lit_s_)} : frames.front().cut;
    frames_ = frames;
  }

  [[nodiscard]] Nanometers top() const { return top_; }
  [[nodiscard]] Nanometers mask_height() const { return mask_height_; }
  [[nodiscard]] std::int32_t slice() const { return frames_.front().layer; }
  // Returns the dose that gives resin below the step what its masks gave.
  [[nodiscard]] MillijoulesPerCm2 dose(double irradiance_mw_cm2, double depth_mm) const {
    double lit_s = 0;
    for (const FrameRecord& frame : frames_)
      lit_s += full_light_s(frame) * std::exp(in_mm(top_ - film_of(frame)) / depth_mm);
    return MillijoulesPerCm2{lit_s * irradiance_mw_cm2};
  }

 private:
  std::span<const FrameRecord> frames_;
  Nanometers top_{}, mask_height_{};
  double lit_s_ = 0;
};

// Adds layers to a print's light, from the plate up.
class LightFromPlate {
 public:
  LightFromPlate(double irradiance_mw_cm2, const ShownFrames& shown)
      : irradiance_(irradiance_mw_cm2), shown_(shown), step_(step_of(shown)), rest_(shown.frames) {}

  // Adds the masks of all slices up to this layer; returns false if there are none.
  bool add_rise(std::int32_t layer) {
    const auto end =
        std::ranges::find_if(rest_, [layer](const FrameRecord& each) { return each.layer > layer; });
    const auto frames = rest_.first(static_cast<std::size_t>(end - rest_.begin()));
    if (frames.empty()) return false;
    rest_ = rest_.subspan(frames.size());
    for (auto from = frames.begin(); from != frames.end();) {
      auto to = std::next(from);
      while (to != frames.end() && !to->begins && film_of(*to) < film_of(*from) + step_)
        ++to;
      const bool peeled = to != frames.end() ? to->begins : rest_.empty() || rest_.front().begins;
      add_step(StepOfRise(std::span(from, to)), peeled);
      from = to;
    }
    return true;
  }

  // Adds a layer, unless it is not above the one before.
  bool add_layer(const LayerRecord& record, std::size_t number) {
    lower_overrun(record.plate_height);
    if (record.plate_height <= beneath_) return false;
    const std::chrono::duration<double> least = record.exposure_least, most = record.exposure_most;
    const auto lit = record.dark_confirmed ? (least + most) / 2 : least;
    add({record.plate_height, {}, MillijoulesPerCm2{lit.count() * irradiance_}}, record.mask_height,
        {number});
    return true;
  }

  [[nodiscard]] PrintedLight take() {
    if (!margins_.empty()) {
      RiseLight rise{.masks = shown_.frames.size() - rest_.size(), .step = step_};
      const auto least = std::ranges::min_element(margins_);
      rise.least_margin = least->first;
      rise.least_at = least->second;
      const auto middle = margins_.begin() + static_cast<std::ptrdiff_t>(margins_.size() / 2);
      std::ranges::nth_element(margins_, middle);
      rise.margin = middle->first;
      if (rise.margin > 1) rise.print_through = contourd::print_through(shown_.cure.curve, rise.margin);
      light_.rise = rise;
    }
    return std::move(light_);
  }

 private:
  void add(LayerDose layer, Nanometers mask_height, PrintedLight::Source source) {
    layer.thickness = layer.top - std::exchange(beneath_, layer.top);
    light_.layers.push_back(layer);
    light_.mask_heights.push_back(mask_height);
    light_.sources.push_back(source);
  }

  // Puts the light of a rise's last steps, whose overrun ended above the film of the layer that follows, just
  // below that film, so that resin below them gets as much of it as before.
  void lower_overrun(Nanometers film) {
    const auto is_above = [&](std::size_t at) {
      return light_.sources[at].is_step && light_.layers[at].top >= film;
    };
    std::size_t first = light_.layers.size();
    while (first > 0 && is_above(first - 1))
      --first;
    const auto count = static_cast<std::int64_t>(light_.layers.size() - first);
    if (count == 0) return;
    beneath_ = first > 0 ? light_.layers[first - 1].top : Nanometers{};
    if (film - beneath_ <= Nanometers{count}) return;
    const double depth_mm = to_millimeters(shown_.cure.curve.penetration_depth).count();
    for (std::size_t at = first; at < light_.layers.size(); ++at) {
      LayerDose& step = light_.layers[at];
      const Nanometers top = film - Nanometers{static_cast<std::int64_t>(light_.layers.size() - at)};
      step.dose = step.dose * std::exp(-in_mm(step.top - top) / depth_mm);
      step.top = top;
      step.thickness = top - std::exchange(beneath_, top);
    }
  }

  void add_step(const StepOfRise& step, bool peeled) {
    const double depth_mm = to_millimeters(shown_.cure.curve.penetration_depth).count();
    const MillijoulesPerCm2 dose = step.dose(irradiance_, depth_mm);
    // A plate that waited for a while in the light, or came back after a pause, rose by nothing.
    const Nanometers top = std::max(step.top(), beneath_ + Nanometers{1});
    const double risen_mm = in_mm(top - beneath_);
    add({top, {}, dose, peeled}, step.mask_height(), {static_cast<std::size_t>(step.slice()), true});
    if (risen_mm < in_mm(step_) / 2) return;
    const double margin = dose / shown_.cure.curve.critical_dose * depth_mm / risen_mm *
                          std::exp(-to_millimeters(shown_.cure.dead_zone).count() / depth_mm);
    margins_.emplace_back(margin, top);
  }

  double irradiance_;
  const ShownFrames& shown_;
  Nanometers step_;
  std::span<const FrameRecord> rest_;
  Nanometers beneath_{};
  PrintedLight light_;
  std::vector<std::pair<double, Nanometers>> margins_;  // margin and height of each step
};

}  // namespace

std::optional<PrintedLight> printed_light(std::span<const LayerRecord> records, double irradiance_mw_cm2,
                                          const ShownFrames& shown) {
  LightFromPlate light(irradiance_mw_cm2, shown);
  for (std::size_t number = 0; number < records.size(); ++number) {
    if (records[number].layer != static_cast<std::int32_t>(number)) return std::nullopt;
    std::size_t last = number;  // slice of the same rise
    while (records[number].rises && last + 1 < records.size() && records[last + 1].rises)
      ++last;
    if (records[number].rises && light.add_rise(static_cast<std::int32_t>(last))) {
      number = last;
    } else if (!light.add_layer(records[number], number)) {
      return std::nullopt;
    }
  }
  return light.take();
}

}  // namespace contourd
