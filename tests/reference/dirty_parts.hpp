// Test parts, and defects as found in files, which the core should repair. Values; thread-safe.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

namespace contourd::reference {

struct Part {
  std::string name;
  models::Facets facets;
  // True if its solids share edges or walls of two facets, so that little shows how they belong together.
  bool joined = false;
};
// Returns closed parts of a few thousand facets each, up to 30 mm wide.
[[nodiscard]] std::vector<Part> clean_parts();

struct Dirt {
  const char* name;
  double wanted;     // least overlap of a layer with the clean one
  bool may_be_told;  // less is accepted if the layer's report says that it was guessed
  bool heavy;        // too much for joined solids
  std::function<void(models::Facets&, models::Dice&)> add;
};
[[nodiscard]] std::vector<Dirt> all_dirt();

}  // namespace contourd::reference
