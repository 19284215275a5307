// Parts, and dirt as files have it: what the core should see through. Values; thread-safe.
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
  // Its solids share edges or walls of two facets: little tells how they belong together.
  bool joined = false;
};
// Closed, of a few thousand facets each, up to 30 mm wide.
[[nodiscard]] std::vector<Part> clean_parts();

struct Dirt {
  const char* name;
  double wanted;     // the least overlap of a layer with the clean one
  bool may_be_told;  // less will do where the layer's report says that it was guessed at
  bool heavy;        // too much for solids that are joined
  std::function<void(models::Facets&, models::Dice&)> add;
};
[[nodiscard]] std::vector<Dirt> all_dirt();

}  // namespace contourd::reference
