#include "hw/gpio/plate_approach.hpp"

#include <utility>

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_motion.hpp"

namespace contourd {

PlateApproach::PlateApproach(AxisDrive& drive, PlatePosition& position, Wiring wiring)
    : drive_(drive), position_(position), wiring_(std::move(wiring)) {}

void PlateApproach::begin(Microsteps plate, MillimetersPerSecond speed, std::function<void()> there) {
  expects(position_.known(), "the plate's position is known");
  plate_ = plate;
  speed_ = speed;
  there_ = std::move(there);
  go();
}

void PlateApproach::go() {
  const Screw::Rest from = position_.by_steps();
  const Microsteps backlash = position_.screw().backlash();
  const auto there = [this] { verify(); };
  if (plate_ >= from.plate() || backlash == Microsteps{0})
    return drive_.run(AxisDrive::RunKind::Move, plate_ - from.motor, speed_, there);
  drive_.run(AxisDrive::RunKind::Move, plate_ - backlash - from.motor, speed_,
             [this, backlash, there] { drive_.run(AxisDrive::RunKind::Move, backlash, speed_, there); });
}

void PlateApproach::verify() {
  if (!position_.has_encoder()) return arrive();
  drive_.after(kEncoderRest, [this] { compare(); });
}

void PlateApproach::compare() {
  if (!drive_.encoder_is_believed()) return;
  const AxisEncoder::Finding finding = position_.compare_with_encoder();
  if (finding.fault) return wiring_.fail({HomingResult::NoMovement, *finding.fault});
  if (!finding.notice) return arrive();
  position_.take_encoder();
  go();
  wiring_.notice(*finding.notice);
}

}  // namespace contourd
