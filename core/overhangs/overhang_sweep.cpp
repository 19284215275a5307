#include "core/overhangs/overhang_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/overhang_cover.hpp"
#include "core/overhangs/peel_balance.hpp"
#include "core/overhangs/surfaces_beneath.hpp"
#include "core/overhangs/sweep_grid.hpp"
#include "core/overhangs/underside.hpp"

namespace contourd {
namespace {

using Need = OverhangCover::Need;

constexpr double kPi = 3.14159265358979323846;
// Pixels that reach out farther than this share of the allowed reach are held together with those beyond it.
constexpr double kSoon = 0.8;
// An island of at most this area in its first layer that is gone in the next layer, or has joined a held part
// there, needs no support: a layer's light is too little to cure it.
constexpr double kSpeckMm2 = 0.005;
constexpr double kRoundingMm = 1e-6;

struct PlacedContact {
  SweepPixel at;
  std::int32_t layer;  // layer in which the material at `at` begins
  std::uint32_t body;
  ContactCause cause;
  double held_pixels;  // pixels that the contact holds in the layer for which it was placed
};

std::vector<PlateModel> on_grid(const SupportRequest& request, const SweepGrid& grid) {
  std::vector<PlateModel> models = request.models;
  for (PlateModel& model : models) {
    for (PixelMap& copy : model.copies)
      copy = copy.moved(request.display, grid.display);
  }
  return models;
}

// Returns radii that load no contact beyond its strength: a disc below a horizontal surface, and below a
// rising surface a strip as wide as may be bridged.
HoldingRadii holding_radii(const SupportSettings& settings, const SweepGrid& grid) {
  const double disc_mm = std::sqrt(settings.tip_holds_mm2 / kPi);
  const double strip_mm = settings.tip_holds_mm2 / (2 * settings.bridge.count());
  const double beneath_mm = settings.bridge.count() + settings.tip_diameter.count() / 2 - grid.pixel_mm();
  constexpr double kSlack = 0.1;
  return {std::min(beneath_mm, disc_mm) / grid.pixel_mm(),
          std::min(settings.spacing.count(), strip_mm) / grid.pixel_mm(),
          kSlack * settings.bridge.count() / grid.pixel_mm()};
}

Millimeters top_of(std::span<const PlateModel> models) {
  Millimeters top{};
  for (const PlateModel& model : models) {
    if (!model.copies.empty()) top = std::max(top, model.top());
  }
  return top;
}

class Sweep {
 public:
  explicit Sweep(const SupportRequest& request)
      : settings_(request.settings),
        layers_(request.printed.thicknesses, top_of(request.models)),
        grid_(sweep_grid(request.display, layers_.step())),
        models_(on_grid(request, grid_)),
        engine_(models_, {.display = grid_.display,
                          .anti_aliasing = AntiAliasing::Off,
                          .compensation = request.printed.compensation}),
        underside_(grid_),
        cover_(holding_radii(settings_, grid_)),
        peel_({settings_.tip_holds_mm2 / pixel_area_mm2(), settings_.tip_diameter.count() / grid_.pixel_mm()},
              settings_.spacing.count() / grid_.pixel_mm()) {
    lit_.extract(Mask(grid_.display.width, grid_.display.height));
  }

  [[nodiscard]] const SweepLayers& layers() const { return layers_; }
  [[nodiscard]] const SweepGrid& grid() const { return grid_; }
  // Adds the next layer up and returns its lit pixels, valid until the next call. If `stop` was requested,
  // the layer's contacts are incomplete.
  const MaskRuns& add_layer(const std::stop_token& stop);
  [[nodiscard]] HeldPlaces held() const;

 private:
  [[nodiscard]] double pixel_area_mm2() const { return grid_.pixel_mm() * grid_.pixel_mm(); }
  [[nodiscard]] std::int32_t tip_pixels() const {
    return static_cast<std::int32_t>(settings_.tip_diameter.count() / 2 / grid_.pixel_mm());
  }
  [[nodiscard]] Need need_of(const ReachingPixel& pixel) const;
  [[nodiscard]] bool is_speck(const LayerPart& part) const;
  [[nodiscard]] SweepPixel place_for(const OverhangCover::Choice& choice) const;
  [[nodiscard]] std::vector<SurfacePlace> places() const;
  [[nodiscard]] SupportContact contact_of(std::size_t number, const std::optional<Surface>& surface) const;
  void hold_specks();
  void hold_overhangs(const std::stop_token& stop);
  void balance_peel(const std::stop_token& stop);
  // True if there is one contact more than the maximum, which shows that the maximum was exceeded.
  [[nodiscard]] bool has_enough() const { return contacts_.size() > kMostContacts; }
  void add_contact(const PlacedContact& contact);

