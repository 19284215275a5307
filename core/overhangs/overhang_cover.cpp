#include "core/overhangs/overhang_cover.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace contourd {
namespace {

// The pixels around a spot are sampled so that about this many are examined.
constexpr std::size_t kLooks = 300;

}  // namespace

void OverhangCover::set_spots(std::vector<Spot>& spots) {
  std::swap(spots_, spots);
  next_ = 0;
  sets_slivers_aside_ = true;
}

std::optional<OverhangCover::Choice> OverhangCover::choose() {
  for (;;) {
    if (!find_pending()) {
      if (!sets_slivers_aside_) return std::nullopt;
      take_up_slivers();
      continue;
    }
    const Spot& spot = spots_[next_];
    const Choice choice{best_for(spot), spot.at, spot.part};
    if (!sets_slivers_aside_ || slivers_left_ == 0 || !set_sliver_aside(choice)) return choice;
  }
}

// Moves on to the next spot that needs a contact; returns false if there is none.
bool OverhangCover::find_pending() {
  while (next_ < spots_.size() && spots_[next_].need != Need::Reach && spots_[next_].need != Need::Bridge)
    ++next_;
  return next_ < spots_.size();
}

// Sets the spots aside that the choice would hold; returns false if these are more than a sliver, others than
// bridging ones, or in an island without a contact.
bool OverhangCover::set_sliver_aside(const Choice& choice) {
  std::vector<Spot*> sliver;
  for (Spot& spot : spots_) {
    if (!is_held_by(choice, choice.at, spot) || spot.need == Need::Sliver) continue;
    sliver.push_back(&spot);
    if (spot.need != Need::Bridge || std::isinf(spot.beyond) ||
        static_cast<double>(sliver.size()) > radii_.slack * radii_.slack)
      return false;
  }
  --slivers_left_;
  for (Spot* const spot : sliver)
    spot->need = Need::Sliver;
  return true;
}

// Lets go of the slivers' spots that are nearly held by now, and has the others held.
void OverhangCover::take_up_slivers() {
  for (Spot& spot : spots_) {
    if (spot.need == Need::Sliver) spot.need = spot.beyond <= radii_.slack ? Need::None : Need::Bridge;
  }
  next_ = 0;
  sets_slivers_aside_ = false;
}

// True if a contact at that place for the choice holds the spot.
bool OverhangCover::is_held_by(const Choice& choice, SweepPixel at, const Spot& spot) const {
  if (spot.part != choice.part || spot.need == Need::None) return false;
  const double radius = radius_for(spot.need);
  return squared_distance(spot.at, at) <= radius * radius || spot.at == choice.needed_by;
}

SweepPixel OverhangCover::best_for(const Spot& spot) {
  const double radius = radius_for(spot.need), squared = radius * radius;
  const auto reach = static_cast<std::int32_t>(2 * radius) + 1;
  near_.clear();
  std::size_t first = next_;
  while (first > 0 && spots_[first - 1].at.row >= spot.at.row - reach)
    --first;
  for (std::size_t i = first; i < spots_.size() && spots_[i].at.row <= spot.at.row + reach; ++i) {
    const Spot& other = spots_[i];
    if (other.part == spot.part && other.need != Need::None &&
        std::abs(other.at.column - spot.at.column) <= reach)
      near_.push_back(other.at);
  }
  const std::size_t stride = 1 + near_.size() / kLooks;
  SweepPixel best = spot.at;
  int most = 0;
  double least_sum = 0;
  for (std::size_t i = 0; i < near_.size(); i += stride) {
    if (squared_distance(near_[i], spot.at) > squared) continue;
    int held = 0;
    double sum = 0;
    for (std::size_t j = 0; j < near_.size(); j += stride) {
      const double distance = squared_distance(near_[i], near_[j]);
      if (distance > squared) continue;
      ++held;
      sum += distance;
    }
    // Among places that hold equally many, the most central one wins.
    if (held < most || (held == most && sum >= least_sum)) continue;
    best = near_[i];
    most = held;
    least_sum = sum;
  }
  return best;
}

std::int64_t OverhangCover::hold(SweepPixel at, const Choice& choice) {
  std::int64_t held = 0;
  for (Spot& spot : spots_) {
    if (is_held_by(choice, at, spot)) {
      spot.need = Need::None;
      ++held;
    } else if (spot.part == choice.part) {
      spot.beyond = std::min(spot.beyond, std::sqrt(squared_distance(spot.at, at)) - radii_.bridge);
    }
  }
  return held;
}

}  // namespace contourd
