#include "tests/rig/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace contourd::rig {
namespace {

double um(Nanometers length) {
  return static_cast<double>(length.count()) / 1000;
}

// A plate that yields by up to this under a light that does not go off counts as not moved: an encoder's
// corrections.
constexpr Nanometers kGiving{100'000};

}  // namespace

void Figures::add(const Figures& other) {
  prints += other.prints;
  done += other.done;
  canceled += other.canceled;
  failed += other.failed;
  layers += other.layers;
  parts += other.parts;
  slices += other.slices;
  interruptions += other.interruptions;
  line_faults += other.line_faults;
  happenings += other.happenings;
  unconfirmed += other.unconfirmed;
  widest = std::max(widest, other.widest);
  most_over = std::max(most_over, other.most_over);
  longest_pause = std::max(longest_pause, other.longest_pause);
}

void Verdict::break_rule(const std::string& rule, const std::string& what, TimePoint now) {
  const auto same = [&rule](const Violation& v) { return v.rule == rule; };
  if (std::ranges::none_of(violations_, same)) violations_.push_back({rule, what, now});
}

void Verdict::light_asked(int layer, Nanometers height, Duration part) {
  layer_ = layer;
  height_ = height;
  wanted_ = true;
  layers_[layer].asked = std::max(layers_[layer].asked, part);
}

Duration Verdict::light_of(int layer, TimePoint now) const {
  const auto found = layers_.find(layer);
  const Duration past = found == layers_.end() ? Duration{0} : found->second.light;
  return lit_ && !stray_ && layer_ == layer ? past + (now - lit_since_) : past;
}

void Verdict::look(const Scene& scene) {
  if (lit_ && !stray_ && layer_) {
    const Duration passed = scene.now - looked_at_;
    layers_[*layer_].masked += lit_pixels_ > 0 ? passed : Duration{0};
    layers_[*layer_].whole += lit_pixels_ == kPixels ? passed : Duration{0};
  }
  looked_at_ = scene.now;
  lit_pixels_ = scene.lit_pixels;
  if (lit_ && (!scene.lit || scene.stray != stray_)) {
    if (!stray_ && layer_) layers_[*layer_].light += scene.now - lit_since_;
    lit_ = false;
  }
  if (std::exchange(flips_, scene.flips) != scene.flips) mask_at_ = scene.plate;
  if (scene.lit && !lit_) light_begins(scene);
  if (lit_) check_light(scene);
  check_light_off(scene);
  if (scene.lit && !scene.light_off_unconfirmed && !scene.may_be_lit)
    break_rule("h: light is off unless light off is unconfirmed",
               fmt::format("the light is on in the state \"{}\"", scene.state), scene.now);
}

void Verdict::light_begins(const Scene& scene) {
  lit_ = true;
  stray_ = scene.stray;
  lit_since_ = scene.now;
  highest_ = lit_at_ = scene.plate;
  if (!stray_ && !layer_)
    break_rule("c: light belongs to a layer", "light that was never requested", scene.now);
}

void Verdict::check_light(const Scene& scene) {
  // A plate that is to rise may do so as long as the light is wanted.
  if (scene.rises && wanted_) highest_ = lit_at_ = scene.plate;
  highest_ = std::max(highest_, scene.plate);
  if (scene.picture && (stray_ || scene.picture != layer_))
    break_rule("a: light through its own mask",
               fmt::format("mask {} on the screen under {}", *scene.picture,
                           stray_ ? "stray light" : fmt::format("the light of {}", *layer_)),
               scene.now);
  if (scene.plate < highest_ - kGiving)
    break_rule("a: no lowering under light",
               fmt::format("the plate came down by {:.1f} um", um(highest_ - scene.plate)), scene.now);
  if (!stray_ && highest_ > lit_at_ + kGiving)
    break_rule("a: no lift under light",
               fmt::format("the plate went up by {:.1f} um", um(highest_ - lit_at_)), scene.now);
  if (stray_ || !wanted_) return;
  if (!scene.picture && scene.screen_is_in_use)
    break_rule("a: light through its own mask", "the screen is black in an exposure", scene.now);
  if (scene.rises) {
    const Nanometers way = scene.plate - mask_at_;
    if (scene.loop_runs && way > oldest_mask)
      break_rule("a: light through the mask of the plate's height",
                 fmt::format("the plate has risen by {:.2f} um under one mask", um(way)), scene.now);
    return;
  }
  if (std::abs((scene.plate - height_).count()) > step_.count())
    break_rule("a: light at the layer's height",
               fmt::format("the plate is at {:.2f} um, the layer at {:.2f} um", um(scene.plate), um(height_)),
               scene.now);
}

// The light of a split exposure's darker pixels is their share, to within what the record states, and half a
// refresh for each part.
void Verdict::check_split(const LayerRecord& record, const Layer& layer, TimePoint now) {
  const Duration truly = layer.whole;
  const Duration share = std::min(record.exposure_asked * kShare / 255, layer.masked);
  const Duration error = std::chrono::round<Duration>(record.light_error *
                                                      std::chrono::duration<double>(record.exposure_asked)) +
                         *frame / 2 * record.exposure_parts + (record.exposure_most - record.exposure_least) +
                         Duration{1000};
  if (truly < share - error || truly > share + error + record.late_picture)
    break_rule(
        "k: pixels get their share of the light",
        fmt::format("{:.3f} ms, {:.3f} ms are their share, {:.3f} ms is the error, a picture was {:.3f} "
                    "ms late",
                    in_ms(truly), in_ms(share), in_ms(error), in_ms(record.late_picture)),
        now);
  if (latest_picture && record.late_picture > *latest_picture)
    break_rule("k: pictures come in time",
               fmt::format("one was {:.3f} ms late, at most {:.3f} ms are possible",
                           in_ms(record.late_picture), in_ms(*latest_picture)),
               now);
}

void Verdict::check_light_off(const Scene& scene) {
  if (!scene.light_off_due || wanted_) return light_off_due_since_.reset();
  if (!light_off_due_since_) light_off_due_since_ = scene.now;
  const Duration pause = scene.now - std::max(*light_off_due_since_, scene.off_sent);
  figures.longest_pause = std::max(figures.longest_pause, pause);
  if (pause > scene.longest_pause)
    break_rule("j: light off is sent again while the light may be on",
               fmt::format("{:.1f} s without a light off or power off", in_seconds(pause)), scene.now);
}

void Verdict::recorded(int layer, const LayerRecord& record, TimePoint now) {
  const Duration truly = light_of(layer, now);
  const auto bounds = fmt::format(
      "layer {}: {:.3f} ms of light, {:.3f} to {:.3f} ms in the record, {:.3f} ms asked", layer, in_ms(truly),
      in_ms(record.exposure_least), in_ms(record.exposure_most), in_ms(record.exposure_asked));
  if (truly < record.exposure_least || truly > record.exposure_most)
    break_rule("b: bounds contain the light", bounds, now);
  if (slack && truly > record.exposure_asked + *slack)
    break_rule("d: no light beyond what was asked", bounds, now);
  if (slack && record.complete && truly < record.exposure_asked - *slack * record.exposure_parts)
    break_rule("d: no layer short of light", bounds, now);
  if (shortfall && record.complete && truly < record.exposure_asked - *shortfall * record.exposure_parts)
    break_rule("d: no layer short of light", bounds, now);
  if (frame && record.dark_confirmed) check_split(record, layers_[layer], now);
  if (layers_[layer].record) break_rule("c: one record a layer", bounds, now);
  layers_[layer].record = record;
  figures.layers += 1;
  figures.parts += static_cast<std::uint64_t>(record.exposure_parts);
  figures.unconfirmed += record.dark_confirmed ? 0 : 1;
  if (record.dark_confirmed)
    figures.widest = std::max(figures.widest, record.exposure_most - record.exposure_least);
  figures.most_over = std::max(figures.most_over, truly - record.exposure_asked);
}

void Verdict::slice_recorded(int rise, const LayerRecord& record) {
  std::optional<LayerRecord>& whole = layers_[rise].record;
  if (!whole) {
    whole = record;
  } else {
    whole->exposure_least += record.exposure_least;
    whole->exposure_most += record.exposure_most;
    whole->dark_confirmed = whole->dark_confirmed && record.dark_confirmed;
  }
  figures.slices += 1;
}

void Verdict::close(TimePoint now) {
  for (const auto& [number, layer] : layers_) {
    const Duration truly = light_of(number, now);
    if (truly > Duration{0} && !layer.record)
      break_rule("c: all light is recorded",
                 fmt::format("layer {}: {:.3f} ms of light, no record", number, in_ms(truly)), now);
    if (!layer.record || !layer.record->dark_confirmed) continue;
    if (layer.record->rises && truly < layer.record->exposure_least)
      break_rule("b: bounds contain the light",
                 fmt::format("the rise {}: {:.3f} ms of light, at least {:.3f} ms in its records", number,
                             in_ms(truly), in_ms(layer.record->exposure_least)),
                 now);
    if (truly > layer.record->exposure_most)
      break_rule("c: no light after a record",
                 fmt::format("layer {}: {:.3f} ms of light, {:.3f} ms in its record", number, in_ms(truly),
                             in_ms(layer.record->exposure_most)),
                 now);
  }
}

}  // namespace contourd::rig