  SupportSettings settings_;
  SweepLayers layers_;
  SweepGrid grid_;
  std::vector<PlateModel> models_;  // their copies map to grid_
  ContourEngine engine_;
  Underside underside_;
  OverhangCover cover_;
  PeelBalance peel_;
  LayerParts parts_;
  MaskRuns lit_, beneath_;
  std::int32_t layer_ = 0;
  std::vector<SweepPixel> specks_;  // specks in the last layer
  std::vector<PlacedContact> contacts_;
};

const MaskRuns& Sweep::add_layer(const std::stop_token& stop) {
  ++layer_;
  std::swap(lit_, beneath_);
  lit_.extract(engine_.mask_at(layers_.middle_of(layer_)));
  parts_.add_layer(lit_, beneath_);
  peel_.add_layer(parts_);
  const bool rests =
      to_millimeters(layers_.bottom_of(layer_)).count() <= settings_.closed_gap.count() + kRoundingMm;
  if (rests) peel_.stand(parts_, lit_);
  underside_.add_layer({lit_, beneath_, parts_, layers_.middle_of(layer_), rests},
                       {kSoon * cover_.radii().reach * grid_.pixel_mm(), settings_.bridge.count()});
  for (const Underside::Sample& sample : underside_.samples())
    peel_.add_place({sample.at, layer_, sample.steep}, parts_.parts()[sample.part].body);
  hold_specks();
  hold_overhangs(stop);
  balance_peel(stop);
  return lit_;
}

bool Sweep::is_speck(const LayerPart& part) const {
  const double area_mm2 = static_cast<double>(part.pixels) * pixel_area_mm2();
  return layer_ > 1 && part.carried == 0 && (part.pixels == 1 || area_mm2 < kSpeckMm2);
}

// Places contacts for the last layer's specks that still hang alone.
void Sweep::hold_specks() {
  for (const SweepPixel speck : specks_) {
    if (underside_.hangs_alone(speck))
      add_contact({underside_.centered(speck, tip_pixels()), 0,
                   parts_.part_at(lit_, speck.row, speck.column).body, ContactCause::Island, 1});
  }
  specks_.clear();
}

Need Sweep::need_of(const ReachingPixel& pixel) const {
  if (pixel.bridge_mm > settings_.bridge.count()) return Need::Bridge;
  const double reach = underside_.reach_mm(pixel.at) / grid_.pixel_mm();
  if (reach > cover_.radii().reach) return Need::Reach;
  return reach > kSoon * cover_.radii().reach ? Need::Soon : Need::None;
}

// Returns the centre of the surface around the choice where that is no wider than the tip, but only once: a
// contact that holds less than its own width would otherwise get the same place again for all pixels around
// it.
SweepPixel Sweep::place_for(const OverhangCover::Choice& choice) const {
  const SweepPixel centered = underside_.centered(choice.at, tip_pixels());
  const std::int32_t layer = underside_.begins_at(centered);
  const bool is_taken = std::ranges::any_of(contacts_, [&](const PlacedContact& contact) {
    return contact.at == centered && contact.layer == layer;
  });
  return is_taken ? choice.at : centered;
}

void Sweep::hold_overhangs(const std::stop_token& stop) {
  std::vector<OverhangCover::Spot> spots;
  for (const ReachingPixel& pixel : underside_.reaching()) {
    if (is_speck(parts_.parts()[pixel.part])) {
      specks_.push_back(pixel.at);
    } else if (const Need need = need_of(pixel); need != Need::None) {
      spots.push_back(
          {pixel.at, pixel.part, need, (pixel.bridge_mm - settings_.bridge.count()) / grid_.pixel_mm()});
    }
  }
  cover_.set_spots(spots);
  while (!has_enough() && !stop.stop_requested()) {
    const std::optional<OverhangCover::Choice> choice = cover_.choose();
    if (!choice) break;
    const LayerPart& part = parts_.parts()[choice->part];
    const SweepPixel at = place_for(*choice);
    const auto held = static_cast<double>(cover_.hold(at, *choice));
    add_contact({at, 0, part.body, part.carried == 0 ? ContactCause::Island : ContactCause::Overhang, held});
  }
}

void Sweep::balance_peel(const std::stop_token& stop) {
  for (const PeelBalance::Pull& pull : peel_.pulls()) {
    while (!has_enough() && !stop.stop_requested() && peel_.overloaded(pull)) {
      const std::optional<PeelBalance::Place> place = peel_.place_against(pull);
      if (!place) break;
      add_contact({place->at, place->layer, pull.body, ContactCause::Peel, 0});
    }
  }
  peel_.settle();
}

// Adds a contact; a layer of 0 means the layer in which the material begins there.
void Sweep::add_contact(const PlacedContact& contact) {
  PlacedContact& placed = contacts_.emplace_back(contact);
  if (placed.layer == 0) placed.layer = underside_.begins_at(placed.at);
  peel_.add_contact(placed.at, placed.body);
  // A little farther than the allowed reach, which grows with the height of the material.
  constexpr double kGrowthMm = 1;
  if (underside_.is_lit(placed.at))
    underside_.hold(placed.at, cover_.radii().reach * grid_.pixel_mm() + kGrowthMm);
}

// Returns the ranges in which to look for the surface that each contact holds.
std::vector<SurfacePlace> Sweep::places() const {
  std::vector<SurfacePlace> places;
  for (const PlacedContact& placed : contacts_) {
    const double high_mm = to_millimeters(layers_.middle_of(placed.layer)).count();
    const double thickness_mm = to_millimeters(layers_.thickness_of(placed.layer)).count();
    places.push_back(
        {grid_.place_of(placed.at), high_mm - 3 * thickness_mm, high_mm, settings_.tip_diameter.count() / 2});
  }
  return places;
}

SupportContact Sweep::contact_of(std::size_t number, const std::optional<Surface>& surface) const {
  const PlacedContact& placed = contacts_[number];
  const Point place = grid_.place_of(placed.at);
  const double bottom_mm = to_millimeters(layers_.bottom_of(placed.layer)).count();
  SupportContact contact;
  contact.place = {place.x, place.y, surface ? surface->z_mm : bottom_mm};
  contact.outward = surface ? surface->outward : Direction{0, 0, -1};
  contact.cause = placed.cause;
  contact.load_mm2 = std::max(placed.held_pixels, peel_.load_pixels(number)) * pixel_area_mm2();
  return contact;
}

HeldPlaces Sweep::held() const {
  const std::vector<std::optional<Surface>> surfaces = surfaces_beneath(models_, grid_.display, places());
  HeldPlaces held;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const SupportContact contact = contact_of(i, surfaces[i]);
    // A contact below the end of the first layer lies on the plate.
    if (contact.place.z >= to_millimeters(layers_.top_of(1)).count()) held.contacts.push_back(contact);
  }
  std::ranges::stable_sort(held.contacts, {}, [](const SupportContact& contact) {
    return std::tuple(contact.place.z, contact.place.y, contact.place.x);
  });
  return held;
}

}  // namespace

std::optional<HeldPlaces> find_overhangs(const SupportRequest& request, LayerObserver& observer,
                                         const std::stop_token& stop) {
  expects(
      request.display.pixel_pitch > Micrometers{} &&
          std::ranges::all_of(request.models, [](const PlateModel& each) { return each.model != nullptr; }),
      "every model is there, and a pixel has a size");
  const Millimeters top = top_of(request.models);
  expects(top <= kHighestSweep, "the models are no higher than can be swept");
  Sweep sweep(request);
  observer.begin(sweep.grid().display, sweep.grid().step);
  const Nanometers step = sweep.grid().step;
  Nanometers middle = step / 2;
  for (std::int32_t layer = 1; layer <= sweep.layers().count(); ++layer) {
    if (stop.stop_requested()) return std::nullopt;
    const MaskRuns& lit = sweep.add_layer(stop);
    for (; middle < sweep.layers().top_of(layer); middle += step)
      observer.layer(middle, lit);
  }
  if (stop.stop_requested()) return std::nullopt;
  return sweep.held();
}

}  // namespace contourd
