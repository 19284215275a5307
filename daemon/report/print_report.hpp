// The report on one print, for the user.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/cure/cured_part.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/print/print_settings.hpp"
#include "daemon/report/job_picture.hpp"
#include "daemon/report/printed_light.hpp"
#include "daemon/report/state_times.hpp"
#include "daemon/system/event_loop.hpp"

namespace contourd {

// The limit on a turn of the event loop while the light is on or not confirmed off.
inline constexpr Duration kLongestLitTurn = std::chrono::milliseconds(10);

// A circle around an island, or around the place at which a hollow is widest, in a picture's pixels.
struct LayerMark {
  PixelPoint middle{};
  double radius = 0;
};

// A small picture of the mask that a layer was exposed with.
struct LayerPicture {
  std::int32_t layer = 0;  // from 0
  std::string why;         // the reasons for choosing it: "island, crack"
  Pixels width, height;
  std::vector<std::uint8_t> png;
  std::vector<LayerMark> islands;  // islands that begin in this layer
  std::vector<LayerMark> voids;    // suction cups and resin traps that are widest in this layer
};

// An interruption of a print. Times count from the print's start, by the machine's clock.
struct PrintInterruption {
  std::int32_t layer = 0;  // from 0
  Duration at{};
  std::string what;
};

// A time during which a print was paused, or held before its first layer.
struct PrintPause {
  std::int32_t layer = 0;  // from 0
  Duration at{}, lasted{};
};

// The first kMost interruptions and pauses of a print, in order.
struct PrintStops {
  static constexpr std::size_t kMost = 1000;

  std::vector<PrintInterruption> interruptions;
  std::vector<PrintPause> pauses;
  std::uint64_t more_interruptions = 0, more_pauses = 0;  // beyond kMost
};

// A copy that was excluded from the rest of a print.
struct Exclusion {
  std::size_t number = 0;  // number among the plate's copies, from 0
  std::string copy;        // its name
  std::int32_t layer = 0;  // the first layer without it, from 0
};

// Returns "tower.stl (copy 2) dark from layer 12 on"; printable.
[[nodiscard]] std::string describe(const Exclusion& exclusion);

// The part that a print's light cured.
struct PrintedPart {
  std::optional<CuredPart> part;
  std::string why_not;  // a clause, if there is no part
  std::optional<RiseLight> rise{};
  std::string without_frames{};  // a sentence, if the rise's light is taken from its slices
};

// The file of the masks that a print's rises showed, beside the report.
struct FrameLogFile {
  static constexpr const char* kSuffix = "frames.bin";

  std::string name;
  std::uint64_t recorded = 0, lost = 0;  // masks; the lost ones were shown, too
};

struct PrintReport {
  std::string job;
  std::string printer;
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;  // why the print failed
  JobSummary summary;
  std::optional<PrintFindings> findings;  // nullopt if the print ended before its analysis
  std::vector<LayerRecord> layers;        // the exposed layers
  std::optional<FrameLogFile> frames;     // nullopt: nothing rose, or the file could not be written
  PrintStops stops;
  std::vector<SettingChange> changes;          // settings that were changed while it printed
  std::vector<ChangedForecast> changed_rises;  // each up to the next one; `continuous` of the summary before
  std::vector<Exclusion> exclusions;
  StateTimes states;
  PrintForecast forecast;  // made when the print began
  std::chrono::system_clock::time_point started,
      ended;                                   // wall-clock times, only to be read; durations are monotonic
  Duration print_time{};                       // by the machine's clock
  std::uint64_t late_steps = 0;                // the motor's late steps
  EventLoop::Turn busiest_lit;                 // the longest turn while there was or may have been light
  Duration first_mask_after{};                 // since the file arrived, or since its wait ended
  std::optional<std::filesystem::path> masks;  // folder of the simulated display's masks
  std::optional<JobPicture> preview;
  std::vector<LayerPicture> layer_pictures;  // in rising order of layers
  std::optional<PrintedPart> cured;  // nullopt: the resin has no working curve, no layer had light, or there
                                     // is no model to compare with
};

// Returns the exposed volume: the sum of area times thickness over the layers that had light.
[[nodiscard]] inline double exposed_volume_mm3(std::span<const LayerRecord> layers) {
  double volume_mm3 = 0;
  for (const LayerRecord& layer : layers)
    if (layer.exposure_most > Duration{0})
      volume_mm3 += layer.area_mm2 * to_millimeters(layer.thickness).count();
  return volume_mm3;
}

// Returns the height of the part that has had all its light: infinite for a completed print.
[[nodiscard]] inline Millimeters printed_height(const PrintReport& report) {
  if (report.outcome == PrintOutcome::Done) return Millimeters{std::numeric_limits<double>::infinity()};
  Nanometers top{};
  for (const LayerRecord& layer : report.layers) {
    if (layer.complete) top = std::max(top, layer.bottom + layer.thickness);
  }
  return to_millimeters(top);
}

}  // namespace contourd
