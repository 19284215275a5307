#include "daemon/report/print_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "daemon/frames/frame_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

PrintFrames read_print_frames(std::span<const LayerRecord> layers, const std::filesystem::path& file) {
  if (std::ranges::find(layers, true, &LayerRecord::rises) == layers.end()) return {};
  constexpr const char* kFromSlices =
      "the light of the rise is taken from its slices, not from its masks: {}";
  if (file.empty()) return {{}, fmt::format(kFromSlices, "they are not on record")};
  try {
    FrameFile frames = read_frame_file(file);
    if (frames.complete && frames.lost == 0) return {std::move(frames.records)};
    const std::string name = printable(file.filename().string());
    if (frames.after_end > 0) return {{}, fmt::format(kFromSlices, name + " goes on after its end")};
    return {{}, fmt::format(kFromSlices, name + " does not have all of them")};
  } catch (const std::exception& error) {
    return {{},
            fmt::format(kFromSlices,
                        fmt::format("cannot use {}: {}", printable(file.filename().string()), error.what()))};
  }
}

}  // namespace contourd
