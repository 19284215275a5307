// The page of `contourctl orient --html`: the best orientations, each with its picture and figures. One
// self-contained file. Thread-safe.
#pragma once

#include <span>
#include <string>

#include "core/mask/mask.hpp"
#include "daemon/prepare/model_orientation.hpp"

namespace contourd::ctl {

// Draws the model as `contourctl preview` does, with this direction up. `facets` are the model's, scaled as
// printed.
[[nodiscard]] Mask picture_of(std::span<const Facet> facets, const Direction& up);

// Returns the page as HTML. `name`: the model's file name; `pictures`: one for each orientation of
// reported().
[[nodiscard]] std::string orientation_page(const std::string& name, const ModelOrientation& orientation,
                                           std::span<const Mask> pictures);

}  // namespace contourd::ctl
