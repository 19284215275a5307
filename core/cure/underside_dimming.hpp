// Dims the masks of a print so that undersides cure at the model's own height (see underside_light()), pixel
// by pixel. Not thread-safe.
//
// A solid begins in a pixel where a layer's mask is lit and that of the layer beneath is dark. Its light
// follows from the masks of the layers above, which are computed ahead, and from the height at which the line
// through the pixel's middle enters the model, exact within the layer. These pixels keep all their light:
// supports and what stands on them; what stands on the plate; parts that are less than three pixels wide; and
// a third of a solid's layers, and one more, so that no layer's light is without hold.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/cure/cured_layers.hpp"
#include "core/cure/surface_rays.hpp"
#include "core/cure/underside_light.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/exposure_correction.hpp"

namespace contourd {

struct DimmedPixel {
  std::uint32_t pixel;  // row * width of the display + column
  std::uint8_t share;   // of the pixel's light, in 255ths
};

// Multiplies the light of pixels of the mask by their shares.
void dim(std::span<const DimmedPixel> pixels, Mask& light);

// The light that a print without dimming would give, and its resin.
struct UndersideCure {
  std::vector<LayerDose> layers;
  CureSettings resin{};
  std::chrono::nanoseconds mask_budget{};  // for a mask that is computed ahead, and for a layer's undersides
};

// The coverage of layers in a window of the display.
class LayerPictures {
 public:
  using Picture = std::vector<std::uint8_t>;  // by pixel of the window

  LayerPictures(ContourEngine engine, const PixelWindow& window, std::chrono::nanoseconds budget)
      : engine_(std::move(engine)), window_(window), budget_(budget) {}

  [[nodiscard]] std::span<const PlateModel> models() const { return engine_.models(); }
  [[nodiscard]] ContourEngine& engine() { return engine_; }
  // Returns the budget of a mask that is begun now.
  [[nodiscard]] MaskBudget budget() const { return MaskBudget(MaskBudget::Clock::now() + budget_); }
  // Returns the coverage of a layer, without what the threshold leaves dark; empty if it overran its budget.
  [[nodiscard]] Picture of(const LayerDose& layer);

 private:
  ContourEngine engine_;
  PixelWindow window_;
  std::chrono::nanoseconds budget_;
};

// The lowest places at which the lines through pixels' middles enter models, within a range of heights that
// rises with the print.
class ModelEntries {
 public:
  explicit ModelEntries(const PixelWindow& window) : window_(window), lowest_mm_(window.pixels(), kNone) {}

  // Forgets all entries.
  void restart();
  // Sets the range, and finds the entries in what is new of it; some may lack if the budget is overrun, or if
  // there are many more than pixels. Entries above `walls_up_to_mm` through surfaces steeper than 63 degrees
  // do not count. REQUIRES: neither end is below that of the last range since restart().
  void rise_to(std::span<const PlateModel> models, const RayRange& range, double walls_up_to_mm,
               MaskBudget& budget);
  // Returns the height of a pixel's lowest entry in the range; nullopt if it has none.
  [[nodiscard]] std::optional<double> lowest_mm(std::size_t pixel) const;

 private:
  static constexpr float kNone = std::numeric_limits<float>::infinity();
  // The entries up to a height, above those of the batch before.
  struct Batch {
    double up_to_mm;
    std::vector<RayCrossing> entries;
  };

  PixelWindow window_;
  RayRange range_{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  std::deque<Batch> batches_;
  std::vector<float> lowest_mm_;  // by pixel
};

// The light of solids that begin in one layer.
class SolidLight {
 public:
  // A pixel's part above its underside.
  struct Solid {
    double underside_mm;
    std::span<const std::uint8_t> coverage;  // by layer, from the one in which the solid begins
    bool is_endless;                         // the solid goes on above these layers
  };

  explicit SolidLight(const CureSettings& resin);

  // Prepares the light of solids that begin in the first of these layers, whose other layers are those that
  // are computed ahead. REQUIRES: a layer, and at most UndersideDimming::kMostAhead + 1.
  void begin(std::span<const LayerDose> layers);
  // Returns the light of a solid's lowest layers. Remembers that of solids that are fully lit. REQUIRES: as
  // many layers as were given at most, and one at least.
  [[nodiscard]] UndersideLight of(const Solid& solid);

 private:
  [[nodiscard]] UndersideLight compute(const Solid& solid);

  CureSettings resin_;
  PeelLoss loss_;
  std::span<const LayerDose> layers_;
  double bottom_mm_ = 0, lowest_mm_ = 0;
  std::vector<double> full_doses_;     // at the first layer's bottom, by layer
  std::vector<double> doses_;          // of the last solid
  std::vector<UndersideLight> known_;  // of solids that are fully lit, by height and number of layers
};

class UndersideDimming {
 public:
  // Prepares the dimming of a print whose engine has these models, settings and sections beside the models
  // (`supports`, null if there are none). REQUIRES: a layer; layers rise from the plate.
  UndersideDimming(std::span<const PlateModel> models, std::shared_ptr<const SectionSource> supports,
                   const EngineSettings& settings, const UndersideCure& cure);

  static constexpr std::size_t kMostAhead = 40;

