// Engines over a build area of 24 by 22 mm, whose centre is a point of the model, (0, 0) if none is given.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "core/engine/contour_engine.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

inline constexpr DisplayGeometry kFineDisplay{Pixels{480}, Pixels{440}, Micrometers{50.0}};
inline constexpr DisplayGeometry kCoarseDisplay{Pixels{240}, Pixels{220}, Micrometers{100.0}};
inline constexpr Nanometers kCoarseLayer{100'000}, kThickLayer{500'000};

constexpr Nanometers mm(std::int64_t count) {
  return Nanometers{count * 1'000'000};
}

inline std::shared_ptr<const HeightIndex> shared_index(models::Facets facets) {
  return std::make_shared<const HeightIndex>(std::move(facets));
}

inline PlateModel plate_model(std::shared_ptr<const HeightIndex> model, Elevation elevation = {},
                              const DisplayGeometry& display = kCoarseDisplay, Point center = {0, 0}) {
  return {{std::move(model), elevation}, {PixelMap::true_scale(display, center)}};
}
inline PlateModel plate_model(models::Facets facets, Elevation elevation = {},
                              const DisplayGeometry& display = kCoarseDisplay, Point center = {0, 0}) {
  return plate_model(shared_index(std::move(facets)), elevation, display, center);
}

inline ContourEngine engine_for(models::Facets facets, const EngineSettings& settings = {kFineDisplay},
                                Point center = {0, 0}) {
  return {HeightIndex(std::move(facets)), settings, {PixelMap::true_scale(settings.display, center)}};
}

}  // namespace contourd::testing
