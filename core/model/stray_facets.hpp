// Facets beside a model that print nothing: a line or a point that an exporter left far away, a sliver, or a
// pair of facets that cancel each other. They would count in the model's size and position. Thread-safe (no
// shared state).
#pragma once

#include "core/model/model.hpp"

namespace contourd {

// Removes the facets without area that reach out of the box around the facets with area, then the facets that
// enclose nothing (see void_facets()). Adds a warning for each kind that says how many there are, and where
// the first is. Changes nothing if no facet would be left.
void drop_stray_facets(Model& model);

}  // namespace contourd
