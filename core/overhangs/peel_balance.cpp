#include "core/overhangs/peel_balance.hpp"

#include <algorithm>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr double kPulledAtOnce = 0.5;

}  // namespace

PeelBalance::PeelBalance(double holds_pixels) : holds_pixels_(holds_pixels) {
  expects(holds_pixels > 0, "a contact holds something");
}

void PeelBalance::add_layer(const LayerParts& parts) {
  while (bodies_.size() < parts.bodies()) {
    Body& body = bodies_.emplace_back();
    body.merged_into = static_cast<std::uint32_t>(bodies_.size() - 1);
  }
  for (const LayerParts::Meeting& meeting : parts.meetings())
    merge(meeting.body, meeting.into);
  for (const std::uint32_t body : present_)
    bodies_[body].pixels = 0;
  present_.clear();
  for (const LayerPart& part : parts.parts()) {
    Body& body = bodies_[part.body];
    if (body.pixels == 0) present_.push_back(part.body);
    body.pixels += part.pixels;
  }
}

void PeelBalance::merge(std::uint32_t body, std::uint32_t into) {
  Body& from = bodies_[body];
  Body& to = bodies_[into];
  from.merged_into = into;
  to.stands = to.stands || from.stands;
  to.contacts += from.contacts;
  if (to.places.size() < from.places.size()) to.places.swap(from.places);
  to.places.insert(to.places.end(), from.places.begin(), from.places.end());
  from.places = {};
}

void PeelBalance::add_contact(SweepPixel at, std::uint32_t body) {
  contacts_.push_back(at);
  ++bodies_[body].contacts;
}

void PeelBalance::add_place(const Place& place, std::uint32_t body) {
  if (bodies_[body].stands) return;
  bodies_[body].places.push_back(static_cast<std::uint32_t>(places_.size()));
  places_.push_back({place, 0, std::numeric_limits<double>::infinity()});
}

double PeelBalance::pulled_pixels(const Body& body) const {
  return kPulledAtOnce * static_cast<double>(body.pixels);
}

bool PeelBalance::overloaded(std::uint32_t body) const {
  expects(body < bodies_.size(), "the body belongs to a part of the layer");
  const Body& it = bodies_[body];
  return !it.stands && pulled_pixels(it) > holds_pixels_ * static_cast<double>(it.contacts);
}

void PeelBalance::look_at_contacts(RankedPlace& place) const {
  for (; place.contacts_seen < contacts_.size(); ++place.contacts_seen) {
    place.squared_distance =
        std::min(place.squared_distance, squared_distance(place.place.at, contacts_[place.contacts_seen]));
  }
}

std::optional<PeelBalance::Place> PeelBalance::take_place(std::uint32_t body) {
  const RankedPlace* best = nullptr;
  for (const std::uint32_t number : bodies_[body].places) {
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

void PeelBalance::settle() {
  for (const std::uint32_t number : present_) {
    Body& body = bodies_[number];
    if (body.stands || body.contacts == 0) continue;
    body.load_pixels = std::max(body.load_pixels, pulled_pixels(body) / static_cast<double>(body.contacts));
  }
}

double PeelBalance::load_pixels(std::uint32_t body) const {
  double most = bodies_[body].load_pixels;
  while (bodies_[body].merged_into != body) {
    body = bodies_[body].merged_into;
    most = std::max(most, bodies_[body].load_pixels);
  }
  return most;
}

}  // namespace contourd
