// The record of one print, for its owner.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/support/support_contact.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/report/state_times.hpp"
#include "daemon/system/event_loop.hpp"

namespace contourd {

// While the light is on or not confirmed off, no callback of the event loop is to take longer.
inline constexpr Duration kLongestLitTurn = std::chrono::milliseconds(10);

// A circle around an island, or around where a hollow is widest, in a picture's pixels.
struct LayerMark {
  PixelPoint middle{};
  double radius = 0;
};

// What a layer's exposure showed, made small.
struct LayerPicture {
  std::int32_t layer = 0;  // from 0
  std::string why;         // it was chosen: "island, crack"
  Pixels width, height;
  std::vector<std::uint8_t> png;
  std::vector<LayerMark> islands;  // that begin there
  std::vector<LayerMark> voids;    // suction cups and resin traps that are widest there
};

// The part as far as it was printed.
struct PartPreview {
  Pixels side;
  std::vector<std::uint8_t> png;
  struct Contact {
    PixelPoint at{};  // in the picture's pixels
    ContactCause cause = ContactCause::Island;
  };
  std::vector<Contact> contacts;  // of supports
};

// Why a print was interrupted. Times are from its start, by the machine's clock.
struct PrintInterruption {
  std::int32_t layer = 0;  // from 0
  Duration at{};
  std::string what;
};

// Paused, or held before its first layer.
struct PrintPause {
  std::int32_t layer = 0;  // from 0
  Duration at{}, lasted{};
};

// In their order, the first ones.
struct PrintStops {
  static constexpr std::size_t kMost = 1000;  // of each

  std::vector<PrintInterruption> interruptions;
  std::vector<PrintPause> pauses;
  std::uint64_t more_interruptions = 0, more_pauses = 0;  // than those
};

struct PrintReport {
  std::string job;
  std::string printer;
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;  // why it failed
  JobSummary summary;
  std::optional<PrintFindings> findings;  // nothing when the print ended before its analysis
  std::vector<LayerRecord> layers;        // those that were exposed
  PrintStops stops;
  StateTimes states;
  std::chrono::system_clock::time_point started,
      ended;                                   // for people; durations come from the monotonic clock
  Duration print_time{};                       // by the machine's clock
  std::uint64_t late_steps = 0;                // of the motor
  EventLoop::Turn busiest_lit;                 // of those while there was or may have been light
  Duration first_mask_after{};                 // from the file's arrival, or from the end of its wait
  std::optional<std::filesystem::path> masks;  // where the simulated display kept them
  std::optional<PartPreview> preview;
  std::vector<LayerPicture> layer_pictures;  // in rising order of their layers
};

// Of the layers that had light: their areas times their thicknesses.
[[nodiscard]] inline double exposed_volume_mm3(std::span<const LayerRecord> layers) {
  double volume_mm3 = 0;
  for (const LayerRecord& layer : layers)
    volume_mm3 += layer.area_mm2 * to_millimeters(layer.thickness).count();
  return volume_mm3;
}

}  // namespace contourd
