#include "core/orientation/orientation_trial.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/model/height_index.hpp"
#include "core/orientation/orientation_rating.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/overhangs/sweep_grid.hpp"
#include "core/support/support_lift.hpp"

namespace contourd {
namespace {

constexpr Nanometers kLayer{50'000};
// Larger models are not tried.
constexpr double kLargestMm = 1e5;
// Limits on the layers of a trial: facets that they cross, all together; and, if all were like the most
// costly one of those that are cut beforehand, its sides and the steps of all.
constexpr double kMostCrossings = 1e7, kMostSteps = 3e7;
constexpr std::size_t kMostSides = 100'000;
constexpr int kCutBeforehand = 16;

// The model as turned for the trial, on the plate.
struct Turned {
  PlateModel model;
  DisplayGeometry display;
  double scale = 1;  // factor of the trial's lengths
};

SupportSettings scaled(SupportSettings settings, double scale) {
  for (Millimeters SupportSettings::*const length :
       {&SupportSettings::tip_diameter, &SupportSettings::tip_depth, &SupportSettings::tip_length,
        &SupportSettings::pillar_diameter, &SupportSettings::foot_diameter, &SupportSettings::foot_height,
        &SupportSettings::clearance, &SupportSettings::lift, &SupportSettings::bridge,
        &SupportSettings::spacing, &SupportSettings::closed_gap})
    settings.*length = settings.*length * scale;
  settings.tip_holds_mm2 *= scale * scale;
  return settings;
}

DisplayGeometry display_around(const Bounds& bounds) {
  constexpr double kPitchMm = 0.05;
  const auto pixels = [](double length_mm) {
    return Pixels{static_cast<std::int32_t>(std::ceil(length_mm / kPitchMm)) + 2};
  };
  return sweep_grid({pixels(bounds.size_x()), pixels(bounds.size_y()), Micrometers{kPitchMm * 1000}}).display;
}

Turned turned(std::span<const Facet> facets, const OrientationFigures& figures, const Scale& scale) {
  Turned turned;
  turned.scale = std::min(1.0, kMostTrialLayers * in_mm(kLayer) / figures.size_z_mm);
  std::vector<Facet> copy(facets.begin(), facets.end());
  orient(copy, {.scale = scale * Scale(turned.scale), .up = figures.up});
  auto model = std::make_shared<const HeightIndex>(std::move(copy));
  turned.display = display_around(model->bounds());
  const PixelMap map = PixelMap::true_scale(turned.display, model->bounds().center());
  turned.model = PlateModel{{std::move(model)}, {map}};
  return turned;
}

// Returns how often all layers together cross a facet.
double crossings_of(const HeightIndex& model) {
  double heights_mm = 0;
  for (const Facet& facet : model.facets()) {
    const auto [low, high] = heights_of(facet);
    heights_mm += double{high} - low;
  }
  return heights_mm / in_mm(kLayer);
}

// True if the layers are cheap enough to be cut, as far as a sample of them shows.
bool can_be_cut(const Turned& turned) {
  if (crossings_of(*turned.model.model) > kMostCrossings) return false;
  ContourEngine engine({turned.model}, {.display = turned.display, .anti_aliasing = AntiAliasing::Off});
  const double top_mm = turned.model.top().count();
  const double layers = top_mm / in_mm(kLayer);
  for (int cut = 0; cut < kCutBeforehand; ++cut) {
    const Millimeters height{(cut + 0.5) / kCutBeforehand * top_mm};
    MaskBudget budget(std::nullopt, kMostSides);
    if (engine.mask_within(to_nanometers(height).value_or(Nanometers{}), budget) == nullptr ||
        static_cast<double>(budget.steps()) * layers > kMostSteps)
      return false;
  }
  return true;
}

class TrialObserver : public LayerObserver {
 public:
  explicit TrialObserver(double scale) : scale_(scale) {}

  void begin(const DisplayGeometry& sweep_display, Nanometers /*step*/) override {
    pixel_mm_ = to_millimeters(sweep_display.pixel_pitch).count() / scale_;
  }
  void layer(Nanometers /*height*/, const MaskRuns& lit) override {
    std::int64_t pixels = 0;
    for (const PixelRun& run : lit.runs())
      pixels += run.end - run.first;
    largest_mm2_ = std::max(largest_mm2_, static_cast<double>(pixels) * pixel_mm_ * pixel_mm_);
  }

  [[nodiscard]] double largest_mm2() const { return largest_mm2_; }

 private:
  double scale_, pixel_mm_ = 0, largest_mm2_ = 0;
};

}  // namespace

OrientationFigures try_orientation(std::span<const Facet> facets, const OrientationFigures& figures,
                                   const OrientationRequest& request, const std::stop_token& stop) {
  OrientationFigures trial = figures;
  const double largest_mm = std::max({figures.size_x_mm, figures.size_y_mm, figures.size_z_mm});
  if (facets.empty() || !(largest_mm < kLargestMm)) return trial;
  Turned model = turned(facets, figures, request.scale);
  if (!can_be_cut(model)) return trial;
  const SupportSettings settings = scaled(request.supports, model.scale);
  model.model.elevation = Elevation(support_lift(*model.model.model, settings, kLayer));
  TrialObserver observer(model.scale);
  const std::optional<HeldPlaces> held =
      find_overhangs({{model.model}, model.display, settings}, observer, stop);
  if (!held) return trial;
  trial.tried = true;
  // Without supports the lift is 0, whether the model stands or not.
  SupportSettings lifting;
  lifting.closed_gap = settings.closed_gap;
  trial.stands = support_lift(*model.model.model, lifting, kLayer) == Nanometers{};
  trial.largest_mm2 = observer.largest_mm2();
  trial.contacts = static_cast<double>(held->contacts.size());
  trial.support_mm3 = 0;
  for (const SupportContact& contact : held->contacts)
    trial.support_mm3 += pillar_mm3(contact.place.z / model.scale);
  return trial;
}

}  // namespace contourd
