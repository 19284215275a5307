// The file of a cured part's surface. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/cure/cured_part.hpp"

namespace contourd::ctl {

// The largest number of facets in a file, some 200 MB.
inline constexpr std::uint32_t kMostSurfaceFacets = 4'000'000;

struct WrittenSurface {
  std::uint32_t facets = 0;
  std::int32_t step = 1;  // the surface is computed on lines through every step-th pixel
};

// Writes the surface as a binary STL file, which is complete or absent: through every pixel, or through every
// second, fourth and so on if these are more than kMostSurfaceFacets. Cures the part once for each step that
// is tried. Throws OutputError.
WrittenSurface write_cured_surface(const std::filesystem::path& path, PrintCure& print);

}  // namespace contourd::ctl
