#include "core/overhangs/bearing_group.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Resin that is exposed for long sticks about ten times better to the plate than to the film.
constexpr double kPlateHolds = 10;

}  // namespace

void BearingGroup::Moments::add(double added_weight, double at_x, double at_y, double own_xx, double own_yy) {
  weight += added_weight;
  x += added_weight * at_x;
  y += added_weight * at_y;
  xx += added_weight * (at_x * at_x + own_xx);
  xy += added_weight * (at_x * at_y);
  yy += added_weight * (at_y * at_y + own_yy);
}

void BearingGroup::Moments::add(const Moments& other) {
  weight += other.weight;
  x += other.x;
  y += other.y;
  xx += other.xx;
  xy += other.xy;
  yy += other.yy;
}

void BearingGroup::Moments::add_tip(SweepPixel at, const TipStrength& strength) {
  // The second moment of a disc.
  const double own = strength.diameter_pixels * strength.diameter_pixels / 16;
  add(strength.holds_pixels, at.column, at.row, own, own);
}

void BearingGroup::add_tip(SweepPixel at, std::uint32_t number, const TipStrength& strength) {
  tips_.add_tip(at, strength);
  include(at, at);
  list_.push_back({at, number});
}

// Moves the corners out around two more.
void BearingGroup::include(SweepPixel low, SweepPixel high) {
  if (list_.empty()) {
    low_ = low;
    high_ = high;
  }
  low_ = {std::min(low_.column, low.column), std::min(low_.row, low.row)};
  high_ = {std::max(high_.column, high.column), std::max(high_.row, high.row)};
}

void BearingGroup::add_base(const PixelRun& run) {
  const double pixels = run.end - run.first;
  base_.add(kPlateHolds * pixels, (run.first + run.end - 1) / 2.0, run.row, pixels * pixels / 12, 1.0 / 12);
}

void BearingGroup::merge(BearingGroup&& other) {
  tips_.add(other.tips_);
  base_.add(other.base_);
  if (!other.list_.empty()) include(other.low_, other.high_);
  if (list_.size() < other.list_.size()) list_.swap(other.list_);
  list_.insert(list_.end(), other.list_.begin(), other.list_.end());
  other = {};
}

BearingGroup::Strains BearingGroup::strains_under(const PeelPull& pull, const Moments& tips) const {
  Moments all = tips;
  all.add(base_);
  const double x = all.x / all.weight, y = all.y / all.weight;
  const double xx = all.xx - all.x * x, xy = all.xy - all.x * y, yy = all.yy - all.y * y;
  const double scale = pull.pixels / (xx * yy - xy * xy);
  const double lever_x = pull.column - x, lever_y = pull.row - y;
  return {stands() ? 0 : pull.pixels / all.weight, scale * (yy * lever_x - xy * lever_y),
          scale * (xx * lever_y - xy * lever_x), x, y};
}

// The rim of a face is about two standard deviations from its centre, as with a disc.
double BearingGroup::strain_of_base(const Strains& strains) const {
  const double x = base_.x / base_.weight, y = base_.y / base_.weight;
  const double xx = base_.xx / base_.weight - x * x, xy = base_.xy / base_.weight - x * y,
               yy = base_.yy / base_.weight - y * y;
  const double square = strains.slope_x * strains.slope_x * xx + 2 * strains.slope_x * strains.slope_y * xy +
                        strains.slope_y * strains.slope_y * yy;
  return strains.at(x, y) + 2 * std::sqrt(std::max(square, 0.0));
}

double BearingGroup::strain_of_tips(const Strains& strains) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const Tip& tip : list_)
    most = std::max(most, strains.at(tip.at.column, tip.at.row));
  return most;
}

double BearingGroup::strain(const PeelPull& pull, const TipStrength& strength) const {
  if (is_empty()) return std::numeric_limits<double>::infinity();
  const Strains strains = strains_under(pull);
  const double tips = strain_of_tips(strains) + strains.slope() * strength.diameter_pixels / 2;
  return stands() ? std::max(strain_of_base(strains), tips) : tips;
}

double BearingGroup::strain_with(SweepPixel tip, const PeelPull& pull, const TipStrength& strength) const {
  Moments tips = tips_;
  tips.add_tip(tip, strength);
  const Strains strains = strains_under(pull, tips);
  const double most = std::max(strain_of_tips(strains), strains.at(tip.column, tip.row)) +
                      strains.slope() * strength.diameter_pixels / 2;
  return stands() ? std::max(strain_of_base(strains), most) : most;
}

BearingGroup::Lever BearingGroup::lever(const PeelPull& pull) const {
  expects(!is_empty(), "a lever needs a bearing");
  const Strains strains = strains_under(pull);
  const double slope = strains.slope();
  return slope > 0 ? Lever{strains.slope_x / slope, strains.slope_y / slope} : Lever{};
}

bool BearingGroup::bear(const PeelPull& pull, const TipStrength& strength) const {
  if (is_empty()) return false;
  const Strains strains = strains_under(pull);
  if (stands() && strain_of_base(strains) > 1) return false;
  // The strains are linear, so that no tip bears more than a corner around all of them would.
  const double tips_bear = 1 - strains.slope() * strength.diameter_pixels / 2;
  const double at_corner = strains.at(strains.slope_x > 0 ? high_.column : low_.column,
                                      strains.slope_y > 0 ? high_.row : low_.row);
  return list_.empty() || at_corner <= tips_bear || strain_of_tips(strains) <= tips_bear;
}

}  // namespace contourd
