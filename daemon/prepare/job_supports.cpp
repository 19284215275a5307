#include "daemon/prepare/job_supports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/orientation/nearly_level_base.hpp"
#include "core/overhangs/carried_supports.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/support/support_lift.hpp"

namespace contourd {
namespace {

bool needs_any(const Supports& supports) {
  return !supports.contacts.empty() || !supports.unheld.empty();
}

Arrangement arranged(const PlateToHold& plate, Millimeters gap) {
  Arrangement arrangement = arrange(plate.models, plate.volume, gap);
  check_arrangement(plate.models, arrangement, plate.volume, plate.layer);
  return arrangement;
}

std::optional<Supports> supports_of(const PlateToHold& plate, const Arrangement& arrangement,
                                    const std::stop_token& stop) {
  const DisplayGeometry& display = plate.volume.display;
  SupportRequest request{{}, display, plate.settings, {}, plate.printed};
  const std::vector<PlateModel> standing = stand_on_plate(plate.models, arrangement, display);
  plate.content.require_room_for_supports(standing, display);
  for (std::size_t i = 0; i < standing.size(); ++i)
    (plate.models[i].own_supports == OwnSupports::Kept ? request.carriers : request.models)
        .push_back(standing[i]);
  return make_supports(request, stop);
}

}  // namespace

Millimeters gap_for_supports(const SupportSettings& settings) {
  return std::max(kCopyGap, settings.foot_diameter + 2 * settings.clearance);
}

OwnSupports find_own_supports(const std::shared_ptr<const HeightIndex>& model,
                              const SupportSettings& settings, SupportPolicy policy,
                              const std::stop_token& stop) {
  if (policy == SupportPolicy::InFile) return OwnSupports::Kept;
  const bool low_enough = Millimeters{model->bounds().size_z()} <= kHighestSweep;
  if (!low_enough || !carries_supports(model, settings, stop)) return OwnSupports::None;
  return policy == SupportPolicy::On ? OwnSupports::Overruled : OwnSupports::Kept;
}

std::string own_supports_sentence(std::string_view model, OwnSupports own, std::string_view program) {
  if (own == OwnSupports::None) return {};
  return fmt::format("{} carries supports in its file, {}", model,
                     own == OwnSupports::Kept
                         ? fmt::format("so {} adds none", program)
                         : fmt::format("but {} supports it like any other model, as asked", program));
}

std::string tilted_base_sentence(std::string_view name, const HeightIndex& model,
                                 const SupportSettings& settings, Nanometers layer, std::string_view advice) {
  const std::optional<LevelBase> base = nearly_level_base(model.facets(), settings, layer);
  if (!base) return "";
  return fmt::format(
      "{} is tilted: it would stand on the plate without supports under its base if it were turned by {:.2g} "
      "degrees; {}",
      name, base->tilt_deg, advice);
}

void lift_models(std::vector<ModelToPlace>& models, const SupportSettings& settings, Nanometers layer,
                 const BuildVolume& volume) {
  for (ModelToPlace& model : models) {
    if (model.own_supports == OwnSupports::Kept) continue;
    const Nanometers lift = support_lift(*model.model, settings, layer);
    model.elevation = Elevation(lift);
    const double top_mm = model.standing().top().count();
    // A thousandth of a millimetre: the rounding of float coordinates.
    if (lift == Nanometers{} || top_mm <= volume.height_mm + 1e-3) continue;
    throw JobRefused(fmt::format(
        "{} is {:.2f} mm high and stands {:.2f} mm above the plate, on supports: {:.2f} mm, and the machine "
        "can print {:.2f} mm (its travel less the lift)",
        model.name, model.model->bounds().size_z(), to_millimeters(lift).count(), top_mm, volume.height_mm));
  }
}

std::vector<PlateModel> stand_on_plate(const std::vector<ModelToPlace>& models,
                                       const Arrangement& arrangement, const DisplayGeometry& display) {
  std::vector<PlateModel> standing;
  for (std::size_t i = 0; i < models.size(); ++i) {
    PlateModel& model = standing.emplace_back(
        PlateModel{models[i].standing(), {}, models[i].holes, models[i].pictures, models[i].outlines});
    const Point middle = model.model->bounds().center();
    for (const Point& center : arrangement[i]) {
      // The point of the model that lies at the display's centre.
      model.copies.push_back(PixelMap::true_scale(display, {middle.x - center.x, middle.y - center.y}));
    }
  }
  return standing;
}

std::optional<HeldPlate> hold_plate(const PlateToHold& plate, const std::stop_token& stop) {
  const bool lifted = std::ranges::any_of(
      plate.models, [](const ModelToPlace& model) { return model.elevation.above_plate() > Nanometers{}; });
  HeldPlate held{arranged(plate, lifted ? gap_for_supports(plate.settings) : kCopyGap), {}};
  std::optional<Supports> supports = supports_of(plate, held.arrangement, stop);
  if (supports && needs_any(*supports) && !lifted) {
    Arrangement wide = arranged(plate, gap_for_supports(plate.settings));
    if (wide != held.arrangement) {
      held.arrangement = std::move(wide);
      supports = supports_of(plate, held.arrangement, stop);
    }
  }
  if (!supports) return std::nullopt;
  held.supports = std::move(*supports);
  return held;
}

}  // namespace contourd
