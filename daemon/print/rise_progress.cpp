#include "daemon/print/rise_progress.hpp"

#include <algorithm>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/rise_curve.hpp"

namespace contourd {
namespace {

Nanometers bottom_of(const PlannedRise& rise) {
  return rise.plan.points.front().height;
}

}  // namespace

RiseProgress::RiseProgress(std::vector<PlannedRise> rises, Nanometers from)
    : rises_(std::move(rises)), here_(from) {
  while (any_left() && bottom_of(rises_[at_]) < from)
    ++at_;
}

void RiseProgress::reach() {
  expects(any_left(), "a rise is left");
  here_ = bottom_of(rises_[at_]);
}

void RiseProgress::begin() {
  expects(next() != NextPart::Layers, "a rise is next");
  if (!std::exchange(begun_, true)) rest_ = rises_[at_].plan;
}

const PlannedRise& RiseProgress::current() const {
  expects(any_left(), "a rise is left");
  return rises_[at_];
}

const RisePlan& RiseProgress::rest() const {
  expects(begun_, "a rise is under way");
  return rest_;
}

void RiseProgress::stop_at(Nanometers height) {
  expects(begun_, "a rise is under way");
  rest_ = rest_of(rest_, std::max(height, rest_.points.front().height));
  if (!rest_.points.empty()) return;
  here_ = rises_[at_].plan.points.back().height;
  begun_ = false;
  rest_until_.reset();
  ++at_;
}

NextPart RiseProgress::next() const {
  if (begun_) return NextPart::Rise;
  if (!any_left() || bottom_of(rises_[at_]) != here_) return NextPart::Layers;
  return rises_[at_].rest > Duration{} ? NextPart::Rest : NextPart::Rise;
}

TimePoint RiseProgress::rest_until(TimePoint now) {
  expects(any_left(), "a rise is left");
  if (!rest_until_) rest_until_ = now + rises_[at_].rest;
  return *rest_until_;
}

}  // namespace contourd
