// Finds how much of each facet lies on the surface of the solid that a model's bodies form together. Pure
// function, thread-safe. Deterministic.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// Returns, by facet, the part of its area that counts: 0 within another body or where it touches one, 1/n
// where the surfaces of n bodies lie on each other. Empty if all of every facet counts: the model has one
// body, or its bodies are apart. A body is a set of facets that are connected by edges. Facets face outwards.
// Takes up to a second: beyond a limit on the work, the smaller facets count fully.
[[nodiscard]] std::vector<double> exposed_parts(std::span<const Facet> facets);

}  // namespace contourd
