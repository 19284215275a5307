// Facets without area beside a model: a line or a point that an exporter left far away. It prints nothing,
// but would count in the model's size and position. Thread-safe (no shared state).
#pragma once

#include "core/model/model.hpp"

namespace contourd {

// Removes the facets without area that reach out of the box around the facets with area, and adds a warning
// that says how many, and where the first is. Changes nothing if no facet has an area.
void drop_stray_facets(Model& model);

}  // namespace contourd
