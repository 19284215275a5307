// The masks that a print's rises showed, read from the file beside its report. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "daemon/frames/frame_record.hpp"
#include "daemon/print/print_plan.hpp"

namespace contourd {

struct PrintFrames {
  std::vector<FrameRecord> records;
  std::string why_none{};  // a sentence, if a print has risen and not all of its masks are known
};

// Reads the masks of a print with these layers. An empty path: there is no file. Blocks; reads at most 17 MB.
[[nodiscard]] PrintFrames read_print_frames(std::span<const LayerRecord> layers,
                                            const std::filesystem::path& file);

}  // namespace contourd
