// Distances between the part that a print's light makes and the model: undersides, tops and walls, each
// along the surface's normal. Not thread-safe.
//
// Undersides and tops are measured on vertical lines through all pixels' middles, where they face up or down
// by at least 30 degrees from the vertical; walls on horizontal lines along rows and columns of pixels, in
// the middle of some layers, where they face a line by at most 45 degrees. Undersides on the plate do not
// count.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "core/cure/cured_layers.hpp"
#include "core/cure/stop_check.hpp"
#include "core/cure/surface_rays.hpp"
#include "core/engine/contour_engine.hpp"

namespace contourd {

// A place on the plate: millimetres from its centre, seen from above, and above it.
struct CurePlace {
  Point plate_mm{};
  double height_mm = 0;
};

// Numbers of places by their distances. The first and the last bin also have the places beyond them, one in
// two hundred at most.
struct DistanceBins {
  double first_um = 0;  // middle of the first bin; middles are multiples of the width
  double width_um = 1;
  std::vector<std::uint64_t> places{};
};

// Distances of one kind of surface. Positive where the part is too large.
struct SurfaceDistances {
  std::uint64_t places = 0;   // where the part's surface was found
  std::uint64_t missing = 0;  // where the part has no such surface near the model's
  double median_um = 0;
  double p95_um = 0;    // 95 % are off by at most this
  double worst_um = 0;  // the largest, with its sign
  CurePlace worst{};
  DistanceBins bins{};
};

// The vertical section through the middles of the row of pixels at the worst underside; of the worst top or
// wall if the part has none.
struct CureSection {
  struct Stretch {
    std::uint32_t column;   // rising
    double from_mm, to_mm;  // above the plate
  };
  CurePlace at{};       // the worst place
  double worst_um = 0;  // the distance there
  double pixel_mm = 0;  // 0: there is no such place
  // Places of the columns' middles, from the plate's centre: that of column 0, and the distance to the next
  // one, which is negative on a mirrored display.
  double first_x_mm = 0, step_mm = 0;
  std::vector<Stretch> model{}, cured{};  // along the row
};

struct CureFigures {
  SurfaceDistances undersides, tops, walls;
  double model_mm3 = 0;
  double too_much_mm3 = 0;    // solid outside the model
  double too_little_mm3 = 0;  // part of the model that stays liquid
  // Gaps above which a part of the model begins, closed from top to bottom by the light that passes through
  // it. Gaps of supports, and those beside a support, are no channels of the model and do not count.
  double closed_mm2 = 0;
  double tallest_closed_mm = 0;
  CurePlace closed{};  // the tallest one
  CureSection section{};
};

// The height up to which a model was printed, in millimetres above the plate.
struct PrintedUpTo {
  double top_mm = std::numeric_limits<double>::infinity();   // end of its last layer, and of the model
  double mask_mm = std::numeric_limits<double>::infinity();  // cut of its last mask; solids that begin
                                                             // above it do not count
};

// A model, and how much of it was printed. The end of one that goes on above is no surface of the model.
struct ComparedModel {
  PlateModel model;
  PrintedUpTo up_to{};
};

class CureComparison {
 public:
  // Prepares the comparison with models on a display's window of pixels, for layers from the plate up. Walls
  // are measured on at most kWallLayers layers. `support` are supports, which belong to the model but are not
  // measured. Throws ComputationStopped, as figures() does, if `is_stopped`, which may be empty, returns
  // true. REQUIRES: no null pointers; rising layers.
  CureComparison(std::span<const ComparedModel> models, std::span<const ComparedModel> supports,
                 const DisplayGeometry& display, const PixelWindow& window, std::span<const LayerDose> layers,
                 std::function<bool()> is_stopped = {});

  static constexpr std::size_t kWallLayers = 100;

  // Adds a layer, by its number, with the doses that CuredLayers returned. REQUIRES: all layers, each once,
  // from the top down.
  void add_layer(std::size_t layer, const CuredLayers& cured, std::span<const float> dose);

  // Returns the figures. REQUIRES: all layers were added.
  [[nodiscard]] CureFigures figures();

 private:
  struct Stretch {
    std::uint32_t pixel;
    float from, to;
  };
  struct Distance {
    float um;
    std::uint32_t pixel;
    float height_mm;
  };
  struct Ends {
    std::vector<Distance> distances;
    std::uint64_t missing = 0;
  };
  static DistanceBins bins_of(std::vector<Distance>& distances);
  struct Walls {
    RayAxis axis;
    std::vector<RayCrossing> crossings;  // by ray
    std::vector<Distance> distances;
    std::uint64_t missing = 0;
  };

  [[nodiscard]] bool goes_on(std::size_t first, std::size_t end, std::span<const float> dose,
                             float whole) const;
  void measure_walls(Walls& walls, std::size_t height, const CuredLayers& cured, std::size_t layer,
                     std::span<const float> dose);
  void compare_column(std::span<const RayStretch> model, std::span<const Stretch> cured);
  [[nodiscard]] bool is_beside_support(std::uint32_t pixel, double from_mm, double to_mm) const;
  void compare_end(const RayCrossing& end, double outwards_mm, std::vector<Distance>& distances);
  [[nodiscard]] SurfaceDistances summary(std::vector<Distance> distances, std::uint64_t missing) const;
  [[nodiscard]] CureSection section(const SurfaceDistances& through) const;
  [[nodiscard]] CurePlace place(std::uint32_t pixel, double height_mm) const;

  StopCheck check_;
  DisplayGeometry display_;
  PixelWindow window_;
  double pixel_mm_;
  std::vector<LayerDose> layers_;
  std::vector<RayStretch> model_, supports_;  // vertical; those of supports are part of model_, too
  std::vector<std::size_t> wall_layers_;      // rising
  std::array<Walls, 2> walls_;
  std::size_t layers_left_;  // layers that were not added yet
  std::vector<float>
      solid_until_;  // by pixel: top of the solid that reaches the last layer's bottom; 0: none
  std::vector<Stretch> cured_;
  Ends undersides_, tops_;
  CureFigures figures_;
};

}  // namespace contourd
