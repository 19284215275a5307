// Chooses a small set of contacts for the pixels of a layer that need holding. Each step places a contact for
// the topmost pixel that is not held yet, where it also holds most of the others. Keeps its memory between
// layers. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/overhangs/sweep_grid.hpp"
#include "core/overhangs/underside.hpp"

namespace contourd {

// The distance up to which a contact holds pixels, in pixels.
struct HoldingRadii {
  double bridge;  // within the same layer
  double reach;   // where the material keeps growing outwards from the contact
};

class OverhangCover {
 public:
  enum class Need : std::uint8_t {
    None,
    Soon,    // nearly reaches out too far: held together with pixels that do
    Reach,   // reaches out too far
    Bridge,  // too far from the material beneath that carries it
  };
  struct Spot {
    SweepPixel at;
    std::uint32_t part;
    Need need;
  };
  struct Choice {
    SweepPixel at;         // the best place for the contact
    SweepPixel needed_by;  // the pixel that needs it; held wherever the contact goes
    std::uint32_t part;
  };

  explicit OverhangCover(const HoldingRadii& radii) : radii_(radii) {}

  [[nodiscard]] const HoldingRadii& radii() const { return radii_; }

  // Takes the pixels of a layer that need holding, from the top row down.
  void set_spots(std::vector<Spot>& spots);
  // Chooses the next contact; nullopt if all spots are held.
  [[nodiscard]] std::optional<Choice> choose();
  // Places a contact for the choice and returns how many spots it holds. `at` is in the choice's part.
  [[nodiscard]] std::int64_t hold(SweepPixel at, const Choice& choice);

 private:
  [[nodiscard]] double radius_for(Need need) const {
    return need == Need::Bridge ? radii_.bridge : radii_.reach;
  }
  [[nodiscard]] SweepPixel best_for(const Spot& spot);

  HoldingRadii radii_;
  std::vector<Spot> spots_;
  std::size_t next_ = 0;  // all spots before this one are held
  std::vector<SweepPixel> near_;
};

}  // namespace contourd
