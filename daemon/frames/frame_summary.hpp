// The figures of the masks that a print has shown while the plate rose. Pure, thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "daemon/frames/frame_record.hpp"

namespace contourd {

struct FrameSummary {
  std::size_t masks = 0, rises = 0;  // a rise that went on after a pause counts as two
  std::uint64_t refreshes = 0, missed = 0;
  Duration lit{};
  Nanometers lowest{}, highest{};  // heights of the plate
  // Distances of the cuts below the plate, at the middle of the first refresh that showed them, and the
  // longest way of the plate while a mask stayed; each with the plate's height.
  struct Distance {
    Nanometers way{}, at{};
  };
  Distance nearest{}, farthest{}, longest{};
};

[[nodiscard]] FrameSummary summary_of(std::span<const FrameRecord> frames);

}  // namespace contourd
