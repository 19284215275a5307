#include "core/overhangs/overhang_cover.hpp"

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
}

std::optional<OverhangCover::Choice> OverhangCover::choose() {
  const auto is_pending = [](const Spot& spot) { return spot.need >= Need::Reach; };
  while (next_ < spots_.size() && !is_pending(spots_[next_]))
    ++next_;
  if (next_ == spots_.size()) return std::nullopt;
  const Spot& spot = spots_[next_];
  return Choice{best_for(spot), spot.at, spot.part};
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
    if (spot.part != choice.part || spot.need == Need::None) continue;
    const double radius = radius_for(spot.need);
    if (squared_distance(spot.at, at) > radius * radius && spot.at != choice.needed_by) continue;
    spot.need = Need::None;
    ++held;
  }
  return held;
}

}  // namespace contourd
