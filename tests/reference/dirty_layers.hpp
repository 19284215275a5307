// Compares the masks of a dirty model with those of its clean original. Thread-safe (no shared state).
#pragma once

#include <span>

#include "tests/models/models.hpp"

namespace contourd::reference {

struct WorstLayer {
  double overlap = 1;
  int layers = 0;    // number of layers compared: those of at least 1,000 pixels
  bool told = true;  // true if each layer below the wanted overlap reports that it was guessed
};

// Returns the worst of the layers at these parts of the height, on 640 x 640 pixels of 50 um. REQUIRES:
// `clean` is closed.
[[nodiscard]] WorstLayer worst_layer(const models::Facets& clean, const models::Facets& dirty, double wanted,
                                     std::span<const double> heights);

}  // namespace contourd::reference
