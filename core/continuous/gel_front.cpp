#include "core/continuous/gel_front.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Shorter stretches are joined. The front is as exact as that.
constexpr double kShortestUm = 0.25;
// More stretches than that hold more than 8 mm of resin that does not gel.
constexpr std::size_t kMostStretches = 32'768;

double in_um(Nanometers height) {
  return in_mm(height) * 1000;
}

}  // namespace

GelFront::GelFront(const LitResin& resin, Nanometers solid, MillimetersPerSecond fastest)
    : depth_um_(resin.curve.penetration_depth.count()),
      dead_zone_um_(resin.dead_zone.count()),
      doses_per_s_(resin.irradiance.count() / resin.curve.critical_dose.count()),
      fastest_(fastest),
      origin_um_(in_um(solid)),
      height_(solid) {
  expects(depth_um_ > 0 && doses_per_s_ > 0 && dead_zone_um_ >= 0 && fastest > MillimetersPerSecond{},
          "lit resin has a working curve, light and a dead zone, and masks a speed");
}

double GelFront::falloff(double um) const {
  return std::exp(-um / depth_um_);
}

GelFront::Stretch GelFront::stretch_to(double plate_um, Light light) const {
  const double from = begun_ ? plate_um_ : plate_um, to = std::max(plate_um, from);
  return {from, to, doses_per_s_ * light.time.count() * light.share * falloff((from + to) / 2 - origin_um_)};
}

Nanometers GelFront::limited(double front_um, std::chrono::duration<double> time) const {
  const double most_um = fastest_.count() * 1000 * std::max(time.count(), 0.0);
  const double rise_um = std::clamp(front_um - in_um(height_), 0.0, most_um);
  return height_ + Nanometers{std::llround(rise_um * 1000)};
}

Nanometers GelFront::ahead(Nanometers plate, Light light) const {
  const Stretch next = stretch_to(in_um(plate), light);
  double sum = sum_ + next.dose, front_um = 0;
  // Returns false if the front is within the stretch: resin below its lower end has all the sum, resin at its
  // upper end no longer its dose.
  const auto passes = [&](const Stretch& stretch) {
    const double lower = stretch.from_um - dead_zone_um_, upper = stretch.to_um - dead_zone_um_;
    const double below = sum / falloff(lower - origin_um_),
                 above = (sum - stretch.dose) / falloff(upper - origin_um_);
    if (below < 1) return false;
    front_um = upper;
    sum -= stretch.dose;
    if (above >= 1) return true;
    front_um = lower + (upper - lower) * (below - 1) / (below - above);
    return false;
  };
  if (std::ranges::all_of(lit_, passes)) (void)passes(next);
  return limited(front_um, light.time);
}

void GelFront::add(Nanometers plate, Light light) {
  height_ = ahead(plate, light);
  const Stretch next = stretch_to(in_um(plate), light);
  begun_ = true;
  plate_um_ = next.to_um;
  sum_ += next.dose;
  if (!lit_.empty() && next.to_um - lit_.back().from_um < kShortestUm) {
    lit_.back().to_um = next.to_um;
    lit_.back().dose += next.dose;
  } else {
    lit_.push_back(next);
  }
  // Drops what is below the resin that has gelled.
  while (lit_.size() > 1 &&
         (lit_.front().to_um <= in_um(height_) + dead_zone_um_ || lit_.size() > kMostStretches)) {
    sum_ -= lit_.front().dose;
    lit_.pop_front();
  }
  constexpr double kFarInDepths = 4;
  if (plate_um_ - origin_um_ > kFarInDepths * depth_um_) move_origin();
}

// Moves the height for which doses are given to the plate's, and adds them again, without rounding errors.
void GelFront::move_origin() {
  const double growth = 1 / falloff(plate_um_ - origin_um_);
  origin_um_ = plate_um_;
  sum_ = 0;
  for (Stretch& stretch : lit_)
    sum_ += stretch.dose *= growth;
}

void GelFront::forget() {
  lit_.clear();
  sum_ = 0;
  begun_ = false;
}

}  // namespace contourd
