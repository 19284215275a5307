// The record of a mask that was on the screen while the plate rose. A value.
#pragma once

#include <cstdint>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct FrameRecord {
  Nanometers cut{};  // height of the cut through the model
  // The plate's height at the middle of the first and of the last refresh that showed the mask.
  Nanometers first{}, last{};
  TimePoint shown{};            // vblank of the first refresh, by the machine's clock
  Duration lit{};               // time of the light while the mask was on the screen
  std::uint32_t refreshes = 0;  // refreshes that showed the mask
  std::uint32_t missed = 0;     // refreshes for which a later mask was wanted, and was late
  std::int32_t layer = 0;       // slice of the rise, from 0
  bool begins = false;          // the first mask since the light went on
  std::uint8_t light = 255;     // of white pixels, in 255ths of the lamp's light

  bool operator==(const FrameRecord&) const = default;
};

}  // namespace contourd
