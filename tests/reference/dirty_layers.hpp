// How much the masks of a dirty model differ from what its clean one should be. Thread-safe (no shared
// state).
#pragma once

#include <span>

#include "tests/models/models.hpp"

namespace contourd::reference {

struct WorstLayer {
  double overlap = 1;
  int layers = 0;    // judged: those of at least 1,000 pixels
  bool told = true;  // each layer of less than the wanted overlap says that it was guessed at
};

// Layers at these parts of the height, on 640 x 640 pixels of 50 um. REQUIRES: `clean` is closed.
[[nodiscard]] WorstLayer worst_layer(const models::Facets& clean, const models::Facets& dirty, double wanted,
                                     std::span<const double> heights);

}  // namespace contourd::reference
