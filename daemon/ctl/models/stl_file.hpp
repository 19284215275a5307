// Binary STL files, as contourctl writes them. Pure; thread-safe.
#pragma once

#include <span>
#include <string>

#include "core/geometry/facet.hpp"

namespace contourd::ctl {

// Returns the bytes of a file with these facets. Its header says `what` they are, in up to 65 bytes. The
// normals are 0, because programs compute them from the facets.
[[nodiscard]] std::string binary_stl(std::span<const Facet> facets, const std::string& what);

}  // namespace contourd::ctl
