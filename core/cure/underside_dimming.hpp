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
#include <memory>
#include <optional>
#include <span>
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

// Multiplies the light of pixels by their shares. REQUIRES: pixels of the mask.
void dim(std::span<const DimmedPixel> pixels, Mask& light);

// Returns the pixels of the display on which models stand, with a margin; one pixel if there are none.
[[nodiscard]] PixelWindow window_of(std::span<const PlateModel> models, const DisplayGeometry& display,
                                    std::int32_t margin);

// The light that a print without dimming would give, and its resin.
struct UndersideCure {
  std::vector<LayerDose> layers;
  CureSettings resin{};
  std::chrono::nanoseconds mask_budget{};  // for a mask that is computed ahead
};

class UndersideDimming {
 public:
  // Prepares the dimming of a print whose engine has these models, settings and sections beside the models
  // (`supports`, null if there are none). REQUIRES: no null models; the print's layers, rising from the
  // plate; settings within their ranges.
  UndersideDimming(std::span<const PlateModel> models, std::shared_ptr<const SectionSource> supports,
                   const EngineSettings& settings, const UndersideCure& cure);

  static constexpr std::size_t kMostAhead = 40;

  // Returns an upper bound of the memory in bytes, without that for sections.
  [[nodiscard]] static std::uint64_t most_memory(const DisplayGeometry& display, const UndersideCure& cure);

  // Returns the pixels of a layer that get less light than their mask gives them. Valid until the next call.
  // Costs a mask if the layer follows the last one; else up to twice as many as there are layers ahead. A
  // mask that overruns its budget counts as dark. REQUIRES: a layer of the print.
  [[nodiscard]] std::span<const DimmedPixel> dimmed(std::size_t layer);

 private:
  // A solid's beginning in a pixel.
  struct Underside {
    std::uint32_t pixel;  // of window_
    std::size_t full_from;
    std::uint8_t next_share;  // light of the layer beneath full_from, in 255ths
  };
  using Picture = std::vector<std::uint8_t>;  // coverage of window_'s pixels

  // A pixel's layers from the one that begins at layer_ to the next dark one.
  struct Solid {
    std::size_t pixel;
    double from_mm;
    std::size_t end;  // the first dark layer, or the first that was not computed
    bool is_endless;  // no dark layer was found
  };

  void restart_before(std::size_t layer);
  void advance();
  [[nodiscard]] Picture picture(ContourEngine& engine, std::size_t layer) const;
  // Returns the coverage of a layer from the one beneath layer_ up to the last that was computed ahead.
  [[nodiscard]] const Picture& ahead(std::size_t layer) const { return ahead_[layer - first_ahead_]; }
  void find_heights();
  void find_full_doses();
  void find_undersides();
  void find_underside(std::size_t pixel);
  [[nodiscard]] UndersideLight light_of(const Solid& solid);
  [[nodiscard]] bool is_wide(std::size_t pixel, const Picture& picture) const;
  void list_dimmed();

  ContourEngine models_;
  std::optional<ContourEngine> supports_;
  Pixels display_width_;
  std::vector<LayerDose> layers_;
  CureSettings resin_;
  PeelLoss loss_;
  std::chrono::nanoseconds mask_budget_;
  PixelWindow window_;
  std::size_t most_ahead_;

  std::size_t layer_ = 0;  // that of dimmed_
  bool is_started_ = false;
  std::size_t first_ahead_ = 0;  // layer of ahead_.front()
  std::deque<Picture> ahead_;    // models
  Picture supports_beneath_, supports_here_;
  std::vector<float> height_mm_;       // by pixel: lowest entry into a model about layer_; 0: none
  std::vector<RayCrossing> entries_;   // the entries of height_mm_
  std::vector<double> full_doses_;     // at layer_'s bottom, by layer from layer_ up
  std::vector<double> doses_;          // of the last solid
  std::vector<UndersideLight> known_;  // of solids that are fully lit, by height and number of layers
  std::vector<Underside> undersides_;
  std::vector<DimmedPixel> dimmed_;
};

// Makes the masks of a print with dimmed undersides. Not thread-safe.
class DimmedMasks {
 public:
  // `tone` and `uniformity` are the print's, see ExposureCorrection.
  DimmedMasks(std::unique_ptr<UndersideDimming> undersides, const ToneCurve& tone,
              std::optional<Mask> uniformity);

  // Returns the mask of a layer by its coverage, that of the models and what is beside them. Valid until the
  // next call. Costs what UndersideDimming::dimmed() does. REQUIRES: a layer of the print.
  [[nodiscard]] const Mask& mask(std::size_t layer, const Mask& coverage);
  // Returns the light of the last mask, before uniformity mask and gamma. Valid until the next mask.
  [[nodiscard]] const Mask& light() const { return light_; }

 private:
  std::unique_ptr<UndersideDimming> undersides_;
  ExposureCorrection threshold_, projector_;
  Mask light_, mask_;
};

}  // namespace contourd
