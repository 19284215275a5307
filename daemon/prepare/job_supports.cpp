#include "daemon/prepare/job_supports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/support/support_lift.hpp"

namespace contourd {
namespace {

// Returns the gap between models: room for one foot, and its clearance on both sides.
Millimeters gap_for(const SupportSettings& settings) {
  return std::max(kCopyGap, settings.foot_diameter + 2 * settings.clearance);
}

bool needs_any(const Supports& supports) {
  return !supports.contacts.empty() || !supports.unheld.empty();
}

}  // namespace

void lift_models(std::vector<ModelToPlace>& models, const SupportSettings& settings, Nanometers layer,
                 const BuildVolume& volume) {
  for (ModelToPlace& model : models) {
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
    PlateModel& model = standing.emplace_back(PlateModel{models[i].standing(), {}, models[i].holes});
    const Point middle = model.model->bounds().center();
    for (const Point& center : arrangement[i]) {
      // The point of the model that lies at the display's centre.
      model.copies.push_back(PixelMap::true_scale(display, {middle.x - center.x, middle.y - center.y}));
    }
  }
  return standing;
}

std::optional<Supports> PlateHolding::supports_of(const Arrangement& arrangement,
                                                  const std::stop_token& stop) const {
  SupportRequest request{stand_on_plate(models_, arrangement, volume_.display), volume_.display, settings_};
  content_.require_room_for_supports(request.models, volume_.display);
  return make_supports(request, stop);
}

std::optional<HeldPlate> PlateHolding::hold(Nanometers layer, const std::stop_token& stop) const {
  const bool lifted = std::ranges::any_of(
      models_, [](const ModelToPlace& model) { return model.elevation.above_plate() > Nanometers{}; });
  const auto arranged = [&](Millimeters gap) {
    Arrangement arrangement = arrange(models_, volume_, gap);
    check_arrangement(models_, arrangement, volume_, layer);
    return arrangement;
  };
  HeldPlate held{arranged(lifted ? gap_for(settings_) : kCopyGap), {}};
  std::optional<Supports> supports = supports_of(held.arrangement, stop);
  if (!supports) return std::nullopt;
  if (needs_any(*supports) && !lifted) {
    Arrangement wide = arranged(gap_for(settings_));
    if (wide != held.arrangement) {
      held.arrangement = std::move(wide);
      supports = supports_of(held.arrangement, stop);
      if (!supports) return std::nullopt;
    }
  }
  held.supports = std::move(*supports);
  return held;
}

}  // namespace contourd
