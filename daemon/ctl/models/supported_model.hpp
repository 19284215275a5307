// A model that contourctl prepares without a printer's configuration: turned and scaled, in the middle of a
// display, with supports if wanted. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "core/model/model.hpp"
#include "core/routing/support_layout.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

// The number of bottom layers without a resin's profile.
inline constexpr std::int32_t kBottomLayers = 5;
// Limits without a printer's configuration: every size fits, and supports are as by default.
inline constexpr OrientationLimits kAnyPrinter{
    {Millimeters{1e9}, Millimeters{1e9}, Millimeters{1e9}}, Scale{}, {}, {}};

// Reads a model, turns it so that `up` points up, and scales it by the factor, each if given. If the best
// orientation is to be found, uses kAnyPrinter and prints the orientation on stderr. Throws the exceptions of
// read_model(), and ModelError if coordinates leave the range of numbers.
[[nodiscard]] Model read_turned_model(const std::filesystem::path& path, const std::optional<UpOption>& up,
                                      const SizeArgs& size);

// Longest time for a mask that a check of the model looks at.
inline constexpr Duration kLongestMask = std::chrono::seconds(5);

struct SupportedModel {
  PlateModel model;                    // one copy
  std::optional<Supports> supports{};  // nullopt: not wanted
  OwnSupports own_supports = OwnSupports::None;
  std::string tilt{};  // a warning that the model's base is nearly level; empty if not

  // Returns the warnings about supports and the base, a sentence each.
  [[nodiscard]] std::vector<std::string> warnings() const;
  [[nodiscard]] ContourEngine engine(const EngineSettings& settings) const;
};

struct SupportingOptions {
  DisplayGeometry display;
  Nanometers layer{50'000};                  // the model is lifted by whole layers
  std::optional<AdaptiveLayers> adaptive{};  // instead of layers of one thickness
  Compensation compensation{};
  AntiAliasing anti_aliasing = AntiAliasing::On;
  std::uint8_t threshold = 0;
  SupportPolicy policy = SupportPolicy::Auto;
};

// Prepares a model with supports. Does not move it in x or y. Blocks: see make_supports().
[[nodiscard]] SupportedModel support_model(std::shared_ptr<const HeightIndex> model,
                                           const SupportingOptions& options);
// Returns the layers of a standing model: adaptive ones, or layers of one thickness.
[[nodiscard]] PrintLayers print_layers(const StandingModel& model, Nanometers layer,
                                       const std::optional<AdaptiveLayers>& adaptive);
// Prepares a model without supports.
[[nodiscard]] SupportedModel lay_on_plate(std::shared_ptr<const HeightIndex> model, const PixelMap& map);

}  // namespace contourd::ctl