  // Returns an upper bound of the memory in bytes, without that for sections.
  [[nodiscard]] static std::uint64_t most_memory(const DisplayGeometry& display, const UndersideCure& cure);

  // Returns the pixels of a layer that get less light than their mask gives them. Valid until the next call.
  // Costs nothing for the first layer, a mask for one that follows the last one; else up to twice as many as
  // there are layers ahead. A solid counts as far up as its masks ahead were computed within their budgets.
  // REQUIRES: a layer of the print.
  [[nodiscard]] std::span<const DimmedPixel> dimmed(std::size_t layer);
  // Leaves a copy dark from a layer on (ContourEngine::darken()), and replaces the supports there, unless
  // `supports` is null. Layers beneath keep the light that they had before: nothing was known then of the
  // copy's end. The next call of dimmed() looks ahead again. REQUIRES: a layer of the print, not beneath
  // those given before, and such a copy.
  void exclude(std::size_t model, std::size_t copy, std::shared_ptr<const SectionSource> supports,
               std::size_t layer);
  // Undoes exclude().
  void include_all();
  // False if undersides in this layer, the last one for which dimmed() was called, keep their light because a
  // budget was overrun: that to find them, or that of a mask of this layer or the one beneath.
  [[nodiscard]] bool are_found(std::size_t layer) const { return layer != layer_ || dimmed_.are_found; }

 private:
  struct Dimmed {
    std::vector<DimmedPixel> pixels{};
    bool are_found = true;
  };
  // A solid's beginning in a pixel.
  struct Underside {
    std::uint32_t pixel;  // of window_
    std::size_t full_from;
    std::uint8_t next_share;  // light of the layer beneath full_from, in 255ths
  };
  struct Exclusion {
    std::size_t layer, model, copy;
    std::shared_ptr<const SectionSource> supports;
  };
  struct Dark {
    std::vector<Exclusion> exclusions{};  // from the plate up
    std::size_t known = 0;                // number of the first ones, which the pictures leave dark
  };
  using Picture = LayerPictures::Picture;
  struct SupportPictures {
    Picture beneath, here;  // of the layer beneath layer_, and of layer_
  };

  [[nodiscard]] std::size_t exclusions_at(std::size_t layer) const;
  void leave_dark(std::size_t exclusions);
  void restart_before(std::size_t layer);
  void find_entries(MaskBudget& budget);
  void advance();
  [[nodiscard]] bool has_pictures() const;
  // Returns the coverage of a layer from the one beneath layer_ up to the last that was computed ahead.
  [[nodiscard]] const Picture& ahead(std::size_t layer) const { return ahead_[layer + 1 - layer_]; }
  // False if the budget was overrun.
  [[nodiscard]] bool find_undersides(MaskBudget& budget);
  [[nodiscard]] double top_of_solid_mm(std::size_t end) const;
  // Returns the pixel's underside; nullopt if it keeps its light. Reads column_.
  [[nodiscard]] std::optional<Underside> underside_of(std::size_t pixel);
  // Finds the undersides of rims, rising pixels of solids that are lit in part. A rim is not lit before all
  // pixels beside it whose undersides were found from number `first` on: it would have no hold.
  void find_rims(std::span<const std::size_t> rims, std::size_t first);
  [[nodiscard]] bool is_wide(std::size_t pixel, const Picture& picture) const;
  void list_dimmed();

  PixelWindow window_;
  LayerPictures models_;
  std::optional<LayerPictures> supports_;
  DisplayGeometry display_;
  std::vector<LayerDose> layers_;
  std::size_t most_ahead_;

  Dark dark_;
  std::size_t layer_ = 0;      // that of dimmed_
  std::deque<Picture> ahead_;  // of the models, from the layer beneath layer_ up
  SupportPictures supports_at_;
  ModelEntries entries_;
  std::vector<std::uint8_t> column_;  // coverage of the last solid, by layer
  SolidLight light_;
  std::vector<Underside> undersides_;
  Dimmed dimmed_;
};

// Makes the masks of a print with dimmed undersides. Not thread-safe.
class DimmedMasks {
 public:
  // `tone` and `uniformity` are the print's, see ExposureCorrection.
  DimmedMasks(std::unique_ptr<UndersideDimming> undersides, const ToneCurve& tone,
              std::optional<Mask> uniformity);

  // Does beforehand the work for a layer's mask that does not need its coverage. Costs and requires what
  // UndersideDimming::dimmed() does.
  void look_ahead(std::size_t layer) { (void)undersides_->dimmed(layer); }
  // Returns the mask of a layer by its coverage, that of the models and what is beside them. Valid until the
  // next call. Looks ahead, unless that has been done.
  [[nodiscard]] const Mask& mask(std::size_t layer, const Mask& coverage);
  [[nodiscard]] UndersideDimming& dimming() { return *undersides_; }
  // Does what UndersideDimming::are_found() does.
  [[nodiscard]] bool are_found(std::size_t layer) const { return undersides_->are_found(layer); }
  // Returns the light of the last mask, before uniformity mask and gamma. Valid until the next mask.
  [[nodiscard]] const Mask& light() const { return light_; }

 private:
  std::unique_ptr<UndersideDimming> undersides_;
  ExposureCorrection threshold_, projector_;
  Mask light_, mask_;
};

}  // namespace contourd
