// Analyzes a whole print: resin, exposed areas, islands, suction cups and resin traps,
// damage by cracks in the model, and duration. One pass over the layers' masks, from the bottom up, a layer
// at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/analysis/island_finder.hpp"
#include "core/analysis/void_finder.hpp"
#include "core/contour/layer_cracks.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// Limits that decide whether the layer beneath carries a part of a layer (see IslandFinder).
struct CarryingSupport {
  std::uint8_t least_grey = 64;    // minimum grey of a carrying pixel: a quarter of full light
  double contact_area_mm2 = 0.01;  // minimum area of carrying pixels; a third of the part's area if smaller

  bool operator==(const CarryingSupport&) const = default;
};

// Minimum sizes of voids that are reported (see VoidFinder). Air pressure is 0.1 N/mm2, so a cup of 5 mm2
// pulls with at most 0.5 N, less than half of what a support tip of 0.4 mm holds. A droplet of 1 mm3 stays on
// the walls of its void anyway. Lattices and sponges have thousands of smaller voids.
struct VoidLimits {
  double cup_area_mm2 = 5;
  double cup_volume_mm3 = 1;
  double trap_volume_mm3 = 1;

  bool operator==(const VoidLimits&) const = default;
};

// A part of a layer that the layer beneath does not carry.
struct Island {
  std::int32_t layer = 0;  // from 0
  PixelPoint pixel{};      // the part's middle in the mask
  Point plate_mm{};     // the middle on the plate, from the plate's centre; seen from above, mirrors undone
  double area_mm2 = 0;  // exposed area of the pixels bright enough to carry
};

// A void: a suction cup while it is open only towards the film, a resin trap once it is closed all around.
// Layers count from 0.
struct PrintVoid {
  std::int32_t first_layer = 0;
  std::int32_t last_layer = 0;    // the layer above opens or closes it, or it is the print's last
  std::int32_t widest_layer = 0;  // the layer with the largest area open towards the film
  PixelPoint pixel{};             // middle of that area, in the mask
  Point plate_mm{};               // the middle on the plate, as in Island
  double area_mm2 = 0;            // area open towards the film in the widest layer: the area that sucks
  double volume_mm3 = 0;          // sum over all layers of the void
  bool on_plate = false;          // true if the void begins on the plate, which closes it there
};

struct CrackedLayer {
  std::int32_t layer = 0;
  LayerCracks cracks;
};

// The results of an analysis. A value; layers count from 0.
struct PrintFindings {
  std::vector<double> area_mm2;  // exposed, by layer
  double volume_mm3 = 0;         // cured resin: area times thickness, summed
  double largest_area_mm2 = 0;   // the area with the greatest peel force
  std::int32_t largest_area_layer = 0;
  // Dark layers, except for a single dark layer at the top, which may hold a tip that is too small for a
  // pixel.
  std::vector<std::int32_t> empty_layers;
  std::uint64_t island_count = 0;
  // The first kMaxIslands islands from the bottom up. The first layer has none: it stands on the plate.
  std::vector<Island> islands;
  // Voids that suck on the film when the plate is lifted: the kMaxVoids with the largest areas, from the
  // bottom up.
  std::uint64_t suction_cup_count = 0;
  std::vector<PrintVoid> suction_cups;
  // Voids that resin cannot leave: the kMaxVoids with the largest volumes, from the bottom up. None of them
  // is on the plate, since those open when the part is taken off.
  std::uint64_t resin_trap_count = 0;
  std::vector<PrintVoid> resin_traps;
  LayerCracks cracks;  // sum over all layers
  std::vector<CrackedLayer> cracked_layers;
  // Layers whose masks exceeded their time budget; all other figures count them as dark.
  std::vector<std::int32_t> abandoned_layers;
  std::chrono::nanoseconds layer_time{};  // all layers together

  // Limits for the lists: a mesh of noise could have millions.
  static constexpr std::size_t kMaxIslands = 4096;
  static constexpr std::size_t kMaxVoids = 1024;

  [[nodiscard]] std::int32_t layers() const { return static_cast<std::int32_t>(area_mm2.size()); }
  [[nodiscard]] double resin_ml() const { return volume_mm3 / 1000; }
};

// Analyses the layers one after the other. Keeps its working memory: once warm, a layer allocates only for
// its findings. Not thread-safe.
class PrintAnalysis {
 public:
  explicit PrintAnalysis(const DisplayGeometry& display, const CarryingSupport& support = {},
                         const VoidLimits& limits = {});

  struct Layer {
    Nanometers thickness{};
    std::chrono::nanoseconds duration{};  // exposure, peel, moves and waits
    LayerCracks cracks;
  };
  // Adds a layer. REQUIRES: a mask of the display's size.
  void add_layer(const Mask& mask, const Layer& layer);
  // Adds a layer whose mask exceeded its time budget.
  void add_abandoned_layer(const Layer& layer);

  // Ends the print: voids that are still open end here.
  void end();

  // Returns the findings of the layers added so far. Voids are included once they have ended, in no
  // particular order before end().
  [[nodiscard]] const PrintFindings& findings() const { return findings_; }

 private:
  void note_area(double area_mm2, const Layer& layer);
  void note_islands();
  void note_island(const MaskIsland& island, std::int32_t layer);
  void note_voids(std::span<const MaskVoid> ended);

  DisplayGeometry display_;
  double pixel_area_mm2_;
  CarryingSupport support_;
  VoidLimits limits_;
  MaskRuns lit_;               // lit pixels of the last layer
  MaskRuns bright_, beneath_;  // carrying pixels of the last layer, and of the layer beneath it
  std::int32_t beneath_layer_ = 0;
  IslandFinder finder_;
  VoidFinder void_finder_;
  std::int32_t dark_since_ = 0;  // empty_layers is complete for all layers before this one
  PrintFindings findings_;
};

struct AnalysisOptions {
  CarryingSupport support{};
  std::optional<std::chrono::nanoseconds> mask_budget{};  // nullopt: no limit
  VoidLimits void_limits{};
};

// Analyses all layers of a print, from the plate up by their thicknesses, computed by `engine` on `display`.
// Counts coverage, without pixels that the engine's threshold leaves dark; uniformity mask and gamma are
// ignored, since they only correct how that coverage is exposed. `layer_duration` returns the duration of a
// layer. Returns nullopt if `stop` is requested, which is checked before every layer.
[[nodiscard]] std::optional<PrintFindings> analyze_print(
    ContourEngine& engine, const DisplayGeometry& display, std::span<const Nanometers> thicknesses,
    const std::function<std::chrono::nanoseconds(std::int32_t layer)>& layer_duration,
    const std::stop_token& stop = {}, const AnalysisOptions& options = {});

}  // namespace contourd
