#include "core/overhangs/peel_balance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr double kPulledAtOnce = 0.5;

}  // namespace

PeelBalance::PeelBalance(const TipStrength& tip, double spacing_pixels)
    : tip_(tip), spacing_pixels_(spacing_pixels) {
  expects(tip.holds_pixels > 0 && tip.diameter_pixels > 0, "a contact holds something");
}

PeelBalance::PulledArea& PeelBalance::PulledArea::operator+=(const PulledArea& other) {
  pixels += other.pixels;
  columns += other.columns;
  rows += other.rows;
  return *this;
}

PeelBalance::Pull PeelBalance::PulledArea::pull() const {
  const auto area = static_cast<double>(pixels);
  return {body,
          {kPulledAtOnce * area, static_cast<double>(columns) / area, static_cast<double>(rows) / area}};
}

void PeelBalance::add_layer(const LayerParts& parts) {
  bodies_.resize(parts.bodies());
  for (const LayerParts::Meeting& meeting : parts.meetings())
    merge(meeting.body, meeting.into);
  parts_.clear();
  for (const LayerPart& part : parts.parts())
    parts_.push_back({part.body, part.pixels, part.columns, part.rows});
  std::ranges::stable_sort(parts_, {}, &PulledArea::body);
  pulls_.clear();
  for (std::size_t first = 0, end = 0; first < parts_.size(); first = end) {
    PulledArea all{parts_[first].body};
    for (; end < parts_.size() && parts_[end].body == all.body; ++end)
      all += parts_[end];
    pulls_.push_back(all.pull());
  }
  totals_ = pulls_.size();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto shares_body = [&](std::size_t other) { return parts_[other].body == parts_[i].body; };
    if ((i > 0 && shares_body(i - 1)) || (i + 1 < parts_.size() && shares_body(i + 1)))
      pulls_.push_back(parts_[i].pull());
  }
}

void PeelBalance::merge(std::uint32_t body, std::uint32_t into) {
  Body& from = bodies_[body];
  Body& to = bodies_[into];
  to.bearings.merge(std::move(from.bearings));
  if (to.places.size() < from.places.size()) to.places.swap(from.places);
  to.places.insert(to.places.end(), from.places.begin(), from.places.end());
  from = {};
}

void PeelBalance::stand(const LayerParts& parts, const MaskRuns& lit) {
  const std::span<const LayerPart> all = parts.parts();
  for (const LayerPart& part : all)
    bodies_[part.body].bearings.clear_base();
  for (std::size_t run = 0; run < lit.runs().size(); ++run)
    bodies_[all[parts.part_of_run()[run]].body].bearings.add_base(lit.runs()[run]);
}

void PeelBalance::add_contact(SweepPixel at, std::uint32_t body) {
  bodies_[body].bearings.add_tip(at, static_cast<std::uint32_t>(contacts_.size()), tip_);
  contacts_.push_back({at});
}

void PeelBalance::add_place(const Place& place, std::uint32_t body) {
  bodies_[body].places.push_back(static_cast<std::uint32_t>(places_.size()));
  places_.push_back({place, 0, std::numeric_limits<double>::infinity()});
}

bool PeelBalance::overloaded(const Pull& pull) const {
  expects(pull.body < bodies_.size(), "the body belongs to a part of the layer");
  return !bodies_[pull.body].bearings.bear(pull.force, tip_);
}

void PeelBalance::look_at_contacts(RankedPlace& place) const {
  for (; place.contacts_seen < contacts_.size(); ++place.contacts_seen) {
    place.squared_distance =
        std::min(place.squared_distance, squared_distance(place.place.at, contacts_[place.contacts_seen].at));
  }
}

// True if a tip at the place would overlap another, which adds less than the strength of a tip.
bool PeelBalance::is_taken(RankedPlace& place) const {
  look_at_contacts(place);
  return place.squared_distance < tip_.diameter_pixels * tip_.diameter_pixels;
}

std::optional<PeelBalance::Place> PeelBalance::place_against(const Pull& pull) {
  const Body& body = bodies_[pull.body];
  const bool too_few = !body.bearings.stands() && pull.force.pixels > body.bearings.tips_hold_pixels();
  if (too_few) return farthest_place(body);
  const std::optional<Place> on_lever = place_on_lever(body, pull.force);
  return on_lever ? on_lever : strongest_place(body, pull.force);
}

std::optional<PeelBalance::Place> PeelBalance::farthest_place(const Body& body) {
  const RankedPlace* best = nullptr;
  for (const std::uint32_t number : body.places) {
    RankedPlace& place = places_[number];
    look_at_contacts(place);
    if (place.squared_distance == 0) continue;
    const bool better = best == nullptr || (place.place.steep != best->place.steep
                                                ? best->place.steep
                                                : place.squared_distance > best->squared_distance);
    if (better) best = &place;
  }
  if (best == nullptr) return std::nullopt;
  return best->place;
}

// Prefers places that lie far out along the lever, near its line, and apart from other contacts: they make
// the body yield least to the pull.
std::optional<PeelBalance::Place> PeelBalance::place_on_lever(const Body& body, const PeelPull& pull) {
  constexpr double kAside = 0.5;  // the cost of a pixel beside the line
  const BearingGroup::Lever lever = body.bearings.lever(pull);
  const RankedPlace* best = nullptr;
  double most = 0;
  for (const std::uint32_t number : body.places) {
    RankedPlace& place = places_[number];
    const double x = place.place.at.column - pull.column, y = place.place.at.row - pull.row;
    const double out = x * lever.x + y * lever.y - kAside * std::fabs(x * lever.y - y * lever.x);
    if (best != nullptr && out + spacing_pixels_ <= most) continue;
    if (is_taken(place)) continue;
    const double score = out + std::min(spacing_pixels_, std::sqrt(place.squared_distance));
    if (best != nullptr && score <= most) continue;
    most = score;
    best = &place;
  }
  const bool helps = best != nullptr &&
                     body.bearings.strain_with(best->place.at, pull, tip_) < body.bearings.strain(pull, tip_);
  return helps ? std::optional(best->place) : std::nullopt;
}

std::optional<PeelBalance::StrainAt> PeelBalance::least_strain(const Body& body, const BearingGroup& bearings,
                                                               const PeelPull& pull) {
  std::optional<StrainAt> least;
  for (const std::uint32_t number : body.places) {
    RankedPlace& place = places_[number];
    const double strain = bearings.strain_with(place.place.at, pull, tip_);
    if ((!least || strain < least->strain) && !is_taken(place)) least = {place.place, strain};
  }
  return least;
}

// Looks two tips ahead: about tips in balance, one more only helps with another one opposite.
std::optional<PeelBalance::Place> PeelBalance::strongest_place(const Body& body, const PeelPull& pull) {
  const double now = body.bearings.strain(pull, tip_);
  const std::optional<StrainAt> first = least_strain(body, body.bearings, pull);
  if (!first) return std::nullopt;
  if (first->strain < now) return first->place;
  BearingGroup more = body.bearings;
  more.add_tip(first->place.at, 0, tip_);
  const std::optional<StrainAt> second = least_strain(body, more, pull);
  return second && second->strain < now ? std::optional(first->place) : std::nullopt;
}

void PeelBalance::settle() {
  for (const Pull& pull : std::span(pulls_).first(totals_)) {
    bodies_[pull.body].bearings.for_each_tip(pull.force, [this](std::uint32_t contact, double strain) {
      double& load = contacts_[contact].load_pixels;
      load = std::max(load, std::fabs(strain) * tip_.holds_pixels);
    });
  }
}

}  // namespace contourd
