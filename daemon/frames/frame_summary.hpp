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
  // The largest distances of a cut from the plate's height at the middle of a refresh that showed it, and
  // that height: of the first refresh, and of all.
  struct Distance {
    Nanometers apart{}, at{};
  };
  Distance farthest_first{}, farthest{};
};

[[nodiscard]] FrameSummary summary_of(std::span<const FrameRecord> frames);

}  // namespace contourd
