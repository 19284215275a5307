// What a whole print will be, known before it is printed: resin, exposed areas, what hangs in the air, what
// sucks on the film or keeps resin, what the model's cracks cost, and how long it takes. One pass over the
// layers' masks, from the bottom up, a layer at a time.
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

// What it takes to carry a part of a layer (see IslandFinder).
struct CarryingSupport {
  std::uint8_t least_grey = 64;    // of a pixel beneath that counts: a quarter of the light
  double contact_area_mm2 = 0.01;  // that many of them, or a third of what is as bright in the part itself

  bool operator==(const CarryingSupport&) const = default;
};

// Which voids are worth telling (see VoidFinder). Air presses with 0.1 N on a mm2 at most: 5 mm2 suck with
// half a newton, less than half of what a support's tip of 0.4 mm holds. A mm3 is a droplet: it stays on
// walls anyway. Lattices and sponges have thousands of smaller ones.
struct VoidLimits {
  double cup_area_mm2 = 5;
  double cup_volume_mm3 = 1;
  double trap_volume_mm3 = 1;

  bool operator==(const VoidLimits&) const = default;
};

// Part of a layer that begins with nothing under it that carries it.
struct Island {
  std::int32_t layer = 0;  // from 0
  PixelPoint pixel{};      // its middle in the mask
  Point plate_mm{};        // the same on the plate, from the plate's centre; seen from above, mirrors undone
  double area_mm2 = 0;     // exposed, of what is bright enough to carry
};

// A void: a suction cup while it is open towards the film alone, a resin trap once it is closed all around.
// Layers count from 0.
struct PrintVoid {
  std::int32_t first_layer = 0;
  std::int32_t last_layer = 0;    // the one above opens or closes it, or there is none
  std::int32_t widest_layer = 0;  // where most of it was open towards the film
  PixelPoint pixel{};             // its middle there, in the mask
  Point plate_mm{};               // the same on the plate, as an island's
  double area_mm2 = 0;            // open there: what sucks
  double volume_mm3 = 0;          // of all its layers
  bool on_plate = false;          // begins on the plate, which closes it there
};

struct CrackedLayer {
  std::int32_t layer = 0;
  LayerCracks cracks;
};

// A value; layers count from 0.
struct PrintFindings {
  std::vector<double> area_mm2;  // exposed, by layer
  double volume_mm3 = 0;         // resin that is cured: area times thickness, summed
  double largest_area_mm2 = 0;   // what the peel has to tear off
  std::int32_t largest_area_layer = 0;
  // Dark layers. Not one alone at the top: layers are as many as reach the model's top, so the last one may
  // be cut above it.
  std::vector<std::int32_t> empty_layers;
  std::uint64_t island_count = 0;
  // From the bottom up, of the first kMaxIslands. The first layer has none: it stands on the plate.
  std::vector<Island> islands;
  // What sucks on the film when the plate is lifted: the kMaxVoids with the largest areas, from the bottom
  // up.
  std::uint64_t suction_cup_count = 0;
  std::vector<PrintVoid> suction_cups;
  // What resin finds no way out of: the kMaxVoids with the largest volumes, from the bottom up. None of them
  // is on the plate: what the plate closes opens when the part is taken off.
  std::uint64_t resin_trap_count = 0;
  std::vector<PrintVoid> resin_traps;
  LayerCracks cracks;  // of all layers together
  std::vector<CrackedLayer> cracked_layers;
  // Whose masks did not keep their budget: they count as dark in all figures but this.
  std::vector<std::int32_t> abandoned_layers;
  std::chrono::nanoseconds layer_time{};  // all layers together

  // A mesh of noise could have millions: enough of them is enough.
  static constexpr std::size_t kMaxIslands = 4096;
  static constexpr std::size_t kMaxVoids = 1024;

  [[nodiscard]] std::int32_t layers() const { return static_cast<std::int32_t>(area_mm2.size()); }
  [[nodiscard]] double resin_ml() const { return volume_mm3 / 1000; }
};

// Takes the layers one after the other. Keeps its working memory: once warm, a layer allocates only for what
// is found in it. Not thread-safe.
class PrintAnalysis {
 public:
  explicit PrintAnalysis(const DisplayGeometry& display, const CarryingSupport& support = {},
                         const VoidLimits& limits = {});

  struct Layer {
    Nanometers thickness{};
    std::chrono::nanoseconds duration{};  // exposure, peel, moves and waits
    LayerCracks cracks;
  };
  // REQUIRES: a mask of the display's size.
  void add_layer(const Mask& mask, const Layer& layer);
  // A layer whose mask did not keep its budget.
  void add_abandoned_layer(const Layer& layer);

  // No more layers come: voids that are still open end here.
  void end();

  // What the layers added so far amount to. Of voids it has those that have ended, in no order before end().
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
  MaskRuns lit_;               // of the last layer
  MaskRuns bright_, beneath_;  // the same, of what carries; and of the layer before it
  std::int32_t beneath_layer_ = 0;
  IslandFinder finder_;
  VoidFinder void_finder_;
  std::int32_t dark_since_ = 0;  // the first of the dark layers on top that are not counted, if there are any
  PrintFindings findings_;
};

struct AnalysisOptions {
  CarryingSupport support{};
  std::optional<std::chrono::nanoseconds> mask_budget{};  // none: as long as each takes
  VoidLimits void_limits{};
};

// All layers of a print, from the plate up by their thicknesses, computed by `engine` on `display`: what they
// cover, less what the engine's threshold leaves dark; uniformity mask and gamma only make that coverage the
// same light. `layer_duration` says how long a layer takes. Nothing when `stop` was asked for meanwhile; it
// is looked at before every layer.
[[nodiscard]] std::optional<PrintFindings> analyze_print(
    ContourEngine& engine, const DisplayGeometry& display, std::span<const Nanometers> thicknesses,
    const std::function<std::chrono::nanoseconds(std::int32_t layer)>& layer_duration,
    const std::stop_token& stop = {}, const AnalysisOptions& options = {});

}  // namespace contourd
