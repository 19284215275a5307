// The plan for a print of a small box, and the simulated printer for it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/print/print_plan.hpp"
#include "hw/simulated_printer.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

inline constexpr DisplayGeometry kSmallDisplay{Pixels{64}, Pixels{48}, Micrometers{100.0}};
inline constexpr Nanometers kBoxLayer{50'000};

// Returns the configuration of a simulated printer with kSmallDisplay.
[[nodiscard]] inline SimulatedPrinterConfig small_printer() {
  SimulatedPrinterConfig config;
  config.display.width = kSmallDisplay.width;
  config.display.height = kSmallDisplay.height;
  return config;
}

// Returns the plan for a box of 3 x 2 mm with this number of layers, each kBoxLayer thick. The exposure is 1
// s for the first layer and 100 ms more for each further layer.
[[nodiscard]] inline PrintPlan box_plan(int layers) {
  using namespace std::chrono_literals;
  PrintPlan plan;
  plan.job = "box";
  const double height = to_millimeters(kBoxLayer).count() * layers;
  HeightIndex box(models::box({0, 0, 0}, {3, 2, static_cast<float>(height)}));
  plan.engine = std::make_unique<ContourEngine>(std::move(box), EngineSettings{.display = kSmallDisplay},
                                                std::vector{PixelMap::true_scale(kSmallDisplay, {1.5, 1})});
  plan.layers = PrintLayers(LayerStack{kBoxLayer, layers});
  plan.expected_layers = plan.layers.all();
  plan.exposure = [](std::int32_t layer, Nanometers) { return 1s + 100ms * layer; };
  plan.pixel_area_mm2 = 0.01;
  plan.motion.lift = Nanometers{6'000'000};
  plan.motion.lift_speed = MillimetersPerSecond{2};
  plan.motion.retract_speed = plan.travel_speed = plan.homing_speed = MillimetersPerSecond{5};
  plan.motion.settle = 700ms;
  plan.motion.rest = 300ms;
  return plan;
}

}  // namespace contourd::testing
