#include "daemon/print/rise_progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/rise_curve.hpp"

namespace contourd {
namespace {

Nanometers bottom_of(const PlannedRise& rise) {
  return rise.plan.points.front().height;
}

}  // namespace

RisePlan capped(const RisePlan& plan, MillimetersPerSecond most) {
  expects(!plan.points.empty() && most > MillimetersPerSecond{}, "a rise has a plan and a speed");
  RisePlan slower{.points = {}, .overrun = plan.overrun};
  const double limit = most.count() * most.count();
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    RisePoint point = plan.points[i];
    if (i > 0) {
      // Where a ramp passes the limit, its square of the speed being linear in height.
      const RisePoint& from = plan.points[i - 1];
      const double low = from.speed.count() * from.speed.count(),
                   high = point.speed.count() * point.speed.count();
      const double part = (limit - low) / (high - low);
      const Nanometers cross{from.height.count() +
                             std::llround(part * static_cast<double>((point.height - from.height).count()))};
      if (part > 0 && part < 1 && cross > from.height && cross < point.height)
        slower.points.push_back({cross, most, from.limit});
    }
    point.speed = std::min(point.speed, most);
    slower.points.push_back(point);
  }
  return slower;
}

RisePlan way_of(const RisePlan& plan, Nanometers from) {
  const RisePlan whole = with_overrun(plan);
  expects(!whole.points.empty(), "a rise has a plan");
  const Nanometers begin = std::min(from, whole.points.back().height - kLeastRise);
  return begin > whole.points.front().height ? rest_of(whole, begin) : whole;
}

Nanometers end_beneath(std::span<const PlannedRise> rises, std::size_t at) {
  expects(at < rises.size(), "there is such a rise");
  if (at == 0) return Nanometers{};
  const RisePlan& beneath = rises[at - 1].plan;
  const Nanometers top = beneath.points.back().height;
  return top == bottom_of(rises[at]) ? top + beneath.overrun : Nanometers{};
}

RiseProgress::RiseProgress(PlannedRises rises, Nanometers from) : rises_(std::move(rises)), here_(from) {
  while (any_left() && bottom_of(rises_.each[at_]) < from)
    ++at_;
}

void RiseProgress::reach() {
  expects(any_left(), "a rise is left");
  here_ = bottom_of(rises_.each[at_]);
  plate_ = Nanometers{};
}

void RiseProgress::begin() {
  expects(next() != NextPart::Layers, "a rise is next");
  if (std::exchange(begun_, true)) return;
  lit_ = {};
  changed_at_.reset();
  rest_ = way_of(rises_.each[at_].plan, plate_);
  if (cap_) rest_ = capped(rest_, *cap_);
}

const PlannedRise& RiseProgress::current() const {
  expects(any_left(), "a rise is left");
  return rises_.each[at_];
}

const RisePlan& RiseProgress::rest() const {
  expects(begun_, "a rise is under way");
  return rest_;
}

void RiseProgress::stop_at(Nanometers height) {
  expects(begun_, "a rise is under way");
  changed_ = false;
  rest_ = rest_of(rest_, std::max(height, rest_.points.front().height));
  if (!rest_.points.empty()) {
    if (cap_) rest_ = capped(rest_, *cap_);
    return;
  }
  here_ = rises_.each[at_].plan.points.back().height;
  plate_ = height;
  begun_ = false;
  rest_until_.reset();
  ++at_;
}

bool RiseProgress::slow_down(Nanometers height, MillimetersPerSecond slowest, TimePoint now) {
  expects(begun_, "a rise is under way");
  constexpr double kSlower = 0.75;
  constexpr Duration kPause = std::chrono::seconds{1};
  const auto next = std::ranges::upper_bound(rest_.points, height, {}, &RisePoint::height);
  if (next == rest_.points.begin() || next == rest_.points.end()) return false;
  const MillimetersPerSecond speed = std::max(std::prev(next)->speed, next->speed);
  if (speed <= slowest || (cap_ && now - slowed_at_ < kPause)) return false;
  cap_ = std::max(speed * kSlower, slowest);
  slowed_at_ = now;
  return true;
}

RisesAhead RiseProgress::ahead(std::optional<Nanometers> height) const {
  expects(any_left() && rises_.slabs, "a rise is left, and its slabs are known");
  RisesAhead ahead{rises_.slabs,
                   rises_.bounds,
                   rises_.gamma,
                   rises_.settings,
                   {rises_.each.begin() + static_cast<std::ptrdiff_t>(at_), rises_.each.end()}};
  if (begun_) {
    ahead.height = std::max(height.value_or(Nanometers{}), rest_.points.front().height);
    ahead.each.front().lit += lit_;
  }
  if (!cap_) return ahead;
  for (PlannedRise& rise : ahead.each)
    rise.plan = capped(rise.plan, *cap_);
  return ahead;
}

void RiseProgress::change(const ChangedRises& changed, TimePoint now) {
  expects(changed.each.size() + at_ == rises_.each.size(), "all rises that are left have changed");
  if (changed.settings.speed_mm_h != rises_.settings.speed_mm_h) cap_.reset();
  take_change(changed, rises_);
  if (!begun_) return;
  changed_at_ = now;
  const Nanometers from = rest_.points.front().height;
  rest_ = way_of(rises_.each[at_].plan, from);
  if (cap_) rest_ = capped(rest_, *cap_);
  changed_ = true;
}

bool RiseProgress::just_changed(TimePoint now) const {
  constexpr Duration kBetweenChanges = std::chrono::seconds{3};
  return begun_ && changed_at_ && now - *changed_at_ < kBetweenChanges;
}

Duration RiseProgress::longest(MillimetersPerSecond slowest) const {
  expects(begun_, "a rise is under way");
  return std::chrono::duration_cast<Duration>(duration(capped(rest_, slowest)));
}

NextPart RiseProgress::next() const {
  if (begun_) return NextPart::Rise;
  if (!any_left() || bottom_of(rises_.each[at_]) != here_) return NextPart::Layers;
  return rises_.each[at_].rest > Duration{} ? NextPart::Rest : NextPart::Rise;
}

TimePoint RiseProgress::rest_until(TimePoint now) {
  expects(any_left(), "a rise is left");
  if (!rest_until_) rest_until_ = now + rises_.each[at_].rest;
  return *rest_until_;
}

}  // namespace contourd
