// Chooses few contacts for what of a layer needs holding: each time the topmost pixel that is not held gets
// one, there where it holds most of the others too. Keeps its memory between layers. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/overhangs/sweep_grid.hpp"
#include "core/overhangs/underside.hpp"

namespace contourd {

// How far what a contact holds may be from it, in pixels.
struct HoldingRadii {
  double bridge;  // in the same layer
  double reach;   // where material goes on growing from it
};

class OverhangCover {
 public:
  enum class Need : std::uint8_t {
    None,
    Soon,    // reaches out nearly too far: is held with those that do
    Reach,   // reaches out too far
    Bridge,  // is too far from what carries it in this layer
  };
  struct Spot {
    SweepPixel at;
    std::uint32_t part;
    Need need;
  };
  struct Choice {
    SweepPixel at;         // where the contact is best
    SweepPixel needed_by;  // whose it is in any case
    std::uint32_t part;
  };

  explicit OverhangCover(const HoldingRadii& radii) : radii_(radii) {}

  [[nodiscard]] const HoldingRadii& radii() const { return radii_; }

  // What needs holding in a layer, from the top row down.
  void set_spots(std::vector<Spot>& spots);
  // The next contact. Nothing when all is held.
  [[nodiscard]] std::optional<Choice> choose();
  // There is one: gives how many spots it holds. `at` is in the choice's part.
  [[nodiscard]] std::int64_t hold(SweepPixel at, const Choice& choice);

 private:
  [[nodiscard]] double radius_for(Need need) const {
    return need == Need::Bridge ? radii_.bridge : radii_.reach;
  }
  [[nodiscard]] SweepPixel best_for(const Spot& spot);

  HoldingRadii radii_;
  std::vector<Spot> spots_;
  std::size_t next_ = 0;  // all before it are held
  std::vector<SweepPixel> near_;
};

}  // namespace contourd
