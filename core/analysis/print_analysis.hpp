// What a whole print will be, known before it is printed: resin, exposed areas, what hangs in the air, what
// the model's cracks cost, and how long it takes. One pass over the layers' masks, from the bottom up, a
// layer at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/analysis/island_finder.hpp"
#include "core/contour/layer_cracks.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// What it takes to carry a part of a layer (see IslandFinder).
struct CarryingSupport {
  std::uint8_t least_grey = 64;    // of a pixel beneath that counts: a quarter of the light
  double contact_area_mm2 = 0.01;  // that many of them, or half of what is as bright in the part itself

  bool operator==(const CarryingSupport&) const = default;
};

// Part of a layer that begins with nothing under it that carries it.
struct Island {
  std::int32_t layer = 0;  // from 0
  PixelPoint pixel{};      // its middle in the mask
  Point plate_mm{};        // the same on the plate, from the plate's centre; seen from above, mirrors undone
  double area_mm2 = 0;     // exposed
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
  LayerCracks cracks;  // of all layers together
  std::vector<CrackedLayer> cracked_layers;
  // Whose masks did not keep their budget: they count as dark in all figures but this.
  std::vector<std::int32_t> abandoned_layers;
  std::chrono::nanoseconds layer_time{};  // all layers together

  // A mesh of noise could have millions: enough of them is enough.
  static constexpr std::size_t kMaxIslands = 4096;

  [[nodiscard]] std::int32_t layers() const { return static_cast<std::int32_t>(area_mm2.size()); }
  [[nodiscard]] double resin_ml() const { return volume_mm3 / 1000; }
};

// Takes the layers one after the other. Keeps its working memory: once warm, a layer allocates only for what
// is found in it. Not thread-safe.
class PrintAnalysis {
 public:
  explicit PrintAnalysis(const DisplayGeometry& display, const CarryingSupport& support = {});

  struct Layer {
    Nanometers thickness{};
    std::chrono::nanoseconds duration{};  // exposure, peel, moves and waits
    LayerCracks cracks;
  };
  // REQUIRES: a mask of the display's size.
  void add_layer(const Mask& mask, const Layer& layer);
  // A layer whose mask did not keep its budget.
  void add_abandoned_layer(const Layer& layer);

  // What the layers added so far amount to.
  [[nodiscard]] const PrintFindings& findings() const { return findings_; }

 private:
  void note_area(double area_mm2, const Layer& layer);
  void note_islands();

  DisplayGeometry display_;
  double pixel_area_mm2_;
  CarryingSupport support_;
  IslandFinder::Layer layer_, beneath_;
  IslandFinder finder_;
  std::int32_t dark_since_ = 0;  // the first of the dark layers on top that are not counted, if there are any
  PrintFindings findings_;
};

struct AnalysisOptions {
  CarryingSupport support{};
  std::optional<std::chrono::nanoseconds> mask_budget{};  // none: as long as each takes
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
