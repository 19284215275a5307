// Chooses a small set of contacts for the pixels of a layer that need holding. Each step places a contact for
// the topmost pixel that is not held yet, where it also holds most of the others. A sliver of pixels that
// remains between contacts, hardly out of their reach, gets no contact. Keeps its memory between layers. Not
// thread-safe.
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
  double slack;   // beyond `bridge`, for slivers: groups of at most slack * slack pixels
};

class OverhangCover {
 public:
  enum class Need : std::uint8_t {
    None,
    Soon,    // nearly reaches out too far: held together with pixels that do
    Reach,   // reaches out too far
    Sliver,  // set aside: bridges too far, but a contact would hold few pixels
    Bridge,  // too far from the material beneath that carries it
  };
  struct Spot {
    SweepPixel at;
    std::uint32_t part;
    Need need;
    double beyond = 0;  // pixels by which it bridges too far from the nearest material or contact
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
  // Chooses the next contact; nullopt if all spots are held, or belong to slivers.
  [[nodiscard]] std::optional<Choice> choose();
  // Places a contact for the choice and returns how many spots it holds. `at` is in the choice's part.
  [[nodiscard]] std::int64_t hold(SweepPixel at, const Choice& choice);

 private:
  [[nodiscard]] double radius_for(Need need) const {
    return need >= Need::Sliver ? radii_.bridge : radii_.reach;
  }
  [[nodiscard]] bool find_pending();
  [[nodiscard]] bool set_sliver_aside(const Choice& choice);
  void take_up_slivers();
  [[nodiscard]] bool is_held_by(const Choice& choice, SweepPixel at, const Spot& spot) const;
  [[nodiscard]] SweepPixel best_for(const Spot& spot);

  HoldingRadii radii_;
  std::vector<Spot> spots_;
  std::size_t next_ = 0;            // all spots before this one are held or set aside
  bool sets_slivers_aside_ = true;  // until nothing else needs a contact
  int slivers_left_ = 4096;         // how many more are set aside in all layers, which bounds the time
  std::vector<SweepPixel> near_;
};

}  // namespace contourd
