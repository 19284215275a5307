// Judges the peel of each layer by a signal that is active while the force on the plate exceeds a threshold:
// when the layer lets go of the film, and whether it was on the film at all. A layer that was not, after
// others that were, has come off the plate. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/units.hpp"

namespace contourd {

// The peel of a layer.
struct LayerPeel {
  bool felt = false;  // the force rose above the threshold within the lift
  // The way of the plate from the layer's height until the force fell below the threshold for the last time.
  std::optional<Nanometers> distance{};
  bool operator==(const LayerPeel&) const = default;
};

enum class PeelFinding {
  None,
  CameOff,    // the layer was not felt, although smaller ones before it were
  NeverFelt,  // none of the first layers was felt
};

class PeelWatch {
 public:
  // The number of layers that must be felt before one that is not is a finding, and the number of layers
  // that must be silent from the start.
  static constexpr int kFeltBefore = 3, kSilentFromStart = 5;

  // Layers of a smaller area than `least_area_mm2` need not be felt.
  explicit PeelWatch(double least_area_mm2) : least_area_mm2_(least_area_mm2) {}

  // Begins the lift of a layer with the plate at this height and the signal as it is.
  void lift(Nanometers from, bool active) {
    from_ = from;
    began_active_ = stays_active_ = active;
    peel_ = {};
  }
  // Takes a change of the signal. True if the layer has let go now: the force began within the lift, and has
  // ended.
  bool change(bool active, Nanometers height);
  // Returns the peel since lift().
  [[nodiscard]] const LayerPeel& peel() const { return peel_; }
  // Ends the lift of a layer of this area, and judges the layer, unless the signal was active before the
  // lift. After a finding, layers must be felt again before the next one.
  [[nodiscard]] PeelFinding judge(double area_mm2);

 private:
  double least_area_mm2_;
  Nanometers from_{};
  bool began_active_ = false, stays_active_ = false;  // since before the lift
  LayerPeel peel_;
  int felt_ = 0;    // layers since the last finding
  int silent_ = 0;  // layers since the start, while none was felt
  std::optional<double> smallest_felt_mm2_;
};

}  // namespace contourd
