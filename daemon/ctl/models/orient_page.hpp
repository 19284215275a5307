// The page that `contourctl orient --html` writes: the ways up that were rated best, each with its picture
// and its figures. One file that needs nothing else. Thread-safe.
#pragma once

#include <span>
#include <string>

#include "core/mask/mask.hpp"
#include "daemon/prepare/model_orientation.hpp"

namespace contourd::ctl {

// What `contourctl preview` shows, with that direction up. `facets` are the model's, as large as it is
// printed.
[[nodiscard]] Mask picture_of(std::span<const Facet> facets, const Direction& up);

// A picture for each of told_of(). `name` is the model's file's.
[[nodiscard]] std::string orientation_page(const std::string& name, const ModelOrientation& orientation,
                                           std::span<const Mask> pictures);

}  // namespace contourd::ctl
